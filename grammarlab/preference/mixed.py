"""The default preference of labels of several kinds: scores, stars, thumbs and comparisons in one likelihood.

Under a kernel, sites replace labels that are not scores (`grammarlab.preference.processes.label_kinds`). Kernels and
sites are improved in turns. Cells get the intervals of values. If all labels are scores, `blended.py` handles them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.preference.base import MAX_SCORE, Rows
from grammarlab.preference.blended import FEWEST, FOLDS, MOST, SHARES, BlendedPreference, mean_share
from grammarlab.preference.cells import partition
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.labels import Kind
from grammarlab.preference.likelihood import Intervals, matched
from grammarlab.preference.observations import checked_groups, checked_kinds
from grammarlab.preference.processes import grouped
from grammarlab.preference.processes.grouped import GroupedPreference
from grammarlab.preference.processes.grouped_search import AMPLITUDE
from grammarlab.preference.processes.label_kinds import (
    BLUNDERS,
    Judgements,
    Understood,
    judgements_of,
    middle_of,
    understood,
)
from grammarlab.preference.processes.posterior import Hyperparameters

NOISE = 5.0
"""Standard deviation in points before a kernel has been found."""
LEAST_NOISE = 3.0
"""Smallest error in points of predictions of held-out labels."""


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    kinds: Sequence[Kind],
    others: Rows,
    groups: ArrayLike | None = None,
    continuous: ArrayLike | None = None,
    seed: int = 0,
) -> BlendedPreference:
    """Both kinds of preference, and the share of each by held-out labels.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100, as in label tables.
        kinds: [n] kinds of the labels.
        others: [n, F] rows of the other models of comparisons; arbitrary for other kinds.
        groups: [F] group numbers; by default every column is its own group.
        continuous: [F] whether columns are continuous instead of counts; by default none is.
        seed: seed of random starts and draws, and of the held-out labels.

    Raises:
        UsageError: If labels or groups are out of range.
    """
    judgements = judgements_of(rows, scores, kinds, others)
    numbers = checked_groups(groups, judgements.rows.shape[1])
    drawn = checked_kinds(continuous, len(numbers))
    with threadpool_limits(1, "blas"):
        told, process = _in_turns(judgements, numbers, drawn, seed)
    cells = partition.fit(told.rows, told.scores, groups=numbers, continuous=drawn, seed=seed, said=told.said)
    few = len(judgements.scores) < FEWEST
    share, sketches = (1.0, ()) if few else _share(judgements, told, drawn, seed, process, cells)
    return BlendedPreference(process, cells, share, sketches=sketches)


def _in_turns(
    judgements: Judgements, groups: Ints, continuous: Flags, seed: int
) -> tuple[Understood, GroupedPreference]:
    """Observations from labels under the best kernel, which is found from those under a kernel of equal weights."""
    spread = 2.0 * np.var(judgements.rows, axis=0).sum()
    varies = np.ptp(judgements.rows, axis=0) > 0.0
    kernel = Hyperparameters(AMPLITUDE[0] * MAX_SCORE**2, varies / max(float(spread), 1.0), NOISE**2)
    told = understood(judgements, kernel, MAX_SCORE / 2.0)
    process = grouped.fit_observed(told.seen, groups=groups, continuous=continuous, seed=seed, starts=1)
    told = _under(judgements, process)
    process = grouped.fit_observed(told.seen, groups=groups, continuous=continuous, seed=seed)
    told = _under(judgements, process)
    return told, process.given(told.observations)


def _under(judgements: Judgements, process: GroupedPreference) -> Understood:
    """Observations from labels under the best kernel of a process."""
    kernel = process.explanations[0].posterior.hyperparameters
    return understood(judgements, kernel, middle_of(judgements, kernel))


def _share(
    judgements: Judgements,
    told: Understood,
    continuous: Flags,
    seed: int,
    process: GroupedPreference,
    cells: PartitionPreference,
) -> tuple[float, tuple[BlendedPreference, ...]]:
    """Share of the process by the likelihood of held-out labels, and the fits without these labels."""
    randomness = np.random.default_rng(seed)
    num_rows, num_labels = len(judgements.rows), len(judgements.scores)
    # Labels of equal rows are held out together: otherwise one would predict the other.
    fold_of = randomness.permutation(FOLDS * (1 + num_rows // FOLDS))[:num_rows] % FOLDS
    first, compared = judgements.first, judgements.second >= 0
    second = np.where(compared, judgements.second, first)
    some = np.zeros(num_labels, dtype=bool)
    some[randomness.permutation(num_labels)[:MOST]] = True
    evidence, found = np.zeros(len(SHARES)), list[tuple[GroupedPreference, PartitionPreference]]()
    for number in range(FOLDS):
        out = (fold_of[first] == number) | (fold_of[second] == number)
        known, apart = ~out[told.label], np.flatnonzero((fold_of[told.of] != number).all(axis=1))
        held = np.flatnonzero(out & some)
        if len(held) and known.any() and len(apart):
            with threadpool_limits(1, "blas"):
                sketch = (
                    process.given(told.observations.take(apart)),
                    cells.without(told.rows[known], told.scores[known], continuous, told.said.take(known)),
                )
                parts = [np.clip(part.predict(judgements.rows).mean, 0.0, MAX_SCORE) for part in sketch]
            found.append(sketch)
            for place, share in enumerate(SHARES):
                values = share * parts[0] + (1.0 - share) * parts[1]
                differences = values[first[held]] - compared[held] * values[second[held]]
                evidence[place] += _log_likelihood(told.bounds.take(held), differences, cells)
    # Cells are preferred for the divisions that they find. Undivided ones are the hypothesis that all designs are liked
    # equally, which explains no comparison: it has the same odds as any other share.
    undivided = compared.any() and cells.trees[0].split is None
    share = mean_share(evidence, 1.0) if undivided else mean_share(evidence)
    return share, tuple(BlendedPreference(*part, share) for part in found)


def _log_likelihood(said: Intervals, values: Floats, cells: PartitionPreference) -> float:
    """Log-likelihood of labels, given values [n], under the error model of the cells."""
    noise, blunders = max(cells.noise, LEAST_NOISE), max(cells.blunders, BLUNDERS)
    evidence, _, _ = matched(said, values, np.full(len(values), 1e-9), noise, blunders)
    return float(evidence.sum())
