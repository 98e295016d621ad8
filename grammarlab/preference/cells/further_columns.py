"""Columns of further kinds, shares of sums among them, that cells need: those that the most likely tree splits by.

Most persons need none of them, and among many columns some fit any scores. So trees with and without these columns are
compared by their posterior, in which each group of columns has its share of the prior mass.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.preference.cells.cells import ScoreCells, grid_of
from grammarlab.preference.cells.person_error import BLUNDERS, LOW_TEMPERATURE, guides_of
from grammarlab.preference.cells.split_ranking import MANY_LABELS
from grammarlab.preference.cells.splits import Above, Splits
from grammarlab.preference.cells.tree_growth import Growth, Tree, grow

NOISES = (28.0, 15.0, 5.0, 0.5)
"""Candidate standard deviations of the noise in points, largest first; the most likely one counts."""
MIN_LABELS = 24
"""Smallest number of labels; with fewer, some column of thousands explains them."""
MAX_ROWS = 256
"""Largest number of labels that are compared."""
_MIN_GAIN = 5.0
"""Smallest gain of the log-posterior in nats: the prior odds that no further column is needed."""
_NUM_GUIDED = 1
"""Number of guided trees per noise."""
_NUM_SEARCHES = 7, 24
"""Numbers of further guided trees of known columns while columns seem needed, first per noise and then of the most
likely noise. This search is more careful: otherwise columns are added that only make up for a poor search."""


class RequiredColumns(NamedTuple):
    """Further columns, and how well cells explain scores with them."""

    columns: Ints
    """Ascending indices; empty if trees of the known columns explain scores about as well."""
    log_posterior: float
    """Log-posterior of the most likely tree, less prices, in nats; minus infinity for too few labels."""


def selected(scores: Floats) -> Ints:
    """Ascending indices of at most `MAX_ROWS` labels, an even selection by score."""
    num = min(MAX_ROWS, len(scores))
    return np.sort(np.argsort(scores, kind="stable")[np.arange(num) * len(scores) // max(num, 1)])


def required_columns(
    rows: Floats, scores: Floats, *, groups: Ints, continuous: Flags, num_known: int, prices: Floats
) -> RequiredColumns:
    """The columns beyond the first ``num_known`` ones that the most likely tree of all columns splits by.

    Args:
        rows: [n, F] rows of the labelled designs.
        scores: [n] 0-100.
        groups: [F] group numbers.
        continuous: [F] whether columns are continuous instead of counts.
        num_known: number of columns that are used in any case.
        prices: [F - num_known] further gain in nats that each other column must have.
    """
    if len(scores) < MIN_LABELS:
        return RequiredColumns(np.zeros(0, dtype=np.int64), -np.inf)
    shares_of = sums_of(rows[:, :num_known], groups[:num_known], continuous[:num_known])
    known_splits, all_splits = (
        splits_of(rows[:, :width], groups[:width], continuous[:width], shares_of, scores)
        for width in (num_known, rows.shape[1])
    )
    of_all, of_known = (_most_likely(splits, scores, _NUM_GUIDED, NOISES, 0) for splits in (all_splits, known_splits))
    used = _further(of_all.tree, num_known, rows.shape[1])
    price = _MIN_GAIN + float(prices[used - num_known].sum())
    for number, num in enumerate(_NUM_SEARCHES):
        if _gain(of_known, of_all) < price:
            break
        noises = (of_known.noise,) if number else NOISES
        candidate = _most_likely(known_splits, scores, num, noises, number + 1)
        of_known = max(of_known, candidate, key=_posterior)
    if _gain(of_known, of_all) >= price:
        return RequiredColumns(used, _posterior(of_all) - price)
    highest = float(prices[used - num_known].max(initial=0.0))
    if not highest:
        return RequiredColumns(np.zeros(0, dtype=np.int64), _posterior(of_known))
    # Others may be needed that a column which is too expensive has made up for.
    cheaper = np.flatnonzero(prices < highest)
    columns = np.concatenate([np.arange(num_known), num_known + cheaper])
    result = required_columns(
        rows[:, columns],
        scores,
        groups=groups[columns],
        continuous=continuous[columns],
        num_known=num_known,
        prices=prices[cheaper],
    )
    return RequiredColumns(columns[result.columns], result.log_posterior)


def sums_of(rows: Floats, groups: Ints, continuous: Flags) -> tuple[Ints, ...]:
    """Groups whose counts have different sums: the share of a column may be relevant."""
    column_sets = []
    for group in np.unique(groups[~continuous]).tolist():
        columns = np.flatnonzero((groups == group) & ~continuous)
        total = rows[:, columns].sum(axis=1)
        if len(columns) > 1 and np.ptp(total) > 0.0 and total.max() > 1.0:
            column_sets.append(columns)
    return tuple(column_sets)


def splits_of(
    rows: Floats,
    groups: Ints,
    continuous: Flags,
    shares_of: tuple[Ints, ...],
    scores: Floats,
    near: Collection[Above] = (),
    priors: Floats | None = None,
) -> Splits:
    """`Splits.of` rows, including splits by shares."""
    owners = np.concatenate([groups, *(groups[columns] for columns in shares_of)])
    added = np.ones(sum(len(columns) for columns in shares_of), dtype=bool)
    likely = None if priors is None else np.concatenate([priors, *(priors[columns] for columns in shares_of)])
    return Splits.of(widened(rows, shares_of), owners, np.concatenate([continuous, added]), scores, near, likely)


def widened(rows: Floats, shares_of: tuple[Ints, ...]) -> Floats:
    """Rows with the share of each column of some sets in their sum; -1/2 if the sum is 0."""
    if not shares_of:
        return rows
    parts = []
    for columns in shares_of:
        total = rows[:, columns].sum(axis=1, keepdims=True)
        parts.append(np.where(total > 0.0, rows[:, columns] / np.where(total > 0.0, total, 1.0), -0.5))
    return np.concatenate([rows, *parts], axis=1)


def _most_likely(splits: Splits, scores: Floats, num_guided: int, noises: tuple[float, ...], seed: int) -> _Candidate:
    """The most likely of a few trees."""
    randomness, every, grid = np.random.default_rng(seed), np.arange(len(scores)), grid_of(scores)
    guides = guides_of(ScoreCells(splits=splits, scores=scores, grid=grid, noise=noises[0], blunders=BLUNDERS[1]))
    growths = [Growth(1e-2)] + [Growth(LOW_TEMPERATURE, 0.0, guides)] * num_guided
    candidates: list[_Candidate] = []
    for noise in noises:
        # Trees of little noise are large, and of many labels unlikely if the next larger noise was.
        less_likely = len(candidates) > len(growths) and max(candidates, key=_posterior).noise > candidates[-1].noise
        if less_likely and len(scores) > MANY_LABELS:
            break
        cells = ScoreCells(splits=splits, scores=scores, grid=grid, noise=noise, blunders=BLUNDERS[1])
        candidates += [_Candidate(grow(cells, every, growth, randomness), noise) for growth in growths]
    return max(candidates, key=_posterior)


class _Candidate(NamedTuple):
    tree: Tree
    noise: float
    """Standard deviation of the noise of the tree, in points."""


def _posterior(candidate: _Candidate) -> float:
    return candidate.tree.log_posterior


def _further(tree: Tree, num_known: int, width: int) -> Ints:
    """Ascending indices of the columns of a tree from ``num_known`` to ``width`` - 1."""
    used = {column for node in tree.nodes() if node.split is not None for column in node.split.columns}
    return np.array(sorted(column for column in used if num_known <= column < width), dtype=np.int64)


def _gain(of_known: _Candidate, of_all: _Candidate) -> float:
    """Gain of the log-posterior by further columns, in nats."""
    return of_all.tree.log_posterior - of_known.tree.log_posterior
