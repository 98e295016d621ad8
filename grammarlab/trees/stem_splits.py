"""Splits of stems: which segments end in a fork, and the clones that begin there (Weber and Penn, section 4.2).

The mean number of clones per segment need not be whole. The error is diffused along all segments of a level of one
tree, in a fixed order: by segment, then by stem, the clones of a segment after all stems before them. The k-th of them,
from 0, has floor((k + 1) s + ½) - floor(k s + ½) clones. No other tree is involved, and no draw.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints, index_in_row, row_of_value
from grammarlab.randomness import Keys, fold
from grammarlab.trees.branching import num_segments
from grammarlab.trees.budget import check_stems
from grammarlab.trees.draws import Site, counts, values


@dataclass(frozen=True, slots=True, eq=False)
class Forks:
    """S stems, clones included, ordered by tree."""

    root: Ints
    """[S] row of the whole stem, among those without clones."""
    source: Ints
    """[S] row of the stem that a clone split from; -1 for the others."""
    first: Ints
    """[S] segment with which a stem begins."""
    key: Keys
    """[S] keys."""
    direction: Floats
    """[S] radians by which a clone of the trunk's first segment spreads about the vertical; nan if it is drawn."""
    splits: tuple[Ints, ...]
    """For each segment: rows of the stems that have split just before it."""


def forked(rows: Floats, level: int, tree: Ints, keys: Keys) -> Forks:
    """Stems of a level with their clones.

    Args:
        rows: [n, P] parameters of the trees.
        level: the level.
        tree: [W] tree of each whole stem, ascending.
        keys: [W] keys.

    Raises:
        UsageError: If a tree has too many stems.
    """
    segments, rate = num_segments(rows, tree, level), values(rows, tree, f"seg_splits_{level}")
    base = counts(rows, tree, "base_splits") if level == 0 else np.zeros(len(tree), np.int64)
    whole = np.arange(len(tree))
    none = np.full(len(tree), -1)
    forks = Forks(whole, none, np.zeros(len(tree), np.int64), keys, np.full(len(tree), np.nan), ())
    visits = np.zeros(len(rows), np.int64)
    splits: list[Ints] = [none[:0]]
    for segment in range(int(segments.max(initial=0)) - 1 if rate.any() or base.any() else 0):
        trees = tree[forks.root]
        is_base = (base[forks.root] > 0) & (segment == 0)
        goes_on = segments[forks.root] > segment + 1
        k = visits[trees] + _rank(trees, len(rows))
        s = rate[forks.root]
        clones = np.floor((k + 1) * s + 0.5) - np.floor(k * s + 0.5)
        clones = np.where(goes_on, np.where(is_base, base[forks.root], clones), 0).astype(np.int64)
        visits += np.bincount(trees[goes_on & ~is_base], minlength=len(rows))
        check_stems(rows, level, np.bincount(trees, clones + 1.0, len(rows)))
        splits.append(np.flatnonzero(clones > 0))
        forks = _with_clones(forks, segment, clones, is_base)
    return _by_tree(forks, tree, splits)


def _rank(trees: Ints, num: int) -> Ints:
    """[S] number of a stem within its tree, from 0."""
    rank = np.empty(len(trees), np.int64)
    rank[np.argsort(trees, kind="stable")] = index_in_row(np.bincount(trees, minlength=num))
    return rank


def _with_clones(forks: Forks, segment: int, clones: Ints, is_base: Flags) -> Forks:
    source, index = row_of_value(clones), index_in_row(clones)
    even = 2.0 * np.pi * (index + 1) / (clones[source] + 1)
    return Forks(
        root=np.concatenate([forks.root, forks.root[source]]),
        source=np.concatenate([forks.source, source]),
        first=np.concatenate([forks.first, np.full(len(source), segment + 1)]),
        key=np.concatenate([forks.key, fold(fold(fold(forks.key[source], Site.CLONES), segment), index)]),
        direction=np.concatenate([forks.direction, np.where(is_base[source], even, np.nan)]),
        splits=(),
    )


def _by_tree(forks: Forks, tree: Ints, splits: list[Ints]) -> Forks:
    order = np.argsort(tree[forks.root], kind="stable")
    row = np.empty(len(order), np.int64)
    row[order] = np.arange(len(order))
    source = forks.source[order]
    return Forks(
        root=forks.root[order],
        source=np.where(source >= 0, row[source], -1),
        first=forks.first[order],
        key=forks.key[order],
        direction=forks.direction[order],
        splits=tuple(row[rows] for rows in splits),
    )
