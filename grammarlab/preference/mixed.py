"""The default preference of labels of several kinds: scores, stars, thumbs and comparisons in one likelihood.

Under a kernel, sites take the place of what is not a score (`grammarlab.preference.kinds`); a kernel is searched for
with these, and so in turns. Cells are told the intervals that values lie in. Scores alone never come here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.preference import grouped, partition
from grammarlab.preference.base import MAX_SCORE, Floats, Ints, Rows
from grammarlab.preference.blended import AS_GOOD, FEWEST, FOLDS, MOST, SHARES, BlendedPreference
from grammarlab.preference.grouped import GroupedPreference
from grammarlab.preference.grouped_search import AMPLITUDE
from grammarlab.preference.kinds import Judgements, Understood, judgements_of, middle_of, understood
from grammarlab.preference.labels import Kind
from grammarlab.preference.likelihood import Intervals, expected_score
from grammarlab.preference.observations import checked_groups, checked_kinds
from grammarlab.preference.partition import PartitionPreference
from grammarlab.preference.posterior import Hyperparameters
from grammarlab.preference.splits import Flags

NOISE = 5.0
"""Standard deviation in points that is assumed as long as no kernel has been found."""
UNSURE = 10.0
"""Standard deviation in points from which on a bound tells little."""


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
    looked = grouped.fit_observed(told.observations, groups=groups, continuous=continuous, seed=seed, starts=1)
    kernel = looked.explanations[0].posterior.hyperparameters
    told = understood(judgements, kernel, middle_of(judgements, kernel))
    return told, grouped.fit_observed(told.observations, groups=groups, continuous=continuous, seed=seed)


def _share(
    judgements: Judgements, told: Understood, groups: Ints, continuous: Flags, seed: int, cells: PartitionPreference
) -> float:
    """The share of the process that predicts held-out labels best."""
    randomness = np.random.default_rng(seed)
    # Labels of equal rows are held out together: otherwise one would tell the other.
    num_rows = len(judgements.rows)
    fold_of = randomness.permutation(FOLDS * (1 + num_rows // FOLDS))[:num_rows] % FOLDS
    some = np.zeros(len(told.scores), dtype=bool)
    some[randomness.permutation(len(some))[:MOST]] = True
    fold, observations = fold_of[told.row], told.observations
    predicted, looked_at = np.zeros((2, len(some))), np.zeros(len(some), dtype=bool)
    for number in range(FOLDS):
        held, known = (fold == number) & some, fold != number
        apart = np.flatnonzero((fold_of[told.of] != number).all(axis=1))
        if held.any() and known.any() and len(apart):
            part = observations.take(apart)
            process = grouped.fit_observed(part, groups=groups, continuous=continuous, seed=seed, starts=1)
            predicted[0, held] = process.predict(told.rows[held]).mean
            with threadpool_limits(1, "blas"):
                sketch = cells.without(told.rows[known], told.scores[known], continuous, told.said.take(known))
                predicted[1, held] = sketch.predict(told.rows[held]).mean
            looked_at |= held
    plain = np.arange(len(some)) < judgements.num_scores
    predicted[1, plain] = expected_score(predicted[1, plain], cells.noise, cells.blunders)
    predicted, said = np.clip(predicted[:, looked_at], 0.0, MAX_SCORE), told.said.take(looked_at)
    losses = [_missed(share * predicted[0] + (1.0 - share) * predicted[1], said) for share in SHARES]
    return next(share for share, loss in zip(SHARES, losses, strict=True) if loss <= AS_GOOD * min(losses))


def _missed(values: Floats, said: Intervals) -> float:
    """Squared points by which values miss the intervals that they should lie in; a bound that is unsure counts less."""
    missed = values - np.clip(values, said.low, said.high)
    return float(np.sum(missed**2 / (1.0 + said.variance / UNSURE**2)))
