"""Boxes of elements on a facade: found at holes of the wall and at points off its plane, or given."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from grammarlab.arrays import offsets_from_counts
from grammarlab.errors import FacadeError
from grammarlab.facade.templates.elements import FARTHEST, MOST_ELEMENTS, Elements, Floats, Ints
from grammarlab.facade.templates.reading.outlines import outlines

_DEEP = 0.04
"""Least distance from the wall of a point that is not part of it, metres."""
_LEAST, _MOST = 0.25, 6.0
"""Least and largest side of an element, metres."""
_MARGIN = 0.12
"""Margin of a box around its element, metres."""
_MOST_CELLS = 4_000_000


@dataclass(frozen=True, eq=False)
class FacadePlane:
    """A facade as points."""

    points: Floats
    """[P, 3] points along the facade, up, out of the wall; metres."""
    edges: Floats
    """[Q, 3] points on sharp edges of a mesh; none for a scan."""


def find_boxes(surface: FacadePlane) -> tuple[Floats, Floats]:
    """Boxes [N, 4] (left, bottom, right, top), and the points [Q, 2] on the outlines of all elements; possibly none.

    Elements are connected parts of the facade, larger than 25 cm, with points behind or in front of the wall, or
    without points, that do not touch its border.
    """
    flat, low = surface.points[:, :2], surface.points[:, :2].min(axis=0)
    wall = np.abs(surface.points[:, 2]) < _DEEP
    cell = _cell(flat[wall])
    shape = np.ceil((flat.max(axis=0) - low) / cell).astype(np.int64) + 1

    def place_of(points: Floats) -> tuple[Ints, Ints]:
        place = np.clip(((points - low) / cell).astype(np.int64), 0, shape - 1)
        return place[:, 0], place[:, 1]

    count = np.bincount(np.ravel_multi_index(place_of(flat[wall]), shape), minlength=int(shape.prod())).reshape(shape)
    # A hole of one cell is a gap between points.
    empty = np.logical_not(ndimage.binary_closing(count > 0, iterations=1))
    parts = np.asarray(ndimage.label(empty)[0])  # pyright: ignore[reportIndexIssue] its stub forgets the pair
    boxes = []
    for part in ndimage.find_objects(parts)[: 10 * MOST_ELEMENTS]:
        first = np.array([side.start for side in part])
        last = np.array([side.stop for side in part])
        size = (last - first) * cell
        inside = (first > 0).all() and (last < shape).all()
        if inside and (size >= _LEAST).all() and (size <= _MOST).all():
            boxes.append([*(low + first * cell), *(low + last * cell)])
    found = np.array(boxes).reshape(-1, 4) + _MARGIN * np.array([-1.0, -1.0, 1.0, 1.0])
    if len(surface.edges):
        return found, surface.edges[:, :2]
    border = np.logical_and(*(ndimage.binary_dilation(each, iterations=2) for each in (empty, ~empty)))
    near = border[place_of(flat)]
    points, outward = outlines(flat[wall & near], flat[~wall & near], cell)
    # Single points behind the wall are noise: an outline has a hole beyond it.
    return found, points[empty[place_of(points + cell * outward)]]


def _cell(flat: Floats) -> float:
    """Cell size such that a wall has some points in every cell, metres."""
    extent = np.maximum(np.ptp(flat, axis=0), 1e-6)
    dense = float(np.sqrt(extent.prod() / max(len(flat), 1)))
    return max(2.2 * dense, 0.02, float(np.sqrt(extent.prod() / _MOST_CELLS)))


def read_boxes(content: bytes) -> Floats:
    """[N, 4] left, bottom, right, top, metres on the facade, from a CSV file of four columns.

    Raises:
        FacadeError: If a line is not four numbers.
    """
    try:
        lines = list(csv.reader(io.StringIO(content.decode("utf-8-sig"))))
    except (UnicodeDecodeError, csv.Error) as error:
        raise FacadeError(f"Boxes: expected lines of four comma-separated numbers: {error}.") from error
    boxes: list[list[float]] = []
    for number, line in enumerate(lines, 1):
        values = [_number(each) for each in line]
        if not line or (number == 1 and not any(each is not None for each in values)):
            continue
        sides = [each for each in values if each is not None and abs(each) <= FARTHEST]
        if len(line) != 4 or len(sides) != 4 or sides[0] >= sides[2] or sides[1] >= sides[3]:
            raise FacadeError(
                f"Boxes, line {number}: expected left, bottom, right, top in metres with left < right "
                f"and bottom < top, found {line[:5]}."
            )
        boxes.append(sides)
        if len(boxes) > MOST_ELEMENTS:
            raise FacadeError(f"Boxes: expected at most {MOST_ELEMENTS:,}.")
    if not boxes:
        raise FacadeError("Boxes: found none; expected lines of left, bottom, right, top in metres.")
    return np.array(boxes)


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def cut_out(points: Floats, boxes: Floats, notes: tuple[str, ...] = ()) -> Elements:
    """The points of each box, with rows and columns from the positions of the boxes."""
    order = np.argsort(points[:, 0], kind="stable")
    across = points[order, 0]
    clouds = []
    for left, bottom, right, top in boxes.tolist():
        own = points[order[np.searchsorted(across, left) : np.searchsorted(across, right, side="right")]]
        clouds.append(own[(own[:, 1] >= bottom) & (own[:, 1] <= top)])
    middle = (boxes[:, :2] + boxes[:, 2:]) / 2
    size = np.median(boxes[:, 2:] - boxes[:, :2], axis=0)
    return Elements(
        offsets=offsets_from_counts(np.array([len(each) for each in clouds], dtype=np.int64)),
        points=np.vstack(clouds),
        low=boxes[:, :2],
        high=boxes[:, 2:],
        row=_lines(-middle[:, 1], float(size[1])),
        column=_lines(middle[:, 0], float(size[0])),
        notes=notes,
    )


def _lines(place: Floats, size: float) -> Ints:
    """[N] index of the line of each, ascending: a new one begins after a gap wider than half an element."""
    order = np.argsort(place, kind="stable")
    number = np.cumsum(np.append(0, np.diff(place[order]) > size / 2))
    found = np.empty(len(place), dtype=np.int64)
    found[order] = number
    return found
