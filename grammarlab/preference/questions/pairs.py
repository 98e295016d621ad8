"""Which two models to ask somebody to compare.

Of values that are jointly normal the difference d of two has a mean m, and what is seen of it misses it by the noise
of two looks. Let s^2 be the variance of what is seen, and z = m / s. That one of them is preferred lowers the variance
of a value f, on average over both answers, by

    cov(f, d)^2 / s^2 * phi(z)^2 / (Phi(z) (1 - Phi(z)))

which is exact for one answer, and at most 2 / pi of what the difference itself would tell.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from grammarlab.preference.base import AbstractPreference, Floats, Ints
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.processes.disagreement import cautious_weights, joint
from grammarlab.preference.questions.queries import LEAST_LIKED, LEAST_NOISE, SMALL_PART, Situation

_CANDIDATES = 240, 60, 100
"""Models from the grammar, from elsewhere, and of those that something was said of, that are looked at, at most."""
_FAR = 8.0
"""Deviations beyond which an answer is known beforehand."""


def propose_pairs(situation: Situation, compared: Ints, num: int, seed: int) -> Ints:
    """Pairs of models to compare next, on either side by chance.

    Args:
        situation: the pool and what is known; ``asked`` are the models that something was said of.
        compared: [k, 2] pairs that were compared; they are not asked about again.
        num: how many, >= 0; fewer are given where there are no more.
        seed: the same seed gives the same pairs.

    Returns:
        [num, 2] indices into the pool, all different.
    """
    randomness = np.random.default_rng(seed)
    candidates = _candidates(situation, 2 * num, randomness)
    place = {model: index for index, model in enumerate(candidates.tolist())}
    allowed = ~np.eye(len(candidates), dtype=bool)
    for pair in compared.tolist():
        if set(pair) <= set(place):
            here = [place[model] for model in pair]
            allowed[np.ix_(here, here)] = False
    if situation.preference is None:
        covariance = np.eye(len(candidates))
        found = most_telling_pairs(np.zeros(len(candidates)), covariance, num, 1.0, np.ones(len(candidates)), allowed)
    else:
        rows = situation.pool[candidates]
        mean, covariance, noise = _expected(situation.preference, rows)
        highest = max(float(mean.max(initial=0.0)), LEAST_LIKED)
        stakes = situation.stands_for(candidates) / (np.maximum(mean, 0.0) + SMALL_PART * highest)
        found = most_telling_pairs(mean, covariance, num, noise, stakes, allowed)
    return randomness.permuted(candidates[found], axis=1)


def most_telling_pairs(
    mean: Floats, covariance: Floats, num: int, noise: float, stakes: Floats, allowed: NDArray[np.bool_]
) -> Ints:
    """Pairs whose comparison would lower the total variance most, one after the other, each given those before.

    Args:
        mean: [m] of the values.
        covariance: [m, m] of the values.
        num: how many pairs; fewer are given where there are no more.
        noise: variance of one look at a value, > 0.
        stakes: [m] >= 0, how much the variance of each model counts.
        allowed: [m, m] which models may be compared, symmetric; a model is compared once.

    Returns:
        [num, 2] indices, best first.
    """
    left, open_ = covariance.copy(), np.triu(allowed, 1)
    chosen: list[tuple[int, int]] = []
    while len(chosen) < num and open_.any():
        own = np.diagonal(left)
        seen = np.maximum(own[:, None] + own - 2.0 * left, 0.0) + 2.0 * noise
        told = _told((mean[:, None] - mean) / np.sqrt(seen)) / seen
        weighed = (left * stakes) @ left
        drops = np.diagonal(weighed)
        gain = np.where(open_, told * np.maximum(drops[:, None] + drops - 2.0 * weighed, 0.0), -1.0)
        one, other = divmod(int(np.argmax(gain)), len(mean))
        chosen.append((one, other))
        for model in (one, other):
            open_[model] = open_[:, model] = False
        across = left[one] - left[other]
        left -= np.outer(across, across * told[one, other])
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)


def _told(deviations: Floats) -> Floats:
    """How much of what a noisy difference would tell its sign tells, where its mean is so many deviations from 0.

    >>> _told(np.array([0.0, 3.0])).round(3).tolist()
    [0.637, 0.015]
    """
    far = np.minimum(np.abs(deviations), _FAR)
    beyond = ndtr(-far)
    return np.exp(-far * far) / (2.0 * np.pi * beyond * (1.0 - beyond))


def _expected(preference: AbstractPreference, rows: Floats) -> tuple[Floats, Floats, float]:
    """Mean [m] and covariance [m, m] of the values of rows [m, F], and the variance of a look at one."""
    if not isinstance(preference, BlendedPreference):
        predicted = preference.predict(rows)
        return predicted.mean, np.diag(predicted.std**2), LEAST_NOISE**2
    share = preference.share
    by_process, among = joint(preference.process, rows, cautious_weights(preference.process, rows))
    by_cells, between = preference.partition.joint(rows)
    apart = by_process - by_cells
    mean = share * by_process + (1.0 - share) * by_cells
    covariance = share * among + (1.0 - share) * between + share * (1.0 - share) * np.outer(apart, apart)
    return mean, covariance, max(preference.noise, LEAST_NOISE) ** 2


def _candidates(situation: Situation, least: int, randomness: np.random.Generator) -> Ints:
    """Models to choose from: of the grammar, of elsewhere, and some that something was said of."""
    new = np.ones(len(situation.pool), dtype=bool)
    new[situation.asked] = False
    kinds = new & situation.from_grammar, new & ~situation.from_grammar, ~new
    most = (max(_CANDIDATES[0], least), *_CANDIDATES[1:])
    drawn = [randomness.permutation(np.flatnonzero(kind))[:num] for kind, num in zip(kinds, most, strict=True)]
    return np.concatenate(drawn)
