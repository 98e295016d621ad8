"""Labelled boxes on one facade, as a file has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import Floats, Ints

MOST_BOXES = 100_000
FARTHEST = 1e9
"""Largest coordinate that means something, in whatever unit."""
LONGEST_NAME = 200
BACKGROUND = ("facade", "wall", "background")
"""Labels of boxes that say where there is wall, and nothing else."""

Unit = Literal["metres", "pixels", "parts"]


@dataclass(frozen=True, slots=True)
class BoxAnnotation:
    """N boxes that may overlap, leave gaps or nearly touch; x to the right, y up."""

    low: Floats
    """[N, 2] lower left corners."""
    high: Floats
    """[N, 2] upper right corners, greater than `low`."""
    names: tuple[str, ...]
    """[N]"""
    number: Ints
    """[N] which box of its facade each is, from 1, in the order of the file."""
    outlines: tuple[Floats, ...]
    """[N] corners [P, 2] of what is not rectangular, in the units of the boxes; empty otherwise."""
    frame: Floats
    """[2, 2] lower left and upper right corner of the facade."""
    unit: Unit
    """Of all coordinates; `parts` are those of the width and the height of a picture."""
    picture: str
    """File name of the picture that the boxes were drawn on; empty for none."""
    picture_area: Floats
    """[2, 2] lower left and upper right corner of the picture."""
    wall: Floats
    """[P, 2] corners of a wall that has an outline of its own; empty for what the frame fills."""
    notes: tuple[str, ...]
    """What a person should know of how the file was read."""


def annotate(
    boxes: Floats,
    names: Sequence[str],
    unit: Unit,
    *,
    outlines: Sequence[Floats] = (),
    bounds: Floats | None = None,
    picture: str = "",
    wall: Floats | None = None,
    notes: Sequence[str] = (),
) -> BoxAnnotation:
    """Boxes that are checked, those without size left out, those that jut out cut off.

    Args:
        boxes: [N, 4] left, bottom, right, top.
        names: [N]
        unit: of the numbers.
        outlines: [N] as in `BoxAnnotation`; none for rectangles only.
        bounds: [2, 2] where boxes may be: the picture, or the box around the wall; anywhere when left out.
        picture: file name of the picture that fills the bounds.
        wall: as in `BoxAnnotation`; where there is one, the facade is all of the bounds, else what the boxes span.
        notes: what is known already.

    Raises:
        FacadeError: for numbers that are not finite or too large, negative sizes, boxes outside, too many boxes, or
            none.
    """
    check_count(len(boxes))
    boxes = np.asarray(boxes, dtype=np.float64).reshape(-1, 4)
    _check_numbers(boxes, names)
    said = list(notes)
    if bounds is not None:
        boxes = _within(boxes, names, bounds, said)
    empty = np.any(boxes[:, 2:] <= boxes[:, :2], axis=1)
    if empty.any():
        said.append(f"{int(empty.sum())} boxes without width or height are left out: {_told(boxes, names, empty)}")
    kept = np.flatnonzero(~empty)
    low, high = boxes[kept, :2], boxes[kept, 2:]
    if wall is not None and bounds is not None:
        frame = bounds
    elif len(kept):
        frame = np.stack([low.min(axis=0), high.max(axis=0)])
    else:
        raise FacadeError("There is no box with a width and a height in this file.")
    return BoxAnnotation(
        low=low,
        high=high,
        names=tuple(names[each] for each in kept.tolist()),
        number=kept + 1,
        outlines=tuple(outlines[each] if outlines else np.zeros((0, 2)) for each in kept.tolist()),
        frame=frame,
        unit=unit,
        picture=picture,
        picture_area=frame if bounds is None else bounds,
        wall=np.zeros((0, 2)) if wall is None else wall,
        notes=tuple(said),
    )


def _within(boxes: Floats, names: Sequence[str], bounds: Floats, notes: list[str]) -> Floats:
    """Boxes without what juts out of the bounds."""
    outside = np.any((boxes[:, :2] > bounds[1]) | (boxes[:, 2:] < bounds[0]), axis=1)
    if outside.any():
        raise FacadeError(f"{_told(boxes, names, outside)} lies outside the picture or wall, {_told_area(bounds)}.")
    inside = np.clip(boxes, np.tile(bounds[0], 2), np.tile(bounds[1], 2))
    jutting = (inside != boxes).any(axis=1)
    if jutting.any():
        notes.append(f"{int(jutting.sum())} boxes jut out of the picture or wall and are cut off there")
    return inside


def check_count(number: int) -> None:
    """Refuses too many boxes, before more is made of them.

    Raises:
        FacadeError: when there are more than `MOST_BOXES`.
    """
    if number > MOST_BOXES:
        raise FacadeError(f"There are {number:,} boxes; a facade has at most {MOST_BOXES:,}.")


def _check_numbers(boxes: Floats, names: Sequence[str]) -> None:
    if (wrong := np.any(~np.isfinite(boxes), axis=1)).any():
        raise FacadeError(f"{_told(boxes, names, wrong)} has a coordinate that is not a finite number.")
    if (wrong := np.any(np.abs(boxes) > FARTHEST, axis=1)).any():
        raise FacadeError(f"{_told(boxes, names, wrong)} has a coordinate beyond {FARTHEST:g}.")
    if (wrong := np.array([len(name) > LONGEST_NAME for name in names], dtype=bool)).any():
        raise FacadeError(f"{_told(boxes, names, wrong)}: a label has at most {LONGEST_NAME} characters.")
    if (wrong := np.any(boxes[:, 2:] < boxes[:, :2], axis=1)).any():
        raise FacadeError(f"{_told(boxes, names, wrong)} has a negative width or height.")


def _told(boxes: Floats, names: Sequence[str], which: NDArray[Any]) -> str:
    """The first of some boxes, in words."""
    first = int(np.flatnonzero(which)[0])
    return f"Box {first + 1} ({names[first][:40] or 'without label'}: {_told_area(boxes[first].reshape(2, 2))})"


def _told_area(area: Floats) -> str:
    (left, bottom), (right, top) = area.tolist()
    return f"from ({left:.6g}, {bottom:.6g}) to ({right:.6g}, {top:.6g})"
