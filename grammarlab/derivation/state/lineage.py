"""Nodes of two derivations of the same models that have the same place in their trees.

Spatial queries compare shapes with those of an earlier derivation, except with their own ancestors and descendants.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.randomness import fold

Ids = NDArray[np.int32]


class Tree(NamedTuple):
    """N nodes of a finished derivation."""

    path: NDArray[np.uint64]
    """[N] hash of the successors from the root to each node; equal places have equal paths."""
    parent: Ids
    """[N] parents, -1 for roots."""
    depth: Ids
    """[N] 0 for roots."""


class Lineage:
    """Paths of nodes as they are made, and the corresponding nodes of an earlier derivation."""

    def __init__(self, earlier: Tree | None = None) -> None:
        """Begin without nodes.

        Args:
            earlier: a finished derivation of the same models, if there is one.
        """
        self._used = 0
        self._path = np.zeros(64, dtype=np.uint64)
        self._parent = np.full(64, -1, dtype=np.int32)
        self._depth = np.zeros(64, dtype=np.int32)
        self.nearest: Ids = np.full(64, -1, dtype=np.int32)
        """[N] the node of the earlier derivation in the same place, or its nearest ancestor that exists there."""
        self.is_same: NDArray[np.bool_] = np.zeros(64, dtype=bool)
        """[N] whether a node exists there."""
        self._order = None if earlier is None else np.argsort(earlier.path, kind="stable")
        self._sorted = np.zeros(0, np.uint64) if earlier is None else earlier.path[self._order]

    def add_roots(self, models: Ids) -> None:
        """Add the roots of models [N]."""
        self._add(fold(np.zeros(len(models), np.uint64), models.astype(np.uint64)), np.full(len(models), -1, np.int32))

    def add_children(self, parents: Ids, child: int, repeat: Ids | None) -> None:
        """Add children [N] of nodes, made by the successor number ``child`` of their rule."""
        repeats = np.zeros(len(parents), np.uint64) if repeat is None else repeat.astype(np.uint64)
        self._add(fold(fold(self._path[parents], child), repeats), parents)

    def tree(self) -> Tree:
        """All nodes."""
        used = slice(0, self._used)
        return Tree(self._path[used], self._parent[used], self._depth[used])

    def _add(self, path: NDArray[np.uint64], parents: Ids) -> None:
        first, end = self._used, self._used + len(path)
        if end > len(self._path):
            for name in ("_path", "_parent", "_depth", "nearest", "is_same"):
                column = getattr(self, name)
                grown = np.zeros(max(2 * len(column), end), dtype=column.dtype)
                grown[:first] = column[:first]
                setattr(self, name, grown)
        is_root = parents < 0
        self._path[first:end], self._parent[first:end] = path, parents
        self._depth[first:end] = np.where(is_root, 0, self._depth[parents] + 1)
        if self._order is not None and len(self._sorted):
            where = np.minimum(np.searchsorted(self._sorted, path), len(self._sorted) - 1)
            is_same = (self._sorted[where] == path) & (is_root | self.is_same[parents])
            self.is_same[first:end] = is_same
            self.nearest[first:end] = np.where(is_same, self._order[where], self.nearest[parents])
        self._used = end


def intervals(tree: Tree) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Places of nodes [N] in a walk through their trees, and the ends of their subtrees in it.

    Node i is an ancestor of node j, or the same, if ``begin[i] <= begin[j] < end[i]``.
    """
    count = len(tree.parent)
    size = np.ones(count, dtype=np.int64)
    levels = [np.flatnonzero(tree.depth == depth) for depth in range(int(tree.depth.max(initial=-1)) + 1)]
    for rows in reversed(levels[1:]):
        np.add.at(size, tree.parent[rows], size[rows])
    begin = np.zeros(count, dtype=np.int64)
    for rows in levels:
        order = rows[np.argsort(tree.parent[rows], kind="stable")]
        before = np.cumsum(size[order]) - size[order]
        parents = tree.parent[order]
        is_first = np.append(True, parents[1:] != parents[:-1]) if len(order) else np.zeros(0, dtype=bool)
        start_of_group = before[is_first][np.cumsum(is_first) - 1]
        base = np.where(parents < 0, 0, begin[np.maximum(parents, 0)] + 1)
        begin[order] = base + before - np.where(parents < 0, 0, start_of_group)
    return begin, begin + size
