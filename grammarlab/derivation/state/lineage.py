"""Places of nodes in their trees: those that are the same in two derivations, and numbers of children.

Spatial queries compare shapes with those of an earlier derivation, except with their own ancestors and descendants.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.randomness import fold

Ids = NDArray[np.int32]
PART = "part in its rule"
"""Name in `Shapes.state` of the ids of parts of `SiblingOrder`; no attribute can have it."""
NO_PART = -1


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


class SiblingOrder:
    """Numbers of nodes among the children of their parents, in the order in which one shape makes them.

    Nodes are made column by column: first what one successor makes of all parts, then what the next one makes. A shape
    makes them part by part. So each part of a block has an id with the part around it, the number of the first
    successor in the block, and its own number; the numbers on the way to a node sort it among its siblings.
    """

    def __init__(self) -> None:
        """No nodes and parts yet."""
        self._parts = _Columns(("around", "first", "number", "depth"))
        self._nodes = _Columns(("parent", "part", "child"))
        self._rank = np.zeros(0, dtype=np.int64)
        """[n] numbers of the first n nodes."""

    def add_nodes(self, parents: Ids, part: Ids | int, child: int) -> None:
        """Add children [N] of nodes, made in parts [N] by the successor number ``child``; roots have the parent -1."""
        self._nodes.add(len(parents), (parents, part, child))

    def add_parts(self, around: Ids | int, first: int, number: NDArray[np.integer]) -> Ids:
        """Ids [N] of new parts.

        Args:
            around: [N] the parts around them, -1 for none.
            first: number of the first successor in their block.
            number: [N] their numbers among the parts of one shape.
        """
        depth = 1 + np.where(
            np.asarray(around) < 0, 0, self._parts["depth"][np.maximum(around, 0)] if self._parts.num else 0
        )
        return self._parts.add(len(number), (around, first, number, depth))

    def keys(self, nodes: Ids) -> list[str]:
        """CGA's tree key of each node: the numbers of the nodes on the way to it, each with a semicolon."""
        self._rank_new()
        parent, texts = self._nodes["parent"], dict[int, str]()
        for node in dict.fromkeys(nodes.tolist()):
            way = [node]
            while way[-1] not in texts and parent[way[-1]] >= 0:
                way.append(int(parent[way[-1]]))
            for step in reversed(way):
                if step not in texts:
                    texts[step] = f"{texts.get(int(parent[step]), '')}{self._rank[step]};"
        return [texts[node] for node in nodes.tolist()]

    def _rank_new(self) -> None:
        """Number the new nodes; siblings came with them, or earlier if ``inline`` derived them first."""
        start = len(self._rank)
        parent, part, child = (self._nodes[name][start:] for name in ("parent", "part", "child"))
        if not len(parent):
            return
        way = self._ways(part, child)
        order = np.lexsort((*way.T[::-1], parent))
        group = parent[order]
        is_first = np.append(True, group[1:] != group[:-1])
        begin = np.flatnonzero(is_first)[np.cumsum(is_first) - 1]
        earlier = np.bincount(self._nodes["parent"][:start] + 1, minlength=int(group.max()) + 2)
        rank = np.zeros(len(parent), dtype=np.int64)
        rank[order] = np.where(group < 0, 0, np.arange(len(group)) - begin + earlier[group + 1])
        self._rank = np.concatenate([self._rank, rank])

    def _ways(self, part: Ids, child: Ids) -> NDArray[np.int64]:
        """[n, 2 D + 1] numbers that sort nodes: of the parts around each, outermost first, then its successor."""
        depth = (
            np.zeros(len(part), np.int64) if not self._parts.num else np.where(part < 0, 0, self._parts["depth"][part])
        )
        rows = np.arange(len(part))
        way = np.full((len(part), 2 * int(depth.max()) + 1), -1, dtype=np.int64)
        way[rows, 2 * depth] = child
        current = part
        for level in range(int(depth.max()), 0, -1):
            inside = np.flatnonzero(depth >= level)
            at_level = current[inside]
            way[inside, 2 * level - 2], way[inside, 2 * level - 1] = (
                self._parts[name][at_level] for name in ("first", "number")
            )
            current = current.copy()
            current[inside] = self._parts["around"][at_level]
        return way


class _Columns:
    """Columns of whole numbers that grow by chunks."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self.num = 0
        self._chunks: dict[str, list[Ids]] = {name: [] for name in names}

    def add(self, count: int, values: tuple[NDArray[np.integer] | int, ...]) -> Ids:
        """Rows of ``count`` new values of each column."""
        for chunks, value in zip(self._chunks.values(), values, strict=True):
            chunks.append(np.broadcast_to(np.asarray(value, dtype=np.int32), count))
        self.num += count
        return np.arange(self.num - count, self.num, dtype=np.int32)

    def __getitem__(self, name: str) -> Ids:
        chunks = self._chunks[name]
        if len(chunks) != 1:
            self._chunks[name] = chunks = [np.concatenate([np.zeros(0, np.int32), *chunks])]
        return chunks[0]


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
