"""Labelled boxes on one facade, as in a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.values import is_unicode

MOST_BOXES = 100_000
"""Largest number of boxes of a facade."""
FARTHEST = 1e9
"""Largest valid coordinate, in any unit."""
LONGEST_NAME = 200
"""Largest number of characters of a label."""
BACKGROUND = ("facade", "wall", "background")
"""Labels of boxes that only mark the area of the wall."""

Unit = Literal["metres", "pixels", "parts"]


@dataclass(frozen=True, slots=True)
class BoxAnnotation:
    """N boxes that may overlap, leave gaps or nearly touch; x to the right, y up."""

    low: Floats
    """[N, 2] lower left corners."""
    high: Floats
    """[N, 2] upper right corners, greater than `low`."""
    names: tuple[str, ...]
    """[N] labels."""
    number: Ints
    """[N] number of each box on its facade, from 1, in the order of the file."""
    outlines: tuple[Floats, ...]
    """[N] corners [P, 2] of outlines that are not rectangular, in the units of the boxes; empty otherwise."""
    frame: Floats
    """[2, 2] lower left and upper right corner of the facade."""
    unit: Unit
    """Unit of all coordinates; `parts` are fractions of the width and the height of a picture."""
    picture: str
    """File name of the picture under the boxes; empty for none."""
    picture_area: Floats
    """[2, 2] lower left and upper right corner of the picture."""
    wall: Floats
    """[P, 2] corners of the outline of the wall; empty if the wall fills the frame."""
    notes: tuple[str, ...]
    """Notes for the user on the reading of the file."""


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
    """Checked boxes; boxes without size are left out, boxes that extend beyond the bounds are clipped.

    Args:
        boxes: [N, 4] left, bottom, right, top.
        names: [N] labels.
        unit: unit of the coordinates.
        outlines: [N] corners [P, 2] of each outline that is not rectangular, empty otherwise; left out if all
            boxes are rectangles.
        bounds: [2, 2] area of the picture, or the box around the wall; no limits when left out.
        picture: name of the picture file that fills the bounds.
        wall: [P, 2] corners of the outline of the wall; with a wall, the facade fills the bounds, otherwise the box
            around all boxes.
        notes: notes so far.

    Raises:
        FacadeError: If numbers are not finite or too large, sizes are negative, boxes are outside, or there are too
            many boxes or none.
    """
    check_count(len(boxes))
    boxes = np.asarray(boxes, dtype=np.float64).reshape(-1, 4)
    _check_numbers(boxes, names)
    remarks = list(notes)
    if bounds is not None:
        boxes = _within(boxes, names, bounds, remarks)
    empty = np.any(boxes[:, 2:] <= boxes[:, :2], axis=1)
    if empty.any():
        remarks.append(
            f"{int(empty.sum())} boxes without width or height are left out: {_box_text(boxes, names, empty)}"
        )
    nonempty = np.flatnonzero(~empty)
    low, high = boxes[nonempty, :2], boxes[nonempty, 2:]
    if wall is not None and bounds is not None:
        frame = bounds
    elif len(nonempty):
        frame = np.stack([low.min(axis=0), high.max(axis=0)])
    else:
        raise FacadeError("There is no box with a width and a height in this file.")
    return BoxAnnotation(
        low=low,
        high=high,
        names=tuple(names[box] for box in nonempty.tolist()),
        number=nonempty + 1,
        outlines=tuple(outlines[box] if outlines else np.zeros((0, 2)) for box in nonempty.tolist()),
        frame=frame,
        unit=unit,
        picture=picture,
        picture_area=frame if bounds is None else bounds,
        wall=np.zeros((0, 2)) if wall is None else wall,
        notes=tuple(remarks),
    )


def _within(boxes: Floats, names: Sequence[str], bounds: Floats, notes: list[str]) -> Floats:
    """Boxes clipped to the bounds."""
    outside = np.any((boxes[:, :2] > bounds[1]) | (boxes[:, 2:] < bounds[0]), axis=1)
    if outside.any():
        raise FacadeError(f"{_box_text(boxes, names, outside)} is outside the picture or wall, {_area_text(bounds)}.")
    inside = np.clip(boxes, np.tile(bounds[0], 2), np.tile(bounds[1], 2))
    jutting = (inside != boxes).any(axis=1)
    if jutting.any():
        notes.append(f"{int(jutting.sum())} boxes extend beyond the picture or wall and are clipped")
    return inside


def check_count(number: int) -> None:
    """Refuses too many boxes before they are processed.

    Raises:
        FacadeError: If there are more than `MOST_BOXES`.
    """
    if number > MOST_BOXES:
        raise FacadeError(f"There are {number:,} boxes; a facade has at most {MOST_BOXES:,}.")


def _check_numbers(boxes: Floats, names: Sequence[str]) -> None:
    if (invalid := np.any(~np.isfinite(boxes), axis=1)).any():
        raise FacadeError(f"{_box_text(boxes, names, invalid)} has a coordinate that is not a finite number.")
    if (invalid := np.any(np.abs(boxes) > FARTHEST, axis=1)).any():
        raise FacadeError(f"{_box_text(boxes, names, invalid)} has a coordinate beyond {FARTHEST:g}.")
    if (invalid := np.array([len(name) > LONGEST_NAME for name in names], dtype=bool)).any():
        raise FacadeError(f"{_box_text(boxes, names, invalid)}: a label has at most {LONGEST_NAME} characters.")
    if (invalid := np.array([not is_unicode(name) for name in names], dtype=bool)).any():
        raise FacadeError(f"{_box_text(boxes, names, invalid)}: expected Unicode text, found half of a character.")
    if (invalid := np.any(boxes[:, 2:] < boxes[:, :2], axis=1)).any():
        raise FacadeError(f"{_box_text(boxes, names, invalid)} has a negative width or height.")


def _box_text(boxes: Floats, names: Sequence[str], mask: NDArray[Any]) -> str:
    """The first of some boxes, in words."""
    first = int(np.flatnonzero(mask)[0])
    name = "".join(letter if letter.isprintable() else "\ufffd" for letter in names[first][:40])
    return f"Box {first + 1} ({name or 'without label'}: {_area_text(boxes[first].reshape(2, 2))})"


def _area_text(area: Floats) -> str:
    (left, bottom), (right, top) = area.tolist()
    return f"from ({left:.6g}, {bottom:.6g}) to ({right:.6g}, {top:.6g})"
