"""Counts of labelled paths, of pairs of choices and of symbols in every model, and values of its random draws.

An edge of a derivation tree is labelled with the rule of its upper node and the ``child`` of its lower one; a path is a
sequence of edges, one below the other (Collins and Duffy 2001; paper 4.5.1). A path may end with a rule instead of an
edge: the node at its end, with any nodes below it. Every node gets a number for the last k edges above it and its
label; nodes are counted by that number once, and paths are suffixes of these sequences.

Pairs of choices that are not one path are an edge with a choice far below it, and choices of adjacent siblings. Only
rules that are chosen at random count as choices, since everything else follows from them. Random draws are counts of
drawn branches, or means.

Keys, in a `KeyIndex`:

    ("rule", context, label)       the nodes of a label below a context
    ("edge", above, child)         the nodes that are this child of such nodes; itself a context
    ("far", rule, child, label)    nodes of a label at least two edges below the child of nodes of a rule
    ("next", label, label)         nodes whose next sibling is one of the second label
    ("symbol", symbol), ("branch", name, number), ("draw", name)    as in `column_keys`

where ``above`` is the column of a "rule" key and ``context`` the column of an "edge" key or -1 for any context.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import repeat
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from grammarlab.arrays import MANY, MAX_STEPS, Floats, Ints, distinct, distinct_counts, offsets_from_counts, runs
from grammarlab.derivation.forest import Site
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.node_labels import KeyIndex, NodeLabels
from grammarlab.features.patterns.pattern import Draw
from grammarlab.features.patterns.tree_index import Trees


class Tally(NamedTuple):
    """Columns of a table."""

    counts: sparse.csr_array
    """[models, len(index)] integer counts."""
    repeated: NDArray[np.bool_]
    """[len(index)] whether geometry repeats the counted nodes (`Trees.repeated`) in some of these models."""


class Sequences(NamedTuple):
    """The S different sequences of a label and the last edges above it, with their counts: paths are suffixes."""

    levels: Sequence[_Level]
    """Level 0 to the longest, whose sequences are counted."""
    label: Ints
    """[S] label of each sequence."""
    counts: sparse.csr_array
    """[models, S] number of nodes with each sequence."""
    repeated: NDArray[np.bool_]
    """[S] whether geometry repeats some nodes with a sequence (`Trees.repeated`)."""


def count_sequences(trees: Trees, labels: NodeLabels, length: int, index: KeyIndex, grow: bool) -> Sequences:
    """The only pass over nodes that paths and symbols need.

    Args:
        trees: the models.
        labels: numbers of labels.
        length: k >= 1, number of edges of the longest paths.
        index: columns of the keys above.
        grow: whether unknown paths are added to the index; otherwise they are left out.
    """
    number, levels, label = _number_nodes(trees, labels, length, index, grow)
    counts = _count_by_model(trees.model, number, trees.num_models, len(label))
    starts, _ = runs(number)
    is_repeated = np.logical_or.reduceat(trees.repeated, starts) if len(starts) else trees.repeated
    return Sequences(levels, label, counts, _met(number[starts[is_repeated]], len(label)))


def count_paths(sequences: Sequences, width: int) -> Tally:
    """Counts of paths, where a rule at the end counts as an edge.

    Args:
        sequences: those of the nodes.
        width: number of columns.
    """
    columns: list[Ints] = []
    sequence = np.arange(len(sequences.label))
    for level in reversed(sequences.levels):
        columns += [level.rules[sequence], level.edges[sequence]]
        sequence = level.shorter[sequence]
    return _assigned(sequences.counts, sequences.repeated, columns, width)


def count_symbols(sequences: Sequences, labels: NodeLabels, index: KeyIndex, grow: bool) -> Tally:
    """Counts of each symbol, rewritten or not; one key ("symbol", index into `NodeLabels.symbols`) each."""
    columns = index.columns((("symbol", symbol) for symbol in range(len(labels.symbols))), grow)
    column = np.append(columns, -1)[labels.symbol_numbers[sequences.label]]  # the unknown symbol, -1, is the last one
    return _assigned(sequences.counts, sequences.repeated, [column], len(index))


def count_far_pairs(trees: Trees, labels: NodeLabels, index: KeyIndex, grow: bool) -> Tally:
    """Counts of choices below each edge, without the child of the edge itself."""
    label = trees.labels(labels)
    children = int(trees.forest.nodes.child.max(initial=0)) + 1
    rows, keys = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for lower, middle in _ancestors_of_choices(trees, label, labels):
        above = trees.parent[middle]
        inner = np.flatnonzero(above >= 0)
        inner = inner[labels.telling[label[above[inner]]]]
        edge = label[above[inner]] * children + trees.forest.nodes.child[middle[inner]]
        rows.append(lower[inner])
        keys.append(edge * (labels.unknown + 1) + label[lower[inner]])
    number, codes = _compact(np.concatenate(keys), (labels.unknown + 1) ** 2 * children)
    edge, below = np.divmod(codes, labels.unknown + 1)
    upper, child = np.divmod(edge, children)
    names = zip(upper.tolist(), child.tolist(), below.tolist(), strict=True)
    columns = index.columns((("far", *name) for name in names), grow)
    return _tally(trees, np.concatenate(rows), number, columns, len(index))


def count_adjacent_pairs(trees: Trees, labels: NodeLabels, index: KeyIndex, grow: bool) -> Tally:
    """Counts of pairs of choices of adjacent siblings."""
    label = trees.labels(labels)
    chosen = labels.chosen[label]
    rows = np.flatnonzero(chosen & (trees.next_sibling >= 0))
    rows = rows[chosen[trees.next_sibling[rows]]]
    size = labels.unknown + 1
    number, codes = _compact(label[rows] * size + label[trees.next_sibling[rows]], size**2)
    first, second = np.divmod(codes, size)
    columns = index.columns((("next", *pair) for pair in zip(first.tolist(), second.tolist(), strict=True)), grow)
    return _tally(trees, rows, number, columns, len(index))


def count_branches(trees: Trees, index: KeyIndex, grow: bool) -> Tally:
    """Counts of the outcomes of choices of few branches, ``p`` and ``fileRandom``; one "branch" key each."""
    sites, draws = trees.forest.sites, trees.forest.draws
    names = list(dict.fromkeys(site.name for site in sites))
    discrete = np.array([not is_quantity(site) for site in sites], dtype=bool)
    rows = np.flatnonzero(discrete[draws.site])
    name_of_site = np.array([names.index(site.name) for site in sites], dtype=np.int64)
    outcome = draws.value[rows].astype(np.int64)
    size = int(outcome.max(initial=0)) + 1
    number, codes = _compact(name_of_site[draws.site[rows]] * size + outcome, len(names) * size)
    name, drawn = np.divmod(codes, size)
    keys = (("branch", names[n], value) for n, value in zip(name.tolist(), drawn.tolist(), strict=True))
    columns = index.columns(keys, grow)
    return _tally(trees, draws.node[rows].astype(np.int64), number, columns, len(index))


def is_quantity(site: Site) -> bool:
    """Whether its draws are numbers to compare: random numbers, and branch numbers of choices of many branches."""
    return site.kind == "uniform" or site.choices > MANY


def measure_draws(trees: Trees, index: KeyIndex, grow: bool) -> Tally:
    """The mean of the draws of each ``rand`` and of each choice of many branches; one "draw" key each."""
    names = tuple(dict.fromkeys(site.name for site in trees.forest.sites if is_quantity(site)))
    columns = index.columns((("draw", name) for name in names), grow)
    return columns_of(count(trees, [Draw(name) for name in names]), columns, len(index))


def columns_of(values: Floats, columns: Ints, width: int) -> Tally:
    """Values [models, C] at their columns [C] of a table, -1 for those to leave out; none is a count of nodes."""
    indices = np.flatnonzero(columns >= 0)
    model, position = np.nonzero(values[:, indices])
    cells = model, columns[indices][position]
    counts = sparse.csr_array((values[:, indices][model, position], cells), shape=(len(values), width))
    return Tally(counts, np.zeros(width, dtype=bool))


def _number_nodes(
    trees: Trees, labels: NodeLabels, length: int, index: KeyIndex, grow: bool
) -> tuple[NDArray[np.int32], list[_Level], Ints]:
    """Sequences of labels and edges.

    Returns:
        The sequence [N] of each node at the last level; levels 0 to ``length``, fewer if all paths are shorter; and the
        label [S] of each sequence of the last level.
    """
    pairs, number = _label_pairs(trees, labels)
    levels, label = [_labels_alone(pairs, labels, index, grow)], np.arange(labels.unknown + 1)
    while len(levels) <= length and (levels[-1].rules >= 0).any():
        above_roots = len(levels[-1].codes)
        number = number.take(trees.parent, mode="wrap")
        number[trees.roots] = above_roots
        number, codes = _compact_pairs(number, pairs.number, above_roots + 1, len(pairs.label))
        num_rules = len(labels.rules) if len(levels) < length else 0
        levels.append(_next_level(levels, codes, pairs, num_rules, index, grow))
        label = pairs.label[codes % len(pairs.label)]
    return number, levels, label


class _Level(NamedTuple):
    """Sequences with as many edges as the level, or up to the root."""

    codes: Ints
    """[S] the sequence of the node above at the level before (one past the last where there is no node) times K, plus
    the pair of the node; ascending. At level 0, labels."""
    rules: Ints
    """[S] column of the "rule" key with exactly this number of edges; -1 for leaves and near the root."""
    edges: Ints
    """[S] column of the "edge" key with this number of edges; -1 near the root."""
    shorter: Ints
    """[S] the sequence of the level before that lacks the first edge."""


def _label_pairs(trees: Trees, labels: NodeLabels) -> tuple[_LabelPairs, NDArray[np.int32]]:
    """The pairs of the nodes, and the label [N] of each node."""
    nodes = trees.forest.nodes
    children = int(nodes.child.max(initial=0)) + 1
    starts, lengths = runs(nodes.rule, nodes.symbol, nodes.child)
    label = labels.numbers(trees.forest, starts)
    rank, codes = _compact(label * children + nodes.child[starts], (labels.unknown + 1) * children)
    number, label_of_node = (column.astype(np.int32).repeat(lengths) for column in (rank, label))
    return _LabelPairs(number, *np.divmod(codes, children)), label_of_node


class _LabelPairs(NamedTuple):
    """The K different pairs of a label and the ``child`` that a node is, ascending."""

    number: NDArray[np.int32]
    """[N] the pair of each node."""
    label: Ints
    """[K] label of each pair."""
    child: Ints
    """[K] ``child`` of each pair."""


def _compact(values: Ints, limit: int) -> tuple[Ints, Ints]:
    """For each value 0 <= value < limit its rank among the different values, and these, ascending."""
    if limit > 8 * len(values) + 1024:
        unique, rank = np.unique(values, return_inverse=True)
        return rank, unique
    unique = distinct(values, limit)
    rank = np.empty(limit, dtype=np.int64)
    rank[unique] = np.arange(len(unique))
    return rank[values], unique


def _compact_pairs(
    one: NDArray[np.int32], other: NDArray[np.int32], one_limit: int, other_limit: int
) -> tuple[NDArray[np.int32], Ints]:
    """`_compact` of pairs [N] of integers, the first times the limit of the second plus the second.

    Nodes that a rule makes at once follow each other, and nearly all have equal pairs: one of each run is looked up.
    """
    starts, lengths = runs(one, other)
    rank, codes = _compact(one[starts] * np.int64(other_limit) + other[starts], one_limit * other_limit)
    return rank.astype(np.int32).repeat(lengths), codes


def _labels_alone(pairs: _LabelPairs, labels: NodeLabels, index: KeyIndex, grow: bool) -> _Level:
    label = np.arange(labels.unknown + 1)
    none = np.full(len(label), -1)
    met = _met(pairs.label, len(label))
    met[len(labels.rules) :] = False
    return _Level(label, _lookup(index, grow, "rule", none, label, met), none, none)


def _lookup(index: KeyIndex, grow: bool, kind: str, above: Ints, last: Ints, valid: NDArray[np.bool_]) -> Ints:
    """Columns of the keys (kind, above, last) if they are valid, otherwise -1."""
    columns = np.full(len(last), -1, dtype=np.int64)
    above, last = above[valid], last[valid]
    columns[valid] = index.columns(zip(repeat(kind, len(last)), above.tolist(), last.tolist(), strict=True), grow)
    return columns


def _next_level(
    levels: list[_Level], codes: Ints, pairs: _LabelPairs, num_rules: int, index: KeyIndex, grow: bool
) -> _Level:
    """The level after some others; labels below ``num_rules`` have columns of their own."""
    before = levels[-1]
    above, pair = np.divmod(codes, len(pairs.label))
    context = np.append(before.rules, -1)[above]
    edges = _lookup(index, grow, "edge", context, pairs.child[pair], context >= 0)
    ends = (edges >= 0) & (pairs.label[pair] < num_rules)
    rules = _lookup(index, grow, "rule", edges, pairs.label[pair], ends)
    if len(levels) == 1:
        return _Level(codes, rules, edges, pairs.label[pair])
    shorter = np.append(before.shorter, len(levels[-2].codes))[above]
    return _Level(codes, rules, edges, np.searchsorted(before.codes, shorter * len(pairs.label) + pair))


def _tally(trees: Trees, rows: Ints, number: Ints, columns: Ints, width: int) -> Tally:
    """Counts of nodes per model by their numbers, assigned to columns.

    Args:
        trees: the models.
        rows: [R] nodes; repeats are allowed.
        number: [R] number of each node, 0 <= number < size.
        columns: [size] column of each number, -1 for none.
        width: number of columns.
    """
    counts = _count_by_model(trees.model[rows], number, trees.num_models, len(columns))
    return _assigned(counts, _met(number[trees.repeated[rows]], len(columns)), [columns], width)


def _assigned(counts: sparse.csr_array, repeated: NDArray[np.bool_], columns: Sequence[Ints], width: int) -> Tally:
    """Counts of numbers, assigned to columns.

    Args:
        counts: [models, size] count of each number.
        repeated: [size] whether geometry repeats some nodes with a number.
        columns: arrays [size] with a column of each number, -1 for none.
        width: number of columns.
    """
    cells = np.stack(columns, axis=1)
    is_column = cells >= 0
    belongs = is_column.sum(axis=1)
    ones = np.ones(int(belongs.sum()), dtype=np.int64)
    spread = sparse.csr_array((ones, cells[is_column], offsets_from_counts(belongs)), shape=(len(cells), width))
    assigned = sparse.csr_array(counts @ spread)
    if belongs.max(initial=0) <= 1:
        assigned.sort_indices()
    return Tally(assigned, _met(cells[repeated], width + 1)[:-1])  # -1, for none, is the last one


def _met(numbers: NDArray[np.integer], size: int) -> NDArray[np.bool_]:
    """[size] the numbers that occur."""
    met = np.zeros(size, dtype=bool)
    met[numbers] = True
    return met


def _count_by_model(
    models: NDArray[np.integer], number: NDArray[np.integer], num_models: int, size: int
) -> sparse.csr_array:
    """[num_models, size] counts of each number in each model."""
    starts, lengths = runs(models, number)
    codes = models[starts] * np.int64(size) + number[starts]
    unique, counts = distinct_counts(codes, num_models * size, lengths)
    model = unique // max(size, 1)
    offsets = offsets_from_counts(np.bincount(model, minlength=num_models))
    return sparse.csr_array((counts, unique - model * size, offsets), shape=(num_models, size))


def _ancestors_of_choices(trees: Trees, label: Ints, labels: NodeLabels) -> Iterator[tuple[Ints, Ints]]:
    """Nodes that are choices with their parents, then with their grandparents, and so on."""
    lower = np.flatnonzero(labels.chosen[label])
    middle = trees.parent[lower]
    for _ in range(MAX_STEPS):
        inner = middle >= 0
        lower, middle = lower[inner], middle[inner]
        if not len(lower):
            return
        yield lower, middle
        middle = trees.parent[middle]
