"""Which nodes of a facade are alike: by what they are made of, and by size."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.facade.tree import Facade, X, Y

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SAME_SIZE = 0.05
"""Part of the larger width or height by which alike nodes may differ."""
BACKGROUND = frozenset({"", "wall", "facade", "background"})
"""Labels, in any case, of what lies between the elements of a facade."""


def types(facade: Facade) -> Ints:
    """[N] a number for each node: the same for nodes of the same label with parts of the same types in the same order.

    Sizes do not count.
    """
    numbers: dict[tuple[int, ...], int] = {}
    found = np.zeros(len(facade), dtype=np.int64)
    for node in range(len(facade) - 1, -1, -1):
        parts = found[facade.children[node]].tolist()
        key = (int(facade.label[node]), int(facade.axis[node]), *parts)
        found[node] = numbers.setdefault(key, len(numbers))
    return found


def kinds(facade: Facade) -> Ints:
    """[N] a number for each node: the same for nodes of one type with nearly the same sizes and outlines.

    Sizes of one type in ascending order fall apart where the next one is larger by more than `SAME_SIZE`. So do the
    parts of their boxes that outlines fill: an arch and a rectangle are of two kinds.
    """
    found = types(facade)
    for measure in (facade.size[:, X], facade.size[:, Y], _filled(facade)):
        found = _divided(found, measure)
    return found


def is_background(facade: Facade) -> NDArray[np.bool_]:
    """[N] whether a node is called like one of `BACKGROUND`, or not at all."""
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
