"""The neighbourhood graph of a facade: pairs of leaves that touch, and the inverse, a tree (paper 000, section 4)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from grammarlab.arrays import Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.tree import LEAF, TOLERANCE, Facade, X, Y

_MOST_NAMED = 12
"""Largest number of nodes in an error message."""


@dataclass(frozen=True, slots=True)
class Neighbours:
    """L leaves and pairs that share a piece of boundary; a common corner is not enough."""

    node: Ints
    """[L] node of the facade, ascending."""
    x_pairs: Ints
    """[H, 2] left and right leaf of each shared vertical piece, as indices into `node`."""
    y_pairs: Ints
    """[V, 2] lower and upper leaf of each shared horizontal piece, as indices into `node`."""


@dataclass(frozen=True, slots=True)
class Topology:
    """A decomposition tree without sizes, in the order of `Facade`."""

    parent: Ints
    """[N] parent of each node, as in `Facade`; -1 for the root."""
    axis: NDArray[np.int8]
    """[N] axis along which each node is divided, as in `Facade`."""
    leaf: Ints
    """[N] leaf of the graph of each node; -1 for inner nodes."""


def neighbours(facade: Facade) -> Neighbours:
    """The graph of a facade's leaves.

    Common pieces of boundary up to `TOLERANCE` of the facade are corners. The time grows with the number of edges,
    since only leaves on the two sides of one line between siblings are compared.
    """
    return Neighbours(facade.leaves, *(_touching(facade, along) for along in (X, Y)))


def _touching(facade: Facade, along: int) -> Ints:
    """[E, 2] lower and upper leaf, along an axis, of each shared piece of boundary."""
    number = np.full(len(facade), -1, dtype=np.int64)
    number[facade.leaves] = np.arange(len(facade.leaves))
    low, size = facade.position[:, 1 - along], facade.size[:, 1 - along]
    tolerance = TOLERANCE * float(facade.size[0, 1 - along])
    first, last = _sides(facade, along)
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    for node in np.flatnonzero(facade.axis == along).tolist():
        parts = facade.children[node].tolist()
        for low_part, high_part in pairwise(parts):
            lower, upper = last[low_part], first[high_part]
            # Both lists are sorted and without gaps: the partners of each leaf are one run of the other list.
            begin = np.searchsorted((low + size)[upper], low[lower] + tolerance, side="right")
            end = np.searchsorted(low[upper], (low + size)[lower] - tolerance, side="left")
            counts = end - begin
            within = np.arange(counts.sum()) - np.repeat(counts.cumsum() - counts, counts)
            pairs.append(np.stack([np.repeat(lower, counts), upper[np.repeat(begin, counts) + within]], axis=1))
    return number[np.concatenate(pairs)]


def _sides(facade: Facade, along: int) -> tuple[list[Ints], list[Ints]]:
    """[N] for each node, its leaves at the low and at the high side along an axis, ascending across it."""
    first: list[Ints] = [np.array([node]) for node in range(len(facade))]
    last = list(first)
    for node in range(len(facade) - 1, -1, -1):
        parts = facade.children[node].tolist()
        if facade.axis[node] == along:
            first[node], last[node] = first[parts[0]], last[parts[-1]]
        elif facade.axis[node] != LEAF:
            first[node] = np.concatenate([first[part] for part in parts])
            last[node] = np.concatenate([last[part] for part in parts])
    return first, last


def tree_of(graph: Neighbours) -> Topology:
    """The decomposition tree of a graph.

    A line through the whole wall separates leaves that no vertical neighbourhood connects, and only such a line does:
    the leaves on one vertical line are connected from the bottom to the top. So the parts of a node along x are the
    connected components of the vertical edges, along y those of the horizontal ones. This finds every tree; collapsing
    chains one after the other does not. If lines through the whole facade cross, its first division is along y, as in
    `cutting.cut`: the graph does not determine it, and the leaves are the same either way.

    Raises:
        FacadeError: If neither axis has a line, because the leaves form a pinwheel; or if the edges are not those of a
            facade, for example if a leaf is both to the left and to the right of another.
    """
    parent: list[int] = []
    axis: list[int] = []
    leaf: list[int] = []
    pending = [(np.arange(len(graph.node)), (graph.x_pairs, graph.y_pairs), -1, LEAF)]
    while pending:
        leaves, edges, above, divided = pending.pop()
        parent.append(above)
        leaf.append(int(leaves[0]) if len(leaves) == 1 else -1)
        along, part, order = _parts(graph.node, leaves, edges, divided)
        axis.append(along)
        members = _grouped(leaves, part, len(order))
        inside = [_grouped(links, _part_of_edges(part, leaves, links), len(order)) for links in edges]
        pending += [
            (members[index], (inside[X][index], inside[Y][index]), len(parent) - 1, along) for index in reversed(order)
        ]
    return Topology(np.array(parent), np.array(axis, dtype=np.int8), np.array(leaf))


def _parts(node: Ints, leaves: Ints, edges: tuple[Ints, Ints], divided: int) -> tuple[int, Ints, list[int]]:
    """The axis along which some leaves are divided, the part of each, and the order of the parts."""
    if len(leaves) == 1:
        return LEAF, np.zeros(1, dtype=np.int64), []
    inside = [np.searchsorted(leaves, links) for links in edges]
    for along in (Y, X):
        num_parts, part = _components(inside[1 - along], len(leaves))
        if along != divided and num_parts > 1:
            order = _chain(part[inside[along]], num_parts)
            if order is None:
                raise FacadeError(
                    f"The neighbours contradict each other at nodes {_named(node[leaves])}: their parts are not "
                    f"in order {'from the left to the right' if along == X else 'from the bottom to the top'}."
                )
            return along, part, order
    raise FacadeError(
        f"Nodes {_named(node[leaves])} form a pinwheel: no straight cut through all of them leaves each of them "
        "whole. Merge or divide some of these boxes."
    )


def _part_of_edges(part: Ints, leaves: Ints, edges: Ints) -> Ints:
    """[E] part that contains an edge; -1 for edges between two."""
    ends = part[np.searchsorted(leaves, edges)]
    return np.where(ends[:, 0] == ends[:, 1], ends[:, 0], -1)


def _grouped(rows: Ints, group: Ints, size: int) -> list[Ints]:
    """The rows of each group from 0 to size - 1, in their order."""
    order = np.argsort(group, kind="stable")
    return np.split(rows[order], np.searchsorted(group[order], np.arange(size + 1)))[1:-1]


def _components(edges: Ints, size: int) -> tuple[int, Ints]:
    links = coo_array((np.ones(len(edges), dtype=np.int8), (edges[:, 0], edges[:, 1])), shape=(size, size))
    num_parts, part = connected_components(links, directed=False)
    return int(num_parts), part


def _chain(edges: Ints, size: int) -> list[int] | None:
    """The only order in which the parts touch, each the next one; None if their edges do not form a chain."""
    links = np.unique(edges[edges[:, 0] != edges[:, 1]], axis=0)
    after = dict(links.tolist())
    starts = np.setdiff1d(np.arange(size), links[:, 1])
    if len(links) != size - 1 or len(after) != size - 1 or len(starts) != 1:
        return None
    order = [int(starts[0])]
    while order[-1] in after:
        order.append(after[order[-1]])
    return order if len(order) == size else None


def _named(nodes: Ints) -> str:
    text = ", ".join(str(node) for node in nodes[:_MOST_NAMED].tolist())
    return text if len(nodes) <= _MOST_NAMED else f"{text} and {len(nodes) - _MOST_NAMED} more"
