"""Similar nodes of a facade: equal structure, and equal size."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.facade.tree import Facade, X, Y

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SAME_SIZE = 0.05
"""Largest difference of similar nodes, as a fraction of the larger width or height."""
BACKGROUND = frozenset({"", "wall", "facade", "background"})
"""Labels, in any case, of the area between the elements of a facade."""


def types(facade: Facade) -> Ints:
    """[N] type of each node: equal for nodes of the same label with parts of the same types in the same order.

    Sizes are ignored.
    """
    numbers: dict[tuple[int, ...], int] = {}
    found = np.zeros(len(facade), dtype=np.int64)
    for node in range(len(facade) - 1, -1, -1):
        parts = found[facade.children[node]].tolist()
        key = (int(facade.label[node]), int(facade.axis[node]), *parts)
        found[node] = numbers.setdefault(key, len(numbers))
    return found


def kinds(facade: Facade) -> Ints:
    """[N] kind of each node: equal for nodes of one type with nearly equal widths, heights and outlines.

    Ascending sizes of one type are divided where the next one is larger by more than `SAME_SIZE`. So are the fractions
    of boxes that outlines fill: an arch and a rectangle are of two kinds.
    """
    found = types(facade)
    for measure in (facade.size[:, X], facade.size[:, Y], _filled(facade)):
        found = _divided(found, measure)
    return found


def is_background(facade: Facade) -> NDArray[np.bool_]:
    """[N] whether a node's label is one of `BACKGROUND`, or empty."""
    plain = np.array([name.lower() in BACKGROUND for name in facade.labels] + [True])
    return plain[facade.label]


def _filled(facade: Facade) -> Floats:
    """[N] the part of its box that the outline of a leaf fills; of other nodes the least of their leaves."""
    filled = np.ones(len(facade))
    for leaf in np.flatnonzero(np.diff(facade.outline_offsets)).tolist():
        filled[leaf] = shapely.Polygon(facade.outline(leaf)).area
    for node in range(len(facade) - 1, 0, -1):
        above = facade.parent[node]
        filled[above] = min(filled[above], filled[node])
    return filled


def _divided(group: Ints, size: Floats) -> Ints:
    order = np.lexsort((size, group))
    group, size = group[order], size[order]
    new = (group[1:] != group[:-1]) | (size[1:] * (1.0 - SAME_SIZE) > size[:-1])
    found = np.empty(len(order), dtype=np.int64)
    found[order] = np.append(0, new.cumsum())
    return found
