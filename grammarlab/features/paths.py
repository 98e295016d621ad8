"""How often every labelled path of length 1 to k occurs in every model.

An edge of a derivation tree is labelled with the rule of its upper node and the ``child`` of its lower one; a path is a
sequence of edges, one below the other (Collins and Duffy 2001; paper 4.5.1). A path may end with a rule instead of an
edge: the node at its end, whatever stands below it. Every node is given a number for the last k edges above it and its
label; models are counted by that number once, and paths are the suffixes of what the numbers stand for.

Keys of paths, in a `KeyIndex`:

    ("rule", context, label)    the nodes of a label below a context
    ("edge", above, child)      the nodes that are this child of such nodes; itself a context

where ``above`` is the column of a "rule" key and ``context`` the column of an "edge" key or -1 for any context.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import repeat
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from grammarlab.arrays import Ints, offsets_from_counts
from grammarlab.features.labels import KeyIndex, Labels
from grammarlab.features.trees import Trees

Numbers: TypeAlias = NDArray[np.integer]


class _Level(NamedTuple):
    """The nodes numbered by their label and the last edges above them, as many as the level says or up to the root."""

    number: Numbers
    """[N] from 0."""
    rules: Ints
    """[S] column of the "rule" key with exactly so many edges, for each number; -1 for leaves and near the root."""
    edges: Ints
    """[S] column of the "edge" key likewise; -1 near the root."""


class Tally(NamedTuple):
    """Some columns of a table."""

    counts: sparse.csr_array
    """[models, len(index)] integers."""
    repeated: NDArray[np.bool_]
    """[len(index)] whether geometry repeats what is counted (`Trees.repeated`) in some of these models."""


def count_paths(trees: Trees, labels: Labels, length: int, index: KeyIndex, grow: bool) -> Tally:
    """How often each path of up to ``length`` edges occurs, a rule at the end counting as an edge.

    Args:
        trees: the models.
        labels: numbers of labels.
        length: k >= 1.
        index: columns of the keys above.
        grow: whether paths that the index does not know are added to it, or left out.
    """
    levels = _number_nodes(trees, labels, length, index, grow)
    number, size = levels[-1].number, len(levels[-1].rules)
    example = np.zeros(size, dtype=np.int64)
    example[number] = np.arange(len(number))
    columns = [level.rules[level.number[example]] for level in levels[:-1]]
    columns += [level.edges[level.number[example]] for level in levels[1:]]
    return tally(trees, slice(None), number, columns, len(index))


def count_symbols(trees: Trees, labels: Labels, index: KeyIndex, grow: bool) -> Tally:
    """How often each symbol occurs, rewritten or not; a key ("symbol", index into `Labels.symbols`) each."""
    number = labels.symbol_numbers[trees.labels(labels)] + 1
    keys = (("symbol", symbol) for symbol in range(len(labels.symbols)))
    columns = np.concatenate(([-1], index.columns(keys, grow)))
    return tally(trees, slice(None), number, [columns], len(index))


def tally(trees: Trees, rows: Ints | slice, number: Numbers, columns: Sequence[Ints], width: int) -> Tally:
    """How many of some nodes each model has, by number, spread over columns.

    Args:
        trees: the models.
        rows: [R] nodes; a node may stand there several times.
        number: [R] a number 0 <= number < size for each.
        columns: each [size], columns that a number belongs to, -1 for none.
        width: how many columns there are.
    """
    size = len(columns[0])
    cells = np.stack(columns, axis=1)
    known = cells >= 0
    ones = np.ones(int(known.sum()), dtype=np.int64)
    spread = sparse.csr_array((ones, cells[known], offsets_from_counts(known.sum(axis=1))), shape=(size, width))
    repeated = np.bincount(number[trees.repeated[rows]], minlength=size)
    return Tally(_count_by_model(trees.model[rows], number, trees.num_models, size) @ spread, repeated @ spread > 0)


def _count_by_model(models: Numbers, number: Numbers, num_models: int, size: int) -> sparse.csr_array:
    """[num_models, size] how often each number stands beside each model."""
    shape = (num_models, size)
    if num_models * size <= 8 * len(number):
        dense = np.bincount(models * np.int64(size) + number, minlength=num_models * size)
        return sparse.csr_array(dense.reshape(shape))
    return sparse.coo_array((np.ones(len(number), dtype=np.int64), (models, number)), shape=shape).tocsr()


def compact(values: Numbers, limit: int) -> tuple[Numbers, Ints]:
    """For each value 0 <= value < limit its rank among the different values, and these, ascending."""
    if limit > 8 * len(values) + 1024:
        found, rank = np.unique(values, return_inverse=True)
        return rank.astype(np.int32), found.astype(np.int64)
    present = np.zeros(limit, dtype=bool)
    present[values] = True
    rank = np.cumsum(present, dtype=np.int32) - np.int32(1)
    return rank[values], np.flatnonzero(present)


def _number_nodes(trees: Trees, labels: Labels, length: int, index: KeyIndex, grow: bool) -> list[_Level]:
    """Levels 0 to ``length``."""
    label_of = trees.labels(labels)
    children = int(trees.forest.nodes.child.max(initial=0)) + 1
    own, kinds = _compact_pairs(label_of, trees.forest.nodes.child, labels.unknown + 1, children)
    kind_label, kind_child = np.divmod(kinds, children)
    number, label = compact(label_of, labels.unknown + 1)
    none = np.full(len(label), -1, dtype=np.int64)
    levels = [_Level(number, _lookup(index, grow, "rule", none, label, label < len(labels.rules)), none)]
    roots = trees.parent < 0
    for level in range(1, length + 1):
        above = levels[-1]
        upper = above.number[trees.parent] + np.int32(1)
        upper[roots] = 0
        number, found = _compact_pairs(upper, own, len(above.rules) + 1, len(kinds))
        upper, kind = np.divmod(found, len(kinds))
        context = np.concatenate(([-1], above.rules))[upper]
        edges = _lookup(index, grow, "edge", context, kind_child[kind], context >= 0)
        ends = (edges >= 0) & (kind_label[kind] < len(labels.rules)) & (level < length)
        levels.append(_Level(number, _lookup(index, grow, "rule", edges, kind_label[kind], ends), edges))
    return levels


def _compact_pairs(first: Numbers, second: Numbers, num_first: int, num_second: int) -> tuple[Numbers, Ints]:
    """`compact` of first * num_second + second."""
    limit = num_first * num_second
    kind = np.int32 if limit < 1 << 31 else np.int64
    return compact(first * kind(num_second) + second, limit)


def _lookup(index: KeyIndex, grow: bool, kind: str, above: Ints, own: Ints, valid: NDArray[np.bool_]) -> Ints:
    """Columns of the keys (kind, above, own) where they are valid, else -1."""
    columns = np.full(len(own), -1, dtype=np.int64)
    above, own = above[valid], own[valid]
    columns[valid] = index.columns(zip(repeat(kind, len(own)), above.tolist(), own.tolist(), strict=True), grow)
    return columns
