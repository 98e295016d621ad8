"""Shares of a process beside cells, and of lines beside both, by the likelihood of held-out scores.

Cells (`grammarlab.preference.cells.partition`) are better than processes if a person has few values and makes errors,
processes (`grammarlab.preference.processes.grouped`) are better than cells if many parts or draws add up, or scores are
exact. Lines (`grammarlab.preference.lines`) are better than both if points of a few parts add up. All keep their
structure where scores are held out, so that they are about as optimistic.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from grammarlab.arrays import FEW, Flags, Floats, Ints
from grammarlab.preference.base import MANY_LABELS, MAX_SCORE, MIN_SHARE, ODDS_OF_SIMPLER, SCORE_STEP
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.lines.line_preference import LinePreference
from grammarlab.preference.observations import observe
from grammarlab.preference.person import MODEL_NOISES, START_BLUNDERS, expected_score
from grammarlab.preference.processes.grouped import GroupedPreference
from grammarlab.preference.unexplained import folds_of

PROCESS_SHARES = (0.0, 0.05, 0.1, 0.25, 0.5, 0.75, 0.99)
"""Candidate shares of the process."""
_ODDS_OF_OTHERS = 5.0
"""Prior odds of no lines against any other share of them."""
_ODDS_OF_BOXES = 1e4
"""Prior odds of cells alone if boxes explain the scores: most questions were about what boxes dispute, where they know
least."""
_MISSED_BY_BOXES = 0.1
"""Share of held-out scores that say nothing if boxes explain the scores: these are looked for again without them, and
one bound more or less decides about many of the scores that boxes disputed."""
_MAX_LOG_ODDS = 100.0
"""Largest log of prior odds, in either direction: what held-out scores say may still be heard."""
_LIKELIHOOD_POWER = 0.25
"""Power of the likelihood of held-out scores. Scores were asked for where the preference was open, and both parts know
their structure from all scores."""
EVIDENCE_POWER = 0.5
"""Power of the evidence of a part: it is that of the best explanation of many, found with all labels."""
_LOG_ODDS_OF_CELLS = float(np.log(ODDS_OF_SIMPLER))
"""Log of the prior odds of cells alone against any other share."""
NUM_FOLDS = FEW
"""Number of parts of the labels, each held out once."""

Sketch = tuple[GroupedPreference, PartitionPreference]
"""Both kinds of preference, fitted quickly to a part of the labels."""


class Fitted(NamedTuple):
    """All kinds of preference, fitted to the same labels."""

    process: GroupedPreference
    cells: PartitionPreference
    line: LinePreference


class HeldOut(NamedTuple):
    """What held-out scores say."""

    share: float
    """Share of the process beside cells, 0 to 1."""
    line_share: float
    """Share of lines beside both, 0 to 1."""
    errors: Floats
    """[n] predictions of held-out scores with these shares, minus the scores."""
    scores: Floats
    """[n] these scores."""
    sketches: tuple[Fitted, ...]
    """Fits without the held-out scores."""

    @property
    def explained_variance(self) -> float | None:
        """Share of the variance of the scores that predictions explain, 0 to 1; None if the scores are equal."""
        variance = float(np.var(self.scores))
        return max(1.0 - float(np.mean(self.errors**2)) / variance, 0.0) if variance > 0.0 else None


def held_out(rows: Floats, scores: Floats, continuous: Flags, seed: int, parts: Fitted, advantage: float) -> HeldOut:
    """Predictions of held-out scores by all parts, and the shares that explain these best.

    Args:
        rows: [n, F] rows of the labels.
        scores: [n] 0-100.
        continuous: [F] whether columns are continuous instead of counts.
        seed: seed of the choice of held-out labels.
        parts: the parts, fitted to all labels.
        advantage: evidence of lines less that of cells, in nats.
    """
    process, cells, line = parts
    selected = some_labels(len(scores), seed)
    rows, scores = rows[selected], scores[selected]
    fold = folds_of(rows, seed, NUM_FOLDS)
    predicted, sketches = np.zeros((3, len(scores))), list[Fitted]()
    for number in range(NUM_FOLDS):
        is_held_out, is_training = fold == number, fold != number
        if is_held_out.any() and is_training.any():
            # A process that is fitted to fewer labels often ends in a poor optimum.
            with threadpool_limits(1, "blas"):
                sketch = Fitted(
                    process.conditioned_on(observe(rows[is_training], scores[is_training])),
                    cells.without(rows[is_training], scores[is_training], continuous),
                    line.without(rows[is_training], scores[is_training]),
                )
                predicted[:, is_held_out] = [preference.predict(rows[is_held_out]).mean for preference in sketch]
            sketches.append(sketch)
    # Blunders are a part of the likelihood of their own.
    predicted[1] = expected_score(predicted[1], cells.noise, blunders=0.0)
    predicted[2] = expected_score(predicted[2], line.noise, blunders=0.0)
    predicted = np.clip(predicted, 0.0, MAX_SCORE)
    share = _share(rows, scores, predicted[:2], cells)
    without_line = share * predicted[0] + (1.0 - share) * predicted[1]
    # Lines and cells have an evidence of their own, which says more than held-out scores.
    log_odds = float(np.log(_ODDS_OF_OTHERS)) - EVIDENCE_POWER * (1.0 - share) * advantage
    both = np.stack([predicted[2], without_line])
    is_open = len(line.columns) > 0 and not _explains_all(cells)
    line_share = share_by(both, scores, _designs(rows), log_odds) if is_open else 0.0
    errors = line_share * predicted[2] + (1.0 - line_share) * without_line - scores
    return HeldOut(share, line_share, errors, scores, tuple(sketches))


def some_labels(num: int, seed: int) -> Ints:
    """Indices of at most `MANY_LABELS` of a number of labels, ascending."""
    return np.sort(np.random.default_rng(seed).permutation(num)[:MANY_LABELS])


def _share(rows: Floats, scores: Floats, predicted: Floats, cells: PartitionPreference) -> float:
    # Cells that like no scored design would only make the values of the process smaller.
    if cells.predict(rows).mean.max() < SCORE_STEP:
        return 1.0
    if _explains_all(cells):
        return 0.0
    prior = (float(np.log(_ODDS_OF_BOXES)), _MISSED_BY_BOXES) if cells.boxes else (_LOG_ODDS_OF_CELLS, START_BLUNDERS)
    return share_by(predicted, scores, _designs(rows), *prior)


def _explains_all(cells: PartitionPreference) -> bool:
    """Whether boxes contradict no score: they are no worse for missing some of them, held out near a bound."""
    return len(cells.boxes) > 0 and not cells.person.errs


def _designs(rows: Floats) -> Ints:
    """[n] number of the design of each row, from 0."""
    return np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1)


def share_by(
    predicted: Floats,
    scores: Floats,
    row: Ints,
    log_odds_of_cells: float = _LOG_ODDS_OF_CELLS,
    blunders: float = START_BLUNDERS,
) -> float:
    """The share of the process beside cells, or of lines beside both, by held-out scores.

    Args:
        predicted: [2, n] predictions of the process and of the cells, 0-100, or of lines and of the others.
        scores: [n] 0-100; each is random with a small probability.
        row: [n] design of each score, from 0; a design counts once, with the mean of its scores.
        log_odds_of_cells: log of the prior odds of cells alone.
        blunders: probability that a score says nothing.
    """
    shares = np.array(PROCESS_SHARES)[:, None]
    process, cells, mean_scores = (np.bincount(row, values) / np.bincount(row) for values in (*predicted, scores))
    errors = shares * process + (1.0 - shares) * cells - mean_scores
    likelihoods = np.full(len(PROCESS_SHARES), -np.inf)
    for noise in MODEL_NOISES:
        densities = np.exp(-0.5 * (errors / noise) ** 2) / (noise * np.sqrt(2.0 * np.pi))
        likelihood = np.log((1.0 - blunders) * densities + blunders / MAX_SCORE).sum(axis=1)
        likelihoods = np.logaddexp(likelihoods, likelihood)
    return mean_share(likelihoods, log_odds_of_cells)


def mean_share(log_likelihoods: Floats, log_odds_of_cells: float = _LOG_ODDS_OF_CELLS) -> float:
    """The mean of `PROCESS_SHARES` under their posterior; 0 if it is small.

    Args:
        log_likelihoods: [S] log-likelihood of held-out labels for each of the shares.
        log_odds_of_cells: log of the prior odds of cells alone against any other share, infinite if nothing else is
            possible.
    """
    log_odds = _LIKELIHOOD_POWER * log_likelihoods
    log_odds[0] += np.clip(log_odds_of_cells, -_MAX_LOG_ODDS, _MAX_LOG_ODDS)
    odds = np.exp(log_odds - log_odds.max())
    share = float(odds @ np.array(PROCESS_SHARES) / odds.sum())
    return share if share >= MIN_SHARE else 0.0
