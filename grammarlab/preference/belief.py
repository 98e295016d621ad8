"""How far the parts of a blend are believed, against the hypothesis that no column explains the scores.

Each part gains some nats on that hypothesis (`grammarlab.preference.unexplained`), and is believed with the
probability that follows from the gain and from prior odds. Leaving the grammar as it was needs evidence: few scores are
explained by something in hundreds of columns, so the odds are higher for few scores.

Cells have an evidence of their own, in which the search for their divisions has its price; their held-out scores
misjudge them in both directions. The evidence of a process is a maximum over kernels, so it is judged by held-out
scores. Kernels are searched for again without them, since kernels that were found with them contain them.

A process may be right in one of two ways. Where values change smoothly, it says which of the values of this person a
design has: what it learned about the design multiplies the distribution h of values. What it learned is its prediction
without its prior, which h replaces. A prior with mean 0 and variance k that becomes mean m and variance s^2 was told of
a value m / r with variance s^2 / r, where r = 1 - s^2 / k is the share of the variance that is known (a product of
normal densities). So h becomes

    h(v) exp(-(m - r e(v))^2 / 2 (r s^2 + r^2 t^2)),

with e(v) the mean score of a value. The likelihood is a mean over standard deviations t of what the process misses. So
it gains nothing by agreeing with h, says nothing where it knows nothing, and loses little if it is wrong about some
scores.

Where values jump, as from 0 to 100, a process misses nearly all of them and still knows where the liked designs are: a
mean of 40 where others have 20 says that liked designs are twice as frequent. If it is right to a share w, a design
whose value by the process is q times that of all designs has the mean value u = (1 - w + w q) l, with l and k the mean
and the variance of h, and h becomes

    h(v) (1 + (u - l) (v - l) / k), where that is positive.

For two values this is the only distribution with this mean. The likelihood is a mean over shares w. By chance, a
process seems right to some small share more easily than within some points: so its odds have to overcome those of
what counts as certain.
"""

from __future__ import annotations

import numpy as np
from scipy.special import expit

from grammarlab.arrays import ROUNDING, Flags, Floats, Ints
from grammarlab.preference.cells.cells import grid_of
from grammarlab.preference.held_out_share import PROCESS_SHARES, some_labels
from grammarlab.preference.person import NOISES, expected_score, log_likelihood, mean_value
from grammarlab.preference.processes import grouped
from grammarlab.preference.unexplained import Unexplained, folds_of, unexplained

SURE = 0.95
"""Probability from which on something counts as certain."""
_MIN_ODDS = 3.0
"""Prior odds that nothing is explained, against a part that explains something, if there are many scores."""
_ODDS_SCORES = 80.0
"""Number of scores times the prior odds, if there are few scores."""
_NUM_STARTS = 2
"""Number of starts of each search for kernels: with one, smooth preferences of many draws are missed."""


def belief(gain: float, num_scores: int) -> float:
    """Probability that a part explains the scores, 0 to 1.

    Args:
        gain: its evidence on that of nothing explained, in nats.
        num_scores: number of scores, >= 1.

    >>> round(belief(0.0, 16), 3), round(belief(0.0, 1000), 3), round(belief(10.0, 16), 3)
    (0.167, 0.25, 1.0)
    """
    odds = max(_MIN_ODDS, _ODDS_SCORES / num_scores)
    return float(expit(gain - np.log(odds)))


def believed(share: float, process: float, cells: float) -> tuple[float, float, float]:
    """Share of the process in what is explained, the share that is not, and what of the first it has from cells.

    These are expectations if each part is right or wrong on its own: a part that is wrong hands its share to the other.

    Args:
        share: share of the process if both parts are believed, 0 to 1.
        process: belief in the process, 0 to 1.
        cells: belief in the cells, 0 to 1.

    >>> believed(0.25, 1.0, 1.0), believed(0.25, 0.0, 1.0), believed(0.25, 0.0, 0.0)
    ((0.25, 0.0, 0.0), (0.0, 0.0, 0.0), (0.25, 1.0, 0.0))
    """
    handed = process * (1.0 - share) * (1.0 - cells)
    by_process = process * share + handed
    by_cells = cells * (1.0 - share + share * (1.0 - process))
    explained = by_process + by_cells
    unexplained = (1.0 - process) * (1.0 - cells)
    rest = unexplained if 1.0 - SURE < unexplained < SURE else float(round(unexplained))
    return (by_process / explained, rest, handed / explained) if explained > 0.0 else (share, rest, 0.0)


def process_gain(rows: Floats, scores: Floats, *, groups: Ints, continuous: Flags, seed: int) -> float:
    """Gain of the evidence of a process on nothing explained, by held-out scores, in nats; 0 if all rows are equal.

    Args:
        rows: [n, F] rows of the labels.
        scores: [n] 0-100.
        groups: [F] group numbers.
        continuous: [F] whether columns are continuous.
        seed: seed of the held-out labels, and of the selection where there are many labels.
    """
    selected = some_labels(len(scores), seed)
    rows, scores = rows[selected], scores[selected]
    fold = folds_of(rows, seed)
    if not fold.any():
        return 0.0
    flat = unexplained(scores, fold, grid_of(scores))
    means, sds, informed, ratios = np.zeros((4, len(scores)))
    for number in range(int(fold.max()) + 1):
        out = fold == number
        process = grouped.fit(
            rows[~out], scores[~out], groups=groups, continuous=continuous, seed=seed, starts=_NUM_STARTS
        )
        prediction = process.predict(rows)
        deviations = np.sqrt(np.maximum(prediction.std**2 - process.noise_variance, 0.0))
        values = mean_value(prediction.mean, deviations, flat.person.noise)
        means[out], sds[out] = prediction.mean[out], deviations[out]
        # Where nothing is liked, no design is liked more than another.
        ratios[out] = values[out] / values.mean() if values.any() else 1.0
        informed[out] = np.clip(1.0 - sds[out] ** 2 / process.prior_variance, 0.0, 1.0)
    by_misses = gain_by_misses(flat, scores, fold, means, sds, informed)
    by_shares = gain_by_shares(flat, scores, fold, ratios)
    # Two ways to be right, the second with the prior odds of what is taken for certain against it.
    log_odds = float(np.log(_MIN_ODDS * (1.0 - SURE) / SURE))
    return float(np.logaddexp(by_misses, by_shares + log_odds) - np.logaddexp(0.0, log_odds))


def gain_by_misses(
    flat: Unexplained, scores: Floats, fold: Ints, means: Floats, sds: Floats, informed: Floats
) -> float:
    """Gain in nats of predictions of held-out scores that miss values by some points, on nothing explained.

    Args:
        flat: nothing explained.
        scores: [n] 0-100.
        fold: [n] part of each score, which `flat` and the predictions were made without.
        means: [n] predicted means of scores.
        sds: [n] >= 0, standard deviations of these means.
        informed: [n] share of the prior variance that is known of each, 0 to 1.
    """
    known = np.maximum(informed, ROUNDING)[:, None]
    away = (means[:, None] - known * expected_score(flat.grid, flat.person.noise, blunders=0.0)) ** 2
    # A common factor changes nothing, and keeps the largest of each row at 1.
    away -= away.min(axis=1, keepdims=True)
    variances = known * sds[:, None] ** 2 + known**2 * np.array(NOISES)[:, None, None] ** 2
    return _gain(flat, scores, fold, np.exp(-0.5 * away / variances))


def gain_by_shares(flat: Unexplained, scores: Floats, fold: Ints, ratios: Floats) -> float:
    """Gain in nats of predictions of held-out scores that are right to some share, on nothing explained.

    Args:
        flat: nothing explained.
        scores: [n] 0-100.
        fold: [n] part of each score, which `flat` and the predictions were made without.
        ratios: [n] >= 0, predicted value of each design, divided by the mean of all designs.
    """
    levels = flat.held_out @ flat.grid
    away = flat.grid - levels[:, None]
    variances = np.maximum((flat.held_out * away**2).sum(axis=1), ROUNDING)
    slopes = np.array(PROCESS_SHARES[1:])[:, None] * (ratios - 1.0) * (levels / variances)[fold]
    return _gain(flat, scores, fold, np.maximum(1.0 + slopes[:, :, None] * away[fold], ROUNDING))


def _gain(flat: Unexplained, scores: Floats, fold: Ints, tilts: Floats) -> float:
    """Gain in nats by factors [T, n, G] on the probabilities of values, a mean over the first axis."""
    likelihoods = np.exp(log_likelihood(scores, flat.grid, *flat.person).astype(np.float64))
    values = flat.held_out[fold]
    tilted = values * tilts
    predicted = (tilted * likelihoods).sum(axis=2) / tilted.sum(axis=2)
    gains = np.log(predicted / (values * likelihoods).sum(axis=1)).sum(axis=1)
    return float(np.logaddexp.reduce(gains) - np.log(len(tilts)))
