"""Pairs of choices that are not one path: an edge and a choice far below it, and choices of adjacent siblings.

Only rules that are chosen at random count as choices, since everything else follows from them.

Keys, in a `KeyIndex`:

    ("far", rule, child, label)    nodes of a label at least two edges below the child of nodes of a rule
    ("next", label, label)         nodes whose next sibling is one of the second label
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grammarlab.arrays import Ints, distinct
from grammarlab.features.columns.paths import Tally, compact, tally
from grammarlab.features.counting.node_labels import KeyIndex, NodeLabels
from grammarlab.features.counting.trees import Trees

_MOST_STEPS = 200
"""Largest number of levels between an edge and a choice."""


def count_far_pairs(trees: Trees, labels: NodeLabels, index: KeyIndex, grow: bool) -> Tally:
    """Counts of choices below each edge, without the child of the edge itself."""
    label = trees.labels(labels)
    children = int(trees.forest.nodes.child.max(initial=0)) + 1
    rows, keys = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for lower, middle in _ancestors_of_choices(trees, label, labels):
        above = trees.parent[middle]
        kept = np.flatnonzero(above >= 0)
        kept = kept[labels.telling[label[above[kept]]]]
        edge = label[above[kept]] * children + trees.forest.nodes.child[middle[kept]]
        rows.append(lower[kept])
        keys.append(edge * (labels.unknown + 1) + label[lower[kept]])
    number, found = compact(np.concatenate(keys), (labels.unknown + 1) ** 2 * children)
    edge, below = np.divmod(found, labels.unknown + 1)
    upper, child = np.divmod(edge, children)
    names = zip(upper.tolist(), child.tolist(), below.tolist(), strict=True)
    columns = index.columns((("far", *name) for name in names), grow)
    return tally(trees, np.concatenate(rows), number, [columns], len(index))


def choices_below(trees: Trees, labels: NodeLabels) -> list[tuple[int, int]]:
    """Different (label of a node, label of a choice below it)."""
    label = trees.labels(labels)
    size = labels.unknown + 1
    keys = [label[middle] * size + label[lower] for lower, middle in _ancestors_of_choices(trees, label, labels)]
    upper, below = np.divmod(distinct(np.concatenate([np.zeros(0, np.int64), *keys]), size**2), size)
    return list(zip(upper.tolist(), below.tolist(), strict=True))


def _ancestors_of_choices(trees: Trees, label: Ints, labels: NodeLabels) -> Iterator[tuple[Ints, Ints]]:
    """Nodes that are choices with their parents, then with their grandparents, and so on."""
    lower = np.flatnonzero(labels.chosen[label])
    middle = trees.parent[lower]
    for _ in range(_MOST_STEPS):
        inner = middle >= 0
        lower, middle = lower[inner], middle[inner]
        if not len(lower):
            return
        yield lower, middle
        middle = trees.parent[middle]


def count_adjacent_pairs(trees: Trees, labels: NodeLabels, index: KeyIndex, grow: bool) -> Tally:
    """Counts of pairs of choices of adjacent siblings."""
    label = trees.labels(labels)
    chosen = labels.chosen[label]
    rows = np.flatnonzero(chosen & (trees.next_sibling >= 0))
    rows = rows[chosen[trees.next_sibling[rows]]]
    size = labels.unknown + 1
    number, found = compact(label[rows] * size + label[trees.next_sibling[rows]], size**2)
    one, other = np.divmod(found, size)
    columns = index.columns((("next", *pair) for pair in zip(one.tolist(), other.tolist(), strict=True)), grow)
    return tally(trees, rows, number, [columns], len(index))
