"""Lines that parts share over the whole facade, whatever its grids are.

What stands exactly above or beside each other has sides at one coordinate, and these stay one line. Elements of one
label and one size stay alike. Different lines keep their order, and softly their distances, so that a sill remains
below its window though no part lies between their sides. A facade that is only stretched satisfies all of this.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.facade.looks import look_of
from grammarlab.facade.sizes.lines import Lines, Sums
from grammarlab.facade.tree import TOLERANCE, Facade


@dataclass(frozen=True, slots=True)
class SharedLines:
    """What one axis keeps over the whole facade."""

    same: Sums
    """[R] differences of lines at one coordinate, which stay 0."""
    alike: Sums
    """[S] differences of the sizes of elements of one label and one size, which stay 0."""
    distance: Sums
    """[D] distances of neighbouring lines, > 0."""


def find_shared_lines(facade: Facade, lines: Lines, low: Floats, size: Floats) -> SharedLines:
    """The shared lines of one axis.

    Args:
        facade: the facade, with its labels.
        lines: lines of the axis.
        low: [N] original position of each node along the axis, metres.
        size: [N] its original size, metres.
    """
    tolerance = TOLERANCE * float(size[0])
    coordinate = _numbered(lines.positions(low, size), tolerance)
    order = np.argsort(coordinate, kind="stable")
    is_same = coordinate[order[1:]] == coordinate[order[:-1]]
    neighbours = np.stack([order[1:], order[:-1]], axis=1)
    difference = np.tile([1.0, -1.0], (len(neighbours), 1))
    return SharedLines(
        same=Sums(neighbours[is_same], difference[is_same]),
        alike=_alike(facade, lines, coordinate, _numbered(size, tolerance)),
        distance=Sums(neighbours[~is_same], difference[~is_same]),
    )


def _numbered(values: Floats, tolerance: float) -> Ints:
    """[K] number of each value, ascending; equal for values [K] that follow each other within a tolerance."""
    order = np.argsort(values, kind="stable")
    number = np.empty(len(values), dtype=np.int64)
    number[order] = (np.diff(values[order], prepend=values[order[:1]]) > tolerance).cumsum()
    return number


def _alike(facade: Facade, lines: Lines, coordinate: Ints, extent: Ints) -> Sums:
    """Differences of the sizes of consecutive elements of one label and one size, between different lines each."""
    is_element = np.array([not look_of(name).is_flexible for name in facade.labels] + [False])
    node = np.flatnonzero(is_element[facade.label])
    between = np.stack([facade.label, extent, coordinate[lines.low], coordinate[lines.high]])[:, node]
    _, first = np.unique(between, axis=1, return_index=True)
    node, between = node[first], between[:, first]
    is_alike = (between[:2, 1:] == between[:2, :-1]).all(axis=0)
    return lines.extent(node[1:][is_alike]).minus(lines.extent(node[:-1][is_alike]))
