"""Elements of a facade on common lines, in front of its wall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.grids.kinds import BACKGROUND
from grammarlab.facade.tree import Facade, Floats, Ints, X, Y

Interval = tuple[int, int]
"""Indices of the first and last line along an axis."""


@dataclass(frozen=True, eq=False)
class LabelledRectangles:
    """E labelled rectangles between lines."""

    lines: tuple[Floats, Floats]
    """Coordinates along x and y, metres, ascending, from 0 to the end of the facade."""
    boxes: Ints
    """[E, 4] line indices of left, bottom, right, top."""
    labels: tuple[str, ...]
    """[E] labels."""
    backdrop: str | None
    """Label of the wall behind them; None if there is none."""

    def interval(self, element: int, axis: int) -> Interval:
        """Interval of an element along an axis."""
        return int(self.boxes[element, axis]), int(self.boxes[element, axis + 2])


def backdrop_of(facade: Facade) -> str | None:
    """The background label that covers the most area of a facade; None if no leaf is background."""
    area: dict[str, float] = {}
    for leaf in facade.leaves.tolist():
        name = facade.name_of(leaf)
        if name.lower() in BACKGROUND:
            area[name] = area.get(name, 0.0) + float(facade.size[leaf].prod())
    return max(area, key=lambda name: (area[name], name)) if area else None


def elements_of(facade: Facade, tolerance: float) -> LabelledRectangles:
    """All leaves of a facade that are not its backdrop.

    Args:
        facade: the facade.
        tolerance: largest distance of sides on one line, metres; thinner leaves are left out.
    """
    backdrop = backdrop_of(facade)
    leaves = np.array([leaf for leaf in facade.leaves.tolist() if facade.name_of(leaf) != backdrop], dtype=np.int64)
    low = facade.position[leaves]
    sides = np.concatenate([low, low + facade.size[leaves]], axis=1).reshape(-1, 4)
    lines, boxes = [], np.zeros(sides.shape, dtype=np.int64)
    for axis in (X, Y):
        found, place = _lines(sides[:, axis::2].ravel(), float(facade.size[0, axis]), tolerance)
        lines.append(found)
        boxes[:, axis::2] = place.reshape(-1, 2)
    kept = (boxes[:, :2] < boxes[:, 2:]).all(axis=1)
    labels = tuple(facade.name_of(leaf) for leaf in leaves[kept].tolist())
    return LabelledRectangles((lines[X], lines[Y]), boxes[kept], labels, backdrop)


def grouped(values: Floats, tolerance: float) -> Ints:
    """[N] a group number for each value, in ascending order; values of one group differ by at most the tolerance."""
    order = np.argsort(values, kind="stable")
    number, first, found = -1, -np.inf, np.zeros(len(values), dtype=np.int64)
    for place in order.tolist():
        if values[place] - first > tolerance:
            number, first = number + 1, values[place]
        found[place] = number
    return found


def _lines(values: Floats, end: float, tolerance: float) -> tuple[Floats, Ints]:
    """Means of groups of values, and the line of each value; 0 and the end are lines."""
    inside = np.where(values <= tolerance, 0.0, np.where(values >= end - tolerance, end, values))
    inside = np.concatenate([[0.0, end], inside])
    number = grouped(inside, tolerance)
    lines = np.bincount(number, inside) / np.bincount(number)
    lines[0], lines[-1] = 0.0, end
    return lines, number[2:]
