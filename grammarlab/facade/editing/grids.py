"""Grids of a facade from sets of nodes, and relations between grids (paper 000, section 3).

Similar nodes have equal structure (`types`), or also nearly equal sizes (`kinds`).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.grid import Grid
from grammarlab.facade.looks import is_shop
from grammarlab.facade.tree import TOLERANCE, Facade, X, Y

BACKGROUND = frozenset({"", "wall", "facade", "background"})
"""Labels, in any case, of the area between the elements of a facade."""
_SAME_SIZE = 0.05
"""Largest difference of similar nodes, as a fraction of the larger width or height."""


def kinds(facade: Facade) -> Ints:
    """[N] kind of each node: equal for nodes of one type with nearly equal widths, heights and outlines.

    Ascending sizes of one type are divided where the next one is larger by more than `_SAME_SIZE`. So are the fractions
    of boxes that outlines fill: an arch and a rectangle are of two kinds.
    """
    node_kind = types(facade)
    for measure in (facade.size[:, X], facade.size[:, Y], _filled(facade)):
        node_kind = _divided(node_kind, measure)
    return node_kind


def types(facade: Facade) -> Ints:
    """[N] type of each node: equal for nodes of the same label with parts of the same types in the same order.

    Sizes are ignored.
    """
    numbers: dict[tuple[int, ...], int] = {}
    node_type = np.zeros(len(facade), dtype=np.int64)
    for node in range(len(facade) - 1, -1, -1):
        parts = node_type[facade.children[node]].tolist()
        key = (int(facade.label[node]), int(facade.axis[node]), *parts)
        node_type[node] = numbers.setdefault(key, len(numbers))
    return node_type


def toggled(facade: Facade, name: str, nodes: ArrayLike) -> Facade:
    """A facade with one grid changed: missing nodes are added, existing ones removed; an empty grid is deleted."""
    members = np.setxor1d(grid_of(facade, name).node, np.asarray(nodes, dtype=np.int64))
    return with_grid(facade, name, members) if members.size else without_grid(facade, name)


def grid_of(facade: Facade, name: str) -> Grid:
    """The grid with this name.

    Raises:
        FacadeError: If there is none; the message lists the known names.
    """
    for grid in facade.grids:
        if grid.name == name:
            return grid
    names = ", ".join(grid.name for grid in facade.grids) or "none"
    raise FacadeError(f"Unknown grid {name!r}; expected one of: {names}.")


def with_grid(facade: Facade, name: str, nodes: ArrayLike) -> Facade:
    """A facade with a grid of these nodes, which replaces any grid with this name."""
    grid = arranged(facade, name, nodes)
    if any(other.name == name for other in facade.grids):
        return replace(facade, grids=tuple(grid if other.name == name else other for other in facade.grids))
    return replace(facade, grids=(*facade.grids, grid))


def arranged(facade: Facade, name: str, nodes: ArrayLike) -> Grid:
    """The grid of a set of nodes: its rows from the top, its columns from the left.

    Raises:
        FacadeError: If there are no nodes, unknown nodes, or nodes inside each other.
    """
    node = np.unique(np.asarray(nodes, dtype=np.int64))
    if not node.size or node[0] < 0 or node[-1] >= len(facade):
        raise FacadeError(f"Grid {name}: expected nodes from 0 to {len(facade) - 1}, found {node.tolist()[:12]}.")
    # In preorder, the parts of a node follow it directly.
    nested = np.flatnonzero(node[1:] < facade.end[node[:-1]])
    if nested.size:
        outer, inner = node[nested[0]], node[nested[0] + 1]
        raise FacadeError(f"Grid {name}: node {inner} is a part of node {outer}; elements of a grid do not overlap.")
    slack = TOLERANCE * facade.size[0]
    low, high = facade.position[node] + slack, (facade.position + facade.size)[node] - slack
    return Grid(name, node, lines(-high[:, Y], -low[:, Y]), lines(low[:, X], high[:, X]))


def lines(low: Floats, high: Floats) -> Ints:
    """[E] line, from 0 for the lowest, of each of E intervals [low, high].

    The sweep of the paper: from the lowest on, an interval joins the line as long as it overlaps with all intervals of
    it. An interval that overlaps with several lines, as a door does with storeys, then moves to the line with the
    largest overlap, the last of equal ones: doors belong to lower storeys. So any two intervals of one line overlap,
    and nodes without overlap never share both a row and a column.
    """
    line = np.zeros(len(low), dtype=np.int64)
    cores: list[list[float]] = []
    for interval in np.lexsort((high, low)).tolist():
        if not cores or low[interval] >= cores[-1][1]:
            cores.append([float(low[interval]), float(high[interval])])
        cores[-1] = [max(cores[-1][0], float(low[interval])), min(cores[-1][1], float(high[interval]))]
        line[interval] = len(cores) - 1
    core = np.array(cores).reshape(-1, 2)
    overlap = np.minimum(high[:, None], core[:, 1]) - np.maximum(low[:, None], core[:, 0])
    for interval in np.flatnonzero((overlap > 0.0).sum(axis=1) > 1).tolist():
        # The cores shrink as intervals join, so only the rest of a core counts.
        remaining = np.minimum(high[interval], core[:, 1]) - np.maximum(low[interval], core[:, 0])
        line[interval] = best = int(np.flatnonzero(remaining >= remaining.max() * (1.0 - 1e-6))[-1])
        core[best] = max(core[best, 0], low[interval]), min(core[best, 1], high[interval])
    return np.unique(line, return_inverse=True)[1]


def without_grid(facade: Facade, name: str) -> Facade:
    """A facade without one of its grids."""
    removed = grid_of(facade, name)
    return replace(facade, grids=tuple(grid for grid in facade.grids if grid is not removed))


def lasso(facade: Facade, low: ArrayLike, high: ArrayLike, label: str | None = None) -> Ints:
    """The topmost labelled nodes that are entirely inside a rectangle.

    Args:
        facade: the facade.
        low: [2] metres, one corner.
        high: [2] metres, the opposite corner.
        label: label of the nodes; any label except those of the background by default.
    """
    corners = np.sort([np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)], axis=0)
    slack = TOLERANCE * facade.size[0]
    inside = (facade.position >= corners[0] - slack) & (facade.position + facade.size <= corners[1] + slack)
    has_label = ~is_background(facade) if label is None else np.array(["", *facade.labels])[facade.label + 1] == label
    return topmost(facade, inside.all(axis=1) & has_label)


def single_shops(facade: Facade) -> Flags:
    """[N] whether a leaf is a shop window beside which no other one begins; several in a row are a band."""
    shops = facade.leaves[np.array([*(is_shop(name) for name in facade.labels), False])[facade.label[facade.leaves]]]
    # In sizes of the facade, one tolerance holds along both axes.
    low = facade.position[shops] / facade.size[0]
    high = low + facade.size[shops] / facade.size[0]
    boxes = shapely.box(*low.T, *high.T)
    touching = shapely.STRtree(boxes).query_nearest(boxes, max_distance=TOLERANCE, exclusive=True, all_matches=False)[0]
    result = np.zeros(len(facade), dtype=bool)
    result[shops] = True
    result[shops[touching]] = False
    return result


def is_background(facade: Facade) -> NDArray[np.bool_]:
    """[N] whether a node's label is one of `BACKGROUND`, or empty."""
    plain = np.array([name.lower() in BACKGROUND for name in facade.labels] + [True])
    return plain[facade.label]


def topmost(facade: Facade, chosen: Flags) -> Ints:
    """The chosen nodes that are not inside another chosen one, ascending."""
    top, end = [], 0
    for node in np.flatnonzero(chosen).tolist():
        if node >= end:
            top.append(node)
            end = int(facade.end[node])
    return np.array(top, dtype=np.int64)


def following(facade: Facade, name: str) -> tuple[str, ...]:
    """The other grids with the same numbers of rows and columns and of elements of each type (`types`)."""
    grid, kind = grid_of(facade, name), types(facade)

    def counts(candidate: Grid) -> tuple[int, int, Counter[int]]:
        return candidate.num_rows, candidate.num_columns, Counter(kind[candidate.node].tolist())

    signature = counts(grid)
    return tuple(other.name for other in facade.grids if other is not grid and counts(other) == signature)


def aligned(facade: Facade, name: str, axis: int) -> tuple[str, ...]:
    """The other grids whose columns (or rows) are aligned one by one with those of a grid, as sills with windows.

    Args:
        facade: a facade with the grids.
        name: name of the grid.
        axis: X for columns, Y for rows.
    """
    reference = grid_of(facade, name)

    def extents(grid: Grid) -> Floats:
        line = grid.column if axis == X else grid.row
        low, size = facade.position[grid.node, axis], facade.size[grid.node, axis]
        count = int(line.max(initial=-1)) + 1
        starts, ends = np.full(count, np.inf), np.full(count, -np.inf)
        np.minimum.at(starts, line, low)
        np.maximum.at(ends, line, low + size)
        return np.stack([starts, ends])

    extent = extents(reference)
    names = []
    for other in facade.grids:
        other_extent = extents(other)
        if other is not reference and other_extent.shape == extent.shape and not _nested(facade, reference, other):
            # Each line overlaps with the line of the same number and with no other.
            overlap = np.minimum(extent[1][:, None], other_extent[1]) - np.maximum(extent[0][:, None], other_extent[0])
            if np.array_equal(overlap > TOLERANCE * facade.size[0, axis], np.eye(len(overlap), dtype=np.bool_)):
                names.append(other.name)
    return tuple(names)


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
    new = (group[1:] != group[:-1]) | (size[1:] * (1.0 - _SAME_SIZE) > size[:-1])
    kind = np.empty(len(order), dtype=np.int64)
    kind[order] = np.append(0, new.cumsum())
    return kind


def _nested(facade: Facade, one: Grid, other: Grid) -> bool:
    """Whether an element of either grid contains or equals one of the other."""
    inside = (one.node[:, None] <= other.node) & (other.node < facade.end[one.node][:, None])
    around = (other.node <= one.node[:, None]) & (one.node[:, None] < facade.end[other.node])
    return bool((inside | around).any())
