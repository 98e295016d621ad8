"""The derivation tree of a model, with the triangles of each row, so that a tree and a picture show each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.derivation.forest import Forest
from grammarlab.language.numbering import Numbering
from grammarlab.pages.listed_trees import listed_tree
from grammarlab.runs.sample.trace import DerivationTrace, trace_of, tree_rows
from grammarlab.scene.triangles import leaf_of_triangle


def part_tree(forest: Forest, numbering: Numbering, name: str) -> list[list[Any]]:
    """Rows of the tree of one model; see `listed_tree`.

    The last value of a row has the triangles below it among those of the model: first ones and ends in turn.
    """
    trace = trace_of(forest, numbering, name, 0)
    begin, end = _intervals(trace)
    place = begin[forest.leaves.node[leaf_of_triangle(forest)]]
    order = np.argsort(place, kind="stable")
    sorted_place = place[order]

    def triangles_below(nodes: Sequence[int]) -> list[list[int]]:
        parts = [
            order[slice(*np.searchsorted(sorted_place, (begin[node], end[node])).tolist())] for node in sorted(nodes)
        ]
        return [list(_runs(np.sort(np.concatenate(parts))))] if parts else [[]]

    return listed_tree(tree_rows(trace), triangles_below)


def _intervals(trace: DerivationTrace) -> tuple[Ints, Ints]:
    """[N] places of nodes in the order of a tree that is read, and the places after the last node below each."""
    parent = trace.forest.nodes.parent.tolist()
    size = np.ones(len(parent), dtype=np.int64)
    for node in reversed(range(len(parent))):  # parents come before their children
        if parent[node] >= 0:
            size[parent[node]] += size[node]
    begin = np.zeros(len(parent), dtype=np.int64)
    for node, children in enumerate(trace.children):
        below = np.array(children, dtype=np.int64)
        begin[below] = begin[node] + 1 + np.cumsum(size[below]) - size[below]
    return begin, begin + size


def _runs(numbers: Ints) -> Iterator[int]:
    """First numbers of runs of consecutive ones, and the numbers after their last ones, in turn."""
    breaks = np.flatnonzero(np.diff(numbers) != 1)
    first = np.concatenate([numbers[:1], numbers[breaks + 1]])
    last = np.concatenate([numbers[breaks], numbers[-1:]])
    yield from np.stack([first, last + 1], axis=1).ravel().tolist()
