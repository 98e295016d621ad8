"""The default preference of labels of several kinds: scores, stars, thumbs and comparisons in one likelihood.

Under a kernel, sites take the place of what is not a score (`grammarlab.preference.processes.kinds`); a kernel is
searched for with these, and so in turns. Cells are told the intervals that values lie in. Scores alone never come here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.preference.base import MAX_SCORE, Floats, Ints, Rows
from grammarlab.preference.blended import FEWEST, FOLDS, MOST, SHARES, BlendedPreference
from grammarlab.preference.cells import partition
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.cells.splits import Flags
from grammarlab.preference.labels.table import Kind
from grammarlab.preference.likelihood import Intervals, matched
from grammarlab.preference.observations import Observations, checked_groups, checked_kinds
from grammarlab.preference.processes import grouped
from grammarlab.preference.processes.grouped import GroupedPreference
from grammarlab.preference.processes.grouped_search import AMPLITUDE
from grammarlab.preference.processes.kinds import BLUNDERS, Judgements, Understood, judgements_of, middle_of, understood
from grammarlab.preference.processes.posterior import Hyperparameters, condition

NOISE = 5.0
"""Standard deviation in points that is assumed as long as no kernel has been found."""
LEAST_NOISE = 3.0
"""Points that predictions of held-out labels may miss by, at least."""
AS_GOOD = 2.0
"""Nats; shares that differ by less tell nothing, and the smallest is taken: what cells say is simpler."""


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
    """Both kinds of preference, and the share of each that predicts held-out labels best.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100, as label tables have them.
        kinds: [n] how each was said.
        others: [n, F] the rows that comparisons are with; anything for other kinds.
        groups: [F] group numbers; every column its own group when there are none.
        continuous: [F] which columns are no counts; none of them when left out.
        seed: of random starts and draws, and of what is held out.

    Raises:
        UsageError: when labels or groups are out of range.
    """
    judgements = judgements_of(rows, scores, kinds, others)
    numbers = checked_groups(groups, judgements.rows.shape[1])
    drawn = checked_kinds(continuous, len(numbers))
    with threadpool_limits(1, "blas"):
        told, process = _in_turns(judgements, numbers, drawn, seed)
    cells = partition.fit(told.rows, told.scores, groups=numbers, continuous=drawn, seed=seed, said=told.said)
    few = len(judgements.scores) < FEWEST
    share = 1.0 if few else _share(judgements, told, numbers, drawn, seed, cells)
    return BlendedPreference(process, cells, share)


def _in_turns(
    judgements: Judgements, groups: Ints, continuous: Flags, seed: int
) -> tuple[Understood, GroupedPreference]:
    """What labels say under the best kernel, which is found with what they say under one without preferences."""
    spread = 2.0 * np.var(judgements.rows, axis=0).sum()
    varies = np.ptp(judgements.rows, axis=0) > 0.0
    kernel = Hyperparameters(AMPLITUDE[0] * MAX_SCORE**2, varies / max(float(spread), 1.0), NOISE**2)
    told = understood(judgements, kernel, MAX_SCORE / 2.0)
    process = grouped.fit_observed(told.seen, groups=groups, continuous=continuous, seed=seed, starts=1)
    told = _under(judgements, process)
    process = grouped.fit_observed(told.seen, groups=groups, continuous=continuous, seed=seed)
    told = _under(judgements, process)
    return told, _given(process, told.observations)


def _under(judgements: Judgements, process: GroupedPreference) -> Understood:
    """What labels say under the best kernel of a process."""
    kernel = process.explanations[0].posterior.hyperparameters
    return understood(judgements, kernel, middle_of(judgements, kernel))


def _given(process: GroupedPreference, observations: Observations) -> GroupedPreference:
    """The kernels of a process, given other observations."""
    explanations = tuple(
        replace(explanation, posterior=condition(explanation.posterior.hyperparameters, observations))
        for explanation in process.explanations
    )
    return replace(process, observations=observations, explanations=explanations)


def _share(
    judgements: Judgements, told: Understood, groups: Ints, continuous: Flags, seed: int, cells: PartitionPreference
) -> float:
    """The share of the process under which held-out labels are likeliest."""
    randomness = np.random.default_rng(seed)
    num_rows, num_labels = len(judgements.rows), len(judgements.scores)
    # Labels of equal rows are held out together: otherwise one would tell the other.
    fold_of = randomness.permutation(FOLDS * (1 + num_rows // FOLDS))[:num_rows] % FOLDS
    first, compared = judgements.first, judgements.second >= 0
    second = np.where(compared, judgements.second, first)
    some = np.zeros(num_labels, dtype=bool)
    some[randomness.permutation(num_labels)[:MOST]] = True
    evidence = np.zeros(len(SHARES))
    for number in range(FOLDS):
        out = (fold_of[first] == number) | (fold_of[second] == number)
        known, apart = ~out[told.label], np.flatnonzero((fold_of[told.of] != number).all(axis=1))
        held = np.flatnonzero(out & some)
        if len(held) and known.any() and len(apart):
            part = told.seen.take(apart)
            process = grouped.fit_observed(part, groups=groups, continuous=continuous, seed=seed, starts=1)
            process = _given(process, told.observations.take(apart))
            with threadpool_limits(1, "blas"):
                sketch = cells.without(told.rows[known], told.scores[known], continuous, told.said.take(known))
            parts = [
                np.clip(preference.predict(judgements.rows).mean, 0.0, MAX_SCORE) for preference in (process, sketch)
            ]
            for place, share in enumerate(SHARES):
                values = share * parts[0] + (1.0 - share) * parts[1]
                differences = values[first[held]] - compared[held] * values[second[held]]
                evidence[place] += _log_likelihood(told.bounds.take(held), differences, cells)
    return next(share for share, found in zip(SHARES, evidence, strict=True) if found >= evidence.max() - AS_GOOD)


def _log_likelihood(said: Intervals, values: Floats, cells: PartitionPreference) -> float:
    """Of what was said of values [n], by somebody who errs as cells have it."""
    noise, blunders = max(cells.noise, LEAST_NOISE), max(cells.blunders, BLUNDERS)
    evidence, _, _ = matched(said, values, np.full(len(values), 1e-9), noise, blunders)
    return float(evidence.sum())
