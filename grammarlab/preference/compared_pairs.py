"""Pairs of models to compare.

For jointly normal values, the difference d of two has a mean m, and its observation has the noise of two values. Let
s^2 be the variance of the observation, and z = m / s. An answer lowers the variance of a value f, on average over both
answers, by

    cov(f, d)^2 / s^2 * phi(z)^2 / (Phi(z) (1 - Phi(z)))

which is exact for one answer, and at most 2 / pi of the gain from the difference itself.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfcx, ndtr

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.base import AbstractPreference
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.person import MODEL_NOISE
from grammarlab.preference.processes.disagreement import cautious_weights, joint
from grammarlab.preference.queries import MIN_HIGHEST, SMALL_PART, Situation

_MAX_CANDIDATES = 240, 60, 100
"""Largest numbers of candidates: from the grammar, from elsewhere, and with labels."""


def propose_pairs(situation: Situation, compared: Ints, num: int, seed: int) -> Ints:
    """Pairs of models to compare next, with random sides.

    Args:
        situation: the pool and the state; ``scored`` are the models with labels.
        compared: [k, 2] pairs that were compared; they are not asked about again.
        num: number of pairs, >= 0; fewer if there are no more.
        seed: seed of the random choices; the same seed gives the same pairs.

    Returns:
        [num, 2] indices into the pool, all different.
    """
    randomness = np.random.default_rng(seed)
    candidates = _candidates(situation, 2 * num, randomness)
    index_of = {model: index for index, model in enumerate(candidates.tolist())}
    allowed = ~np.eye(len(candidates), dtype=bool)
    for pair in compared.tolist():
        if set(pair) <= set(index_of):
            here = [index_of[model] for model in pair]
            allowed[np.ix_(here, here)] = False
    if situation.preference is None:
        covariance = np.eye(len(candidates))
        pairs = most_telling_pairs(np.zeros(len(candidates)), covariance, num, 1.0, np.ones(len(candidates)), allowed)
    else:
        rows = situation.pool[candidates]
        mean, covariance, noise = _expected(situation.preference, rows)
        highest = max(float(mean.max(initial=0.0)), MIN_HIGHEST)
        stakes = situation.stands_for(candidates) / (np.maximum(mean, 0.0) + SMALL_PART * highest)
        pairs = most_telling_pairs(mean, covariance, num, noise, stakes, allowed)
    return randomness.permuted(candidates[pairs], axis=1)


def most_telling_pairs(
    mean: Floats, covariance: Floats, num: int, noise: float, stakes: Floats, allowed: NDArray[np.bool_]
) -> Ints:
    """Pairs whose comparison lowers the total variance most, chosen greedily.

    Args:
        mean: [m] mean of the values.
        covariance: [m, m] covariance of the values.
        num: number of pairs; fewer if there are no more.
        noise: variance of the noise of one value, > 0.
        stakes: [m] >= 0, weight of the variance of each model.
        allowed: [m, m] whether models may be compared, symmetric; a model is compared once.

    Returns:
        [num, 2] indices, best first.
    """
    posterior, is_open = covariance.copy(), np.triu(allowed, 1)
    chosen: list[tuple[int, int]] = []
    while len(chosen) < num and is_open.any():
        variances = np.diagonal(posterior)
        difference_variances = np.maximum(variances[:, None] + variances - 2.0 * posterior, 0.0) + 2.0 * noise
        gain_factors = _sign_gain((mean[:, None] - mean) / np.sqrt(difference_variances)) / difference_variances
        weighted = (posterior * stakes) @ posterior
        drops = np.diagonal(weighted)
        gain = np.where(is_open, gain_factors * np.maximum(drops[:, None] + drops - 2.0 * weighted, 0.0), -1.0)
        first, second = divmod(int(np.argmax(gain)), len(mean))
        chosen.append((first, second))
        for model in (first, second):
            is_open[model] = is_open[:, model] = False
        across = posterior[first] - posterior[second]
        posterior -= np.outer(across, across * gain_factors[first, second])
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)


def _sign_gain(deviations: Floats) -> Floats:
    """Share of the gain from a noisy difference that its sign has, by the number of deviations of its mean from 0.

    >>> _sign_gain(np.array([0.0, 3.0, 1e8])).round(3).tolist()
    [0.637, 0.015, 0.0]
    """
    far = np.abs(deviations)
    # The density over Phi(-z), finite however surely an answer is known.
    rate = np.sqrt(2.0 / np.pi) / erfcx(far / np.sqrt(2.0))
    return ndtr(-far) * rate * rate / ndtr(far)


def _expected(preference: AbstractPreference, rows: Floats) -> tuple[Floats, Floats, float]:
    """Mean [m] and covariance [m, m] of the values of rows [m, F], and the variance of the noise of one value."""
    if not isinstance(preference, BlendedPreference):
        predicted = preference.predict(rows)
        return predicted.mean, np.diag(predicted.std**2), MODEL_NOISE**2
    share = preference.share
    by_process, among = joint(preference.process, rows, cautious_weights(preference.process, rows))
    by_cells, between = preference.partition.joint(rows)
    apart = by_process - by_cells
    mean = share * by_process + (1.0 - share) * by_cells
    covariance = share * among + (1.0 - share) * between + share * (1.0 - share) * np.outer(apart, apart)
    return mean, covariance, max(preference.noise, MODEL_NOISE) ** 2


def _candidates(situation: Situation, least: int, randomness: np.random.Generator) -> Ints:
    """Candidate models: from the grammar, from elsewhere, and with labels."""
    new = np.ones(len(situation.pool), dtype=bool)
    new[situation.scored] = False
    kinds = new & situation.from_grammar, new & ~situation.from_grammar, ~new
    most = (max(_MAX_CANDIDATES[0], least), *_MAX_CANDIDATES[1:])
    drawn = [randomness.permutation(np.flatnonzero(kind))[:num] for kind, num in zip(kinds, most, strict=True)]
    return np.concatenate(drawn)
