"""Scores of (parcel, zone) as answers: P(k | x) is proportional to prior_k times the predicted score ŝ(x, k).

The score is predicted by a preference of `grammarlab.preference` from the fields, the place and the zone, for every
zone of every parcel with a score. A parcel then counts as so many drawn zones as make its P as uncertain as its
predicted scores are, and `grammarlab.city.zone_learning` learns from these counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.city.fields import ParcelFields
from grammarlab.city.zone_density import places_km
from grammarlab.extras import named_extras
from grammarlab.preference.base import MAX_SCORE

_MIN_SCORE = 0.5
"""Smallest predicted score, in points, so that no zone is impossible."""
_COUNTS = (0.5, 50.0)
"""Fewest and most drawn zones that a parcel counts as."""


@dataclass(frozen=True, eq=False)
class ScoredZones:
    """n scores of zones at parcels."""

    fields: ParcelFields
    """Fields of N parcels."""
    parcel: Ints
    """[n] row of the parcel of each score."""
    zone: Ints
    """[n] zone of each score, 0 <= zone < K."""
    score: Floats
    """[n] 0 to 100."""


def counts_of_scores(scored: ScoredZones, prior: Floats) -> Floats:
    """[N, K] counts of zones that say as much as the scores.

    Args:
        scored: the scores.
        prior: [K] > 0, shares of the zones if all scores are equal; any scale.

    Raises:
        UsageError: If the extra ``learn`` is missing.
    """
    order = np.lexsort((scored.score, scored.zone, scored.parcel))
    mean, sd = _predicted(scored, order, len(prior))
    chance = prior * mean
    total = chance.sum(axis=1, keepdims=True)
    chance /= total
    # Change of P_k with each score j, times its standard deviation.
    change = (np.eye(len(prior)) - chance[:, :, None]) * (prior * sd / total)[:, None, :]
    variance = (change**2).sum(axis=(1, 2))
    # The variance of shares of `number` drawn zones, as of a Dirichlet distribution with this sum of parameters.
    number = (chance * (1 - chance)).sum(axis=1) / np.maximum(variance, 1e-12) - 1.0
    return chance * np.clip(number, *_COUNTS)[:, None]


def _predicted(scored: ScoredZones, order: Ints, num_zones: int) -> tuple[Floats, Floats]:
    """[N, K] expected scores > 0, and their standard deviations."""
    with named_extras():
        from grammarlab.preference import blended  # noqa: PLC0415  # needs an extra
    numbers = np.column_stack([scored.fields.values, places_km(scored.fields, scored.fields.frame)])
    numbers = np.nan_to_num((numbers - np.nanmean(numbers, axis=0)) / np.maximum(np.nanstd(numbers, axis=0), 1e-9))
    flags = np.eye(num_zones)
    groups = [*range(numbers.shape[1]), *([numbers.shape[1]] * num_zones)]
    rows = np.column_stack([numbers[scored.parcel], flags[scored.zone]])[order]
    continuous = np.ones(len(groups), np.bool_)
    preference = blended.fit(rows, scored.score[order], groups=groups, continuous=continuous)
    every = np.column_stack([np.repeat(numbers, num_zones, axis=0), np.tile(flags, (len(numbers), 1))])
    prediction = preference.predict(every)
    mean = np.clip(prediction.mean, _MIN_SCORE, MAX_SCORE).reshape(-1, num_zones)
    return mean, prediction.std.reshape(-1, num_zones)
