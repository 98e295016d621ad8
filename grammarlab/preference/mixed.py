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
from grammarlab.preference.blended import (
    MAX_HELD_OUT,
    MIN_LABELS,
    NUM_FOLDS,
    PROCESS_SHARES,
    BlendedPreference,
    mean_share,
)
from grammarlab.preference.cells import partition
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.labels import Kind
from grammarlab.preference.likelihood import Intervals, matched
from grammarlab.preference.observations import checked_groups, checked_kinds
from grammarlab.preference.processes import grouped
from grammarlab.preference.processes.grouped import GroupedPreference
from grammarlab.preference.processes.grouped_search import AMPLITUDE
from grammarlab.preference.processes.label_kinds import (
    BLUNDER_PROBABILITY,
    Judgements,
    LabelObservations,
    judgements_of,
    label_observations,
    middle_of,
)
from grammarlab.preference.processes.posterior import Hyperparameters

START_NOISE = 5.0
"""Standard deviation in points before a kernel has been found."""
MIN_NOISE = 3.0
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
        observed, process = _in_turns(judgements, numbers, drawn, seed)
    cells = partition.fit(
        observed.rows, observed.scores, groups=numbers, continuous=drawn, seed=seed, intervals=observed.intervals
    )
    few = len(judgements.scores) < MIN_LABELS
    share, sketches = (1.0, ()) if few else _share(judgements, observed, drawn, seed, process, cells)
    return BlendedPreference(process, cells, share, sketches=sketches)


def _in_turns(
    judgements: Judgements, groups: Ints, continuous: Flags, seed: int
) -> tuple[LabelObservations, GroupedPreference]:
    """Observations from labels under the best kernel, which is found from those under a kernel of equal weights."""
    spread = 2.0 * np.var(judgements.rows, axis=0).sum()
    varies = np.ptp(judgements.rows, axis=0) > 0.0
    kernel = Hyperparameters(AMPLITUDE[0] * MAX_SCORE**2, varies / max(float(spread), 1.0), START_NOISE**2)
    observed = label_observations(judgements, kernel, MAX_SCORE / 2.0)
    process = grouped.fit_observed(
        observed.search_observations, groups=groups, continuous=continuous, seed=seed, starts=1
    )
    observed = _under(judgements, process)
    process = grouped.fit_observed(observed.search_observations, groups=groups, continuous=continuous, seed=seed)
    observed = _under(judgements, process)
    return observed, process.conditioned_on(observed.observations)


def _under(judgements: Judgements, process: GroupedPreference) -> LabelObservations:
    """Observations from labels under the best kernel of a process."""
    kernel = process.explanations[0].posterior.hyperparameters
    return label_observations(judgements, kernel, middle_of(judgements, kernel))


def _share(
    judgements: Judgements,
    observed: LabelObservations,
    continuous: Flags,
    seed: int,
    process: GroupedPreference,
    cells: PartitionPreference,
) -> tuple[float, tuple[BlendedPreference, ...]]:
    """Share of the process by the likelihood of held-out labels, and the fits without these labels."""
    randomness = np.random.default_rng(seed)
    num_rows, num_labels = len(judgements.rows), len(judgements.scores)
    # Labels of equal rows are held out together: otherwise one would predict the other.
    fold_of = randomness.permutation(NUM_FOLDS * (1 + num_rows // NUM_FOLDS))[:num_rows] % NUM_FOLDS
    first, compared = judgements.first, judgements.second >= 0
    second = np.where(compared, judgements.second, first)
    is_selected = np.zeros(num_labels, dtype=bool)
    is_selected[randomness.permutation(num_labels)[:MAX_HELD_OUT]] = True
    evidence, sketches = np.zeros(len(PROCESS_SHARES)), list[tuple[GroupedPreference, PartitionPreference]]()
    for number in range(NUM_FOLDS):
        out = (fold_of[first] == number) | (fold_of[second] == number)
        is_training, apart = ~out[observed.label], np.flatnonzero((fold_of[observed.row_pairs] != number).all(axis=1))
        held_out = np.flatnonzero(out & is_selected)
        if len(held_out) and is_training.any() and len(apart):
            with threadpool_limits(1, "blas"):
                sketch = (
                    process.conditioned_on(observed.observations.take(apart)),
                    cells.without(
                        observed.rows[is_training],
                        observed.scores[is_training],
                        continuous,
                        observed.intervals.take(is_training),
                    ),
                )
                parts = [np.clip(part.predict(judgements.rows).mean, 0.0, MAX_SCORE) for part in sketch]
            sketches.append(sketch)
            for index, share in enumerate(PROCESS_SHARES):
                values = share * parts[0] + (1.0 - share) * parts[1]
                differences = values[first[held_out]] - compared[held_out] * values[second[held_out]]
                evidence[index] += _log_likelihood(observed.bounds.take(held_out), differences, cells)
    # Cells are preferred for the divisions that they find. Undivided ones are the hypothesis that all designs are liked
    # equally, which explains no comparison: it has the same odds as any other share.
    undivided = compared.any() and cells.trees[0].split is None
    share = mean_share(evidence, 1.0) if undivided else mean_share(evidence)
    return share, tuple(BlendedPreference(*part, share) for part in sketches)


def _log_likelihood(intervals: Intervals, values: Floats, cells: PartitionPreference) -> float:
    """Log-likelihood of labels, given values [n], under the error model of the cells."""
    noise, blunders = max(cells.noise, MIN_NOISE), max(cells.blunders, BLUNDER_PROBABILITY)
    evidence, _, _ = matched(intervals, values, np.full(len(values), 1e-9), noise, blunders)
    return float(evidence.sum())
