"""The default preference: a blend of cells that pool their scores and Gaussian processes, weighted by held-out scores.

Cells (`grammarlab.preference.cells.partition`) are better than processes if a person has few values and makes errors,
processes (`grammarlab.preference.processes.grouped`) are better than cells if many parts or draws add up, or scores are
exact. Their evidences are not comparable, so the weight is an average by the likelihood of held-out scores.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Prediction, Relevance, Rows, rows_to_predict
from grammarlab.preference.cells import partition
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.cells.person_error import BLUNDERS, NOISES
from grammarlab.preference.factors import level_of
from grammarlab.preference.likelihood import expected_score, value_of
from grammarlab.preference.observations import checked_groups, checked_kinds, checked_labels, observe
from grammarlab.preference.processes import grouped
from grammarlab.preference.processes.grouped import GroupedPreference

PROCESS_SHARES = (0.0, 0.05, 0.1, 0.25, 0.5, 0.75, 0.99)
"""Candidate shares of the process."""
_ODDS_OF_CELLS = 20.0
"""Prior odds of cells alone against any other share."""
_ODDS_OF_BOXES = 1e4
"""The same if boxes explain the scores: most questions were about what boxes dispute, where they know least."""
_MISSED_BY_BOXES = 0.1
"""Share of held-out scores that say nothing if boxes explain the scores: these are looked for again without them, and
one bound more or less decides about many of the scores that boxes disputed."""
_LIKELIHOOD_POWER = 0.25
"""Power of the likelihood of held-out scores. Scores were asked for where the preference was open, and both parts know
their structure from all scores."""
_NOISES = (3.0, 5.0, 7.5, 10.0, 13.0, 17.0, 22.0, 28.0)
"""Candidate standard deviations of the errors on held-out scores, in points."""
_MIN_SHARE = 0.005
"""Share of the process below which it is left out."""
NUM_FOLDS = 3
"""Number of parts of the labels, each held out once."""
MIN_LABELS = 16
"""Smallest number of labels for held-out scores; with fewer, only the process is used."""
MAX_HELD_OUT = 160
"""Largest number of labels that are held out in turn; of more, a part with the same distribution of scores."""
NUM_FEWER_STARTS = 3
"""Number of starts of the process with more labels than these, which leave fewer explanations open."""
_RATIO_POWER = 7.0
"""Power of the ratio of what cells and the process like of all designs. Where the process was the better part, they
liked about as much (.9 to 1.1); where it was the worse one, it liked 1.2 to 50 times as much."""
_MIN_DAMPING = 1e-9
"""Smallest factor on the odds of the process, so that they stay positive."""
_MIN_LIKED = 1.0
"""Smallest value of a liked design, in points."""
_SD_PER_MEDIAN = 1.4826
"""Ratio of the standard deviation to the median size of normal errors."""
_MAX_NOISE_FACTOR = 2.0
"""Largest factor on the noise of a process, which explains some noise by its function, and on the errors on held-out
scores; both miss noise clipped at 0."""


@dataclass(frozen=True, eq=False)
class BlendedPreference(AbstractPreference):
    """Result of `fit` with `method="blended"`."""

    process: GroupedPreference
    partition: PartitionPreference
    share: float
    """Share of the process in predictions, 0 to 1; the rest is the partition's."""
    held_out_error: float = 0.0
    """Error on held-out scores, as the standard deviation of normal errors with the same median; 0 without any."""
    sketches: tuple[BlendedPreference, ...] = ()
    """Quick fits to parts of the labels, each without its held-out scores."""
    damping: float = 1.0
    """Factor on the odds of the process in predictions, > 0 and at most 1, see `for_density`."""

    @property
    def num_columns(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride] - that of both parts
        """F: number of columns of the rows."""
        return self.process.num_columns

    def predict(self, rows: Rows) -> Prediction:
        mean, square = np.zeros(1), np.zeros(1)
        for share, preference in self._shares():
            part = preference.predict(rows) if preference is self.partition else self.predict_values(rows)
            mean, square = mean + share * part.mean, square + share * (part.std**2 + part.mean**2)
        deviation = np.sqrt(np.maximum(square - mean**2, 0.0))
        return Prediction(np.clip(mean, 0.0, MAX_SCORE), deviation)

    def predict_values(self, rows: Rows) -> Prediction:
        """Predicted values, as the process learns means of scores, and the deviation of scores around them."""
        prediction, noise_variance = (
            self.process.predict(rows),
            self.process.explanations[0].posterior.hyperparameters.noise,
        )
        deviation = np.sqrt(np.maximum(prediction.std**2 - noise_variance, 0.0) + self.noise**2)
        return Prediction(value_of(prediction.mean, *self._error_model), deviation)

    def column_weights(self) -> Floats:
        return self.process.column_weights()

    @property
    def noise(self) -> float:
        """Standard deviation of a score around its value, in points."""
        return self._error_model[0]

    @property
    def blunders(self) -> float:
        """Probability of a random score."""
        return self._error_model[1]

    @property
    def num_labels(self) -> int:
        """Number of labels that cells were fitted to."""
        return len(self.partition.cells.scores)

    @property
    def _error_model(self) -> tuple[float, float]:
        """Noise and blunders for the values of the process: each part is overconfident where it does not fit.

        Cells call noise what they do not divide, and a process explains noise by its function, which then appears in
        the errors on held-out scores. While cells divide nothing, these errors also contain the preference itself.
        """
        process_noise = float(np.sqrt(self.process.explanations[0].posterior.hyperparameters.noise))
        understated = _MAX_NOISE_FACTOR if self.partition.trees[0].split is not None else 1.0
        noise = min(self.partition.noise, max(_MAX_NOISE_FACTOR * process_noise, understated * self.held_out_error))
        return max(noise, NOISES[0]), self.partition.blunders if noise > NOISES[0] else 0.0

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        total = np.zeros(len(group_names))
        # By number: two groups may have the same name.
        numbers = [str(number) for number in range(len(group_names))]
        for share, preference in self._shares():
            for entry in preference.explain(numbers):
                total[int(entry.name)] += share * entry.share
        shares = zip(group_names, total.tolist(), strict=True)
        entries = [Relevance(name, share, level_of(share)) for name, share in shares]
        return sorted(entries, key=lambda relevance: -relevance.share)

    def for_density(self, rows: Rows, weights: Floats) -> BlendedPreference:
        """The preference for a density over designs.

        Cells have the values of `PartitionPreference.for_density`, and the process counts less if it likes more of the
        designs than cells do: if cells like one design in 10,000, a hundredth of a process that is not quite 0 for all
        others would hide it.

        Args:
            rows: [m, F] designs.
            weights: [m] >= 0, their density; not all 0.
        """
        if self.share == 1.0:
            return self
        table = rows_to_predict(rows, self.num_columns)
        cells = self.partition.for_density(table, weights)
        by_cells, by_process = self._liked_of(cells, table, weights)
        differences = self.process.observations.differences
        if differences is not None and differences.compared.any():
            # Comparisons leave the level of values open: designs are liked relative to the labelled ones.
            labelled = self.process.observations.all_rows
            of_labelled = self._liked_of(cells, labelled, np.full(len(labelled), 1.0 / len(labelled)))
            by_cells, by_process = by_cells * of_labelled[1], by_process * of_labelled[0]
        ratio = min(1.0, by_cells / by_process) if by_process > 0.0 else 1.0
        return replace(
            self,
            partition=cells,
            damping=max(ratio**_RATIO_POWER, _MIN_DAMPING) if self.share > 0.0 else 1.0,
            sketches=tuple(part.for_density(table, weights) for part in self.sketches),
        )

    def _liked_of(self, cells: PartitionPreference, rows: Floats, weights: Floats) -> tuple[float, float]:
        """What cells and the process like of some designs, as sums of values in points."""
        by_cells, by_process = (
            float(weights @ np.maximum(part.mean, 0.0)) for part in (cells.predict(rows), self.predict_values(rows))
        )
        return by_cells, by_process

    def _shares(self) -> Iterator[tuple[float, AbstractPreference]]:
        share = self.share * self.damping / (self.share * self.damping + 1.0 - self.share)
        if share > 0.0:
            yield share, self.process
        if share < 1.0:
            yield 1.0 - share, self.partition


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    groups: ArrayLike | None = None,
    continuous: ArrayLike | None = None,
    priors: ArrayLike | None = None,
    seed: int = 0,
    warm: AbstractPreference | None = None,
) -> BlendedPreference:
    """Both kinds of preference, and the share of each by held-out scores.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100.
        groups: [F] group numbers; by default every column is its own group.
        continuous: [F] whether columns are continuous instead of counts; by default none is.
        priors: [F] how likely columns are to matter, relative to each other, to cells.
        seed: seed of random starts and draws, and of the held-out labels.
        warm: not used.

    Raises:
        UsageError: If labels or groups are out of range.
    """
    table, values = checked_labels(rows, scores)
    numbers = checked_groups(groups, table.shape[1])
    drawn = checked_kinds(continuous, len(numbers))
    cells = partition.fit(table, values, groups=numbers, continuous=drawn, priors=priors, seed=seed)
    starts = NUM_FEWER_STARTS if len(values) > MAX_HELD_OUT else None
    process = grouped.fit(table, values, groups=numbers, continuous=drawn, seed=seed, starts=starts)
    if len(values) < MIN_LABELS:
        return BlendedPreference(process, cells, 1.0)
    return BlendedPreference(process, cells, *_share(table, values, drawn, seed, process, cells))


def _share(
    rows: Floats,
    scores: Floats,
    continuous: Flags,
    seed: int,
    process: GroupedPreference,
    cells: PartitionPreference,
) -> tuple[float, float, tuple[BlendedPreference, ...]]:
    """Share of the process by held-out scores, the error, and the fits without these labels."""
    randomness = np.random.default_rng(seed)
    selected = np.sort(randomness.permutation(len(scores))[:MAX_HELD_OUT])
    rows, scores = rows[selected], scores[selected]
    # Equal rows are held out together: otherwise one would predict the other.
    _, row = np.unique(rows, axis=0, return_inverse=True)
    row = row.reshape(-1)
    fold = randomness.permutation(NUM_FOLDS * (1 + int(row.max()) // NUM_FOLDS))[row] % NUM_FOLDS
    predicted, parts = np.zeros((2, len(scores))), list[tuple[GroupedPreference, PartitionPreference]]()
    for number in range(NUM_FOLDS):
        is_held_out, is_training = fold == number, fold != number
        if is_held_out.any() and is_training.any():
            # Both keep their structure, so that both are about as optimistic: a process that is fitted to fewer labels
            # often ends in a poor optimum.
            with threadpool_limits(1, "blas"):
                part = (
                    process.conditioned_on(observe(rows[is_training], scores[is_training])),
                    cells.without(rows[is_training], scores[is_training], continuous),
                )
                predicted[:, is_held_out] = [preference.predict(rows[is_held_out]).mean for preference in part]
            parts.append(part)
    # Blunders are a part of the likelihood of their own.
    predicted[1] = expected_score(predicted[1], cells.noise, blunders=0.0)
    predicted = np.clip(predicted, 0.0, MAX_SCORE)
    # Cells that like no scored design would only make the values of the process smaller.
    prior = (_ODDS_OF_BOXES, _MISSED_BY_BOXES) if cells.boxes else (_ODDS_OF_CELLS, BLUNDERS[1])
    if cells.predict(rows).mean.max() < _MIN_LIKED:
        share = 1.0
    elif cells.boxes and cells.noise <= NOISES[0] and cells.blunders <= BLUNDERS[0]:
        # Boxes that contradict no score are no worse for missing some of them, held out near a bound.
        share = 0.0
    else:
        share = _share_by(predicted, scores, row, *prior)
    errors = share * predicted[0] + (1.0 - share) * predicted[1] - scores
    sketches = tuple(BlendedPreference(*part, share) for part in parts)
    return share, float(np.median(np.abs(errors))) * _SD_PER_MEDIAN, sketches


def _share_by(
    predicted: Floats,
    scores: Floats,
    row: Ints,
    odds_of_cells: float = _ODDS_OF_CELLS,
    blunders: float = BLUNDERS[1],
) -> float:
    """The share of the process by held-out scores.

    Args:
        predicted: [2, n] predictions of the process and of the cells, 0-100.
        scores: [n] 0-100; each is random with a small probability.
        row: [n] design of each score, from 0; a design counts once, with the mean of its scores.
        odds_of_cells: prior odds of cells alone.
        blunders: probability that a score says nothing.
    """
    shares = np.array(PROCESS_SHARES)[:, None]
    process, cells, mean_scores = (np.bincount(row, values) / np.bincount(row) for values in (*predicted, scores))
    errors = shares * process + (1.0 - shares) * cells - mean_scores
    likelihoods = np.full(len(PROCESS_SHARES), -np.inf)
    for noise in _NOISES:
        densities = np.exp(-0.5 * (errors / noise) ** 2) / (noise * np.sqrt(2.0 * np.pi))
        likelihood = np.log((1.0 - blunders) * densities + blunders / MAX_SCORE).sum(axis=1)
        likelihoods = np.logaddexp(likelihoods, likelihood)
    return mean_share(likelihoods, odds_of_cells)


def mean_share(log_likelihoods: Floats, odds_of_cells: float = _ODDS_OF_CELLS) -> float:
    """The mean of `PROCESS_SHARES` under their posterior; 0 if it is small.

    Args:
        log_likelihoods: [S] log-likelihood of held-out labels for each of the shares.
        odds_of_cells: prior odds of cells alone against any other share.
    """
    odds = np.exp(_LIKELIHOOD_POWER * (log_likelihoods - log_likelihoods.max()))
    odds[0] *= odds_of_cells
    share = float(odds @ np.array(PROCESS_SHARES) / odds.sum())
    return share if share >= _MIN_SHARE else 0.0
