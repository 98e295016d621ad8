"""The default preference: cells that pool their scores, Gaussian processes, lines of points, and what none explains.

Cells (`grammarlab.preference.cells.partition`), a process (`grammarlab.preference.processes.grouped`) and lines
(`grammarlab.preference.lines.line_preference`) have shares by
held-out scores (`grammarlab.preference.held_out_share`), as far as each of them is believed
(`grammarlab.preference.belief`). The rest is unexplained: there, all designs are liked equally, which keeps the grammar
as it was. So a preference from scores without a pattern, or from too few, is no preference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import expit, ndtri

from grammarlab.arrays import FEW, Floats
from grammarlab.preference.base import (
    MANY_LABELS,
    MAX_SCORE,
    AbstractPreference,
    Prediction,
    Relevance,
    Rows,
    rows_to_predict,
)
from grammarlab.preference.belief import SURE, belief, believed, process_gain
from grammarlab.preference.cells import partition
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.factors import level_of
from grammarlab.preference.held_out_share import Fitted, held_out
from grammarlab.preference.judge.labelled_columns import selected
from grammarlab.preference.judge.unexplained_scores import log_evidence_of_nothing
from grammarlab.preference.lines import line_preference
from grammarlab.preference.lines.line_preference import LinePreference
from grammarlab.preference.observations import checked_groups, checked_kinds, checked_labels
from grammarlab.preference.person import NOISES, Person, mean_value
from grammarlab.preference.processes import grouped
from grammarlab.preference.processes.grouped import GroupedPreference
from grammarlab.preference.unexplained import Unexplained, folds_of, unexplained

MIN_LABELS = 16
"""Smallest number of labels for a share of cells by held-out scores; with fewer, the process comes first. It is that of
different designs for what is explained of held-out scores: equal designs are held out together."""
_RATIO_POWER = 7.0
"""Power of the ratio of what cells and the process like of all designs. Where the process was the better part, they
liked about as much (.9 to 1.1); where it was the worse one, it liked 1.2 to 50 times as much."""
_MAX_NOISE_FACTOR = 2.0
"""Largest factor on the noise of a process, which explains some noise by its function, and on the errors on held-out
scores; both miss noise clipped at 0."""


class _Levels(NamedTuple):
    """Mean values of the parts over designs with a density, and how they are mixed."""

    levels: tuple[float, ...]
    """Mean value of the designs by the process, by cells, by lines, and if nothing is explained, in points."""
    share: float
    """Share of the process beside cells, 0 to 1."""
    scale: float = 1.0
    """Predicted value of a design of mean density, in points; it keeps the highest value of the designs."""


@dataclass(frozen=True, eq=False)
class BlendedPreference(AbstractPreference):
    """Result of `fit` with `method="blended"`."""

    process: GroupedPreference
    partition: PartitionPreference
    share: float
    """Share of the process beside cells, 0 to 1."""
    flat: Unexplained
    """The hypothesis that nothing is explained."""
    handed: float = 0.0
    """Part of this share that the process has because cells are not believed."""
    line: LinePreference | None = None
    """Lines of points; None if labels are not scores."""
    line_share: float = 0.0
    """Share of lines in what is explained, 0 to 1; the rest is that of the process and cells."""
    unexplained: float = 0.0
    """Probability that no pattern is known yet, 0 to 1: the share of the grammar that is kept."""
    held_out_error: float = 0.0
    """Error on held-out scores, as the standard deviation of normal errors with the same median; 0 without any."""
    explained_variance: float | None = None
    """Share of the variance of held-out scores that the parts explain, 0 to 1; None without any, if the scores are
    equal, and for too few different designs."""
    sketches: tuple[BlendedPreference, ...] = ()
    """Quick fits to parts of the labels, each without its held-out scores."""
    density: _Levels | None = None
    """What makes predictions a density, see `for_density`; None for predictions of scores only."""

    @property
    def num_columns(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride] - that of both parts
        """F: number of columns of the rows."""
        return self.process.num_columns

    @property
    def explaining(self) -> BlendedPreference:
        """What the parts explain, without the rest: a pattern is found by asking about what they dispute."""
        return replace(self, unexplained=0.0)

    def predict(self, rows: Rows) -> Prediction:
        parts = self._parts(rows_to_predict(rows, self.num_columns))
        of_scores = self._mixed(parts)
        values = of_scores.mean if self.density is None else self._density(parts, self.density)
        return Prediction(np.clip(values, 0.0, MAX_SCORE), of_scores.std)

    def predict_values(self, rows: Rows) -> Prediction:
        """Expected values, as the process learns means of scores, and the deviation of scores around them.

        A mean score that is not certain has an expected value above that of its mean near 0, below it near 100: where
        no design has been scored, a value near 0 would be a claim that all designs there are disliked. What is not
        certain about comparisons is the level of all values, which is the same for all designs.
        """
        prediction, noise_variance = self.process.predict(rows), self.process.noise_variance
        variance = np.maximum(prediction.std**2 - noise_variance, 0.0)
        # While all scores are 0, a process knows no scale, and its deviations are a convention.
        knows_deviations = not self._is_compared and bool(np.any(self.process.observations.means > 0.0))
        values = mean_value(prediction.mean, np.sqrt(variance * knows_deviations), *self.person)
        return Prediction(values, np.sqrt(variance + self.noise**2))

    @property
    def _is_compared(self) -> bool:
        """Whether some labels are comparisons: these leave the level of values open, for all designs alike."""
        differences = self.process.observations.differences
        return differences is not None and bool(differences.compared.any())

    def column_weights(self) -> Floats:
        return self.process.column_weights()

    @property
    def noise(self) -> float:
        """Standard deviation of a score around its value, in points."""
        return self.person.noise

    @property
    def blunders(self) -> float:
        """Probability of a random score."""
        return self.person.blunders

    @property
    def num_labels(self) -> int:
        """Number of labels that cells were fitted to."""
        return len(self.partition.cells.scores)

    @property
    def person(self) -> Person:
        """The person for the values of the process: each part is overconfident where it does not fit.

        Cells call noise what they do not divide, and a process explains noise by its function, which then appears in
        the errors on held-out scores. While cells divide nothing, these errors also contain the preference itself.
        """
        process_noise = float(np.sqrt(self.process.noise_variance))
        understated = _MAX_NOISE_FACTOR if self.partition.trees[0].split is not None else 1.0
        noise = min(self.partition.noise, max(_MAX_NOISE_FACTOR * process_noise, understated * self.held_out_error))
        return Person(max(noise, NOISES[0]), self.partition.blunders if noise > NOISES[0] else 0.0)

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        total = np.zeros(len(group_names))
        # By number: two groups may have the same name.
        numbers = [str(number) for number in range(len(group_names))]
        # What is unexplained depends on no group.
        for share, preference in zip(self._shares(self.share), (self.process, self.partition, self.line), strict=False):
            for entry in preference.explain(numbers) if preference is not None and share > 0.0 else ():
                total[int(entry.name)] += share * entry.share
        shares = zip(group_names, total.tolist(), strict=True)
        entries = [Relevance(name, share, level_of(share)) for name, share in shares]
        return sorted(entries, key=lambda relevance: -relevance.share)

    def for_density(self, rows: Rows, weights: Floats) -> BlendedPreference:
        """The preference for a density over designs: its parts are mixed as densities, each with its share of them.

        A mixture of values would be something else: if cells like one design in 10,000, a hundredth of a process that
        is not quite 0 for all others would hide it. The process counts less if it likes more of the designs than cells.

        Args:
            rows: [m, F] designs.
            weights: [m] >= 0, their density; not all 0.
        """
        table, masses = rows_to_predict(rows, self.num_columns), weights / weights.sum()
        mixed = replace(self, partition=self.partition.for_density(table, weights), density=None)
        parts = mixed._parts(table)
        level = tuple(float(masses @ np.clip(part.mean, 0.0, MAX_SCORE)) for part in parts)
        levels = _Levels(level, self._damped(level[0], level[1], mixed.partition))
        highest = float(mixed._density(parts, levels).max())
        return replace(
            mixed,
            density=levels._replace(scale=min(float(mixed._mixed(parts).mean.max()), MAX_SCORE) / highest),
            sketches=tuple(part.for_density(table, weights) for part in self.sketches),
        )

    def _damped(self, by_process: float, by_cells: float, cells: PartitionPreference) -> float:
        """Share of the process in a density, by what both like of the designs; a part that likes nothing has none.

        What the process has from cells that are not believed does not depend on what these like.
        """
        if min(by_process, by_cells) <= 0.0:
            return float(by_process > 0.0)
        if self._is_compared:
            # Designs are liked relative to the labelled ones.
            labelled = self.process.observations.all_rows
            by_cells *= float(np.maximum(self.predict_values(labelled).mean, 0.0).mean())
            by_process *= float(np.maximum(cells.predict(labelled).mean, 0.0).mean())
        ratio = min(1.0, by_cells / by_process) if by_process > 0.0 else 1.0
        own = (self.share - self.handed) * ratio**_RATIO_POWER
        return (own + self.handed) / (own + self.handed + 1.0 - self.share) if self.share < 1.0 else 1.0

    def _shares(self, share: float) -> tuple[float, float, float, float]:
        """Shares of the process, of cells, of lines, and of what is unexplained; the sum is 1.

        Args:
            share: share of the process beside cells.
        """
        explained = 1.0 - self.unexplained
        others = explained * (1.0 - self.line_share)
        return others * share, others * (1.0 - share), explained * self.line_share, self.unexplained

    def _parts(self, table: Floats) -> tuple[Prediction, ...]:
        """Predictions of the process, of cells, of lines, and of nothing explained."""
        same = np.ones(len(table))
        flat = Prediction(self.flat.level * same, self.flat.sd * same)
        by_line = flat if self.line is None else self.line.predict(table)
        return self.predict_values(table), self.partition.predict(table), by_line, flat

    def _mixed(self, parts: Sequence[Prediction]) -> Prediction:
        """The mixture of the parts as scores."""
        mean, square = np.zeros(1), np.zeros(1)
        for share, part in zip(self._shares(self.share), parts, strict=True):
            mean, square = mean + share * part.mean, square + share * (part.std**2 + part.mean**2)
        return Prediction(mean, np.sqrt(np.maximum(square - mean**2, 0.0)))

    def _density(self, parts: Sequence[Prediction], density: _Levels) -> Floats:
        """[m] the mixture of the parts as densities; one that likes nothing leaves the density of the designs."""
        total = np.zeros(len(parts[0].mean))
        for share, part, level in zip(self._shares(density.share), parts, density.levels, strict=True):
            total += share * (np.clip(part.mean, 0.0, MAX_SCORE) / level if level > 0.0 else 1.0)
        return density.scale * total


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
    """Both kinds of preference, the share of each by held-out scores, and how far they are believed.

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
    starts = FEW if len(values) > MANY_LABELS else None
    process = grouped.fit(table, values, groups=numbers, continuous=drawn, seed=seed, starts=starts)
    chosen, likely = selected(values), np.ones(len(numbers)) if priors is None else np.asarray(priors, np.float64)
    # Cells are fitted to the same labels.
    flat = unexplained(values[chosen], folds_of(table[chosen], seed), cells.cells.grid)
    line = line_preference.fit(table[chosen], values[chosen], numbers, likely)
    nothing = log_evidence_of_nothing(values[chosen], flat.log_evidence)
    cells_gain, line_gain = cells.log_evidence - nothing, line.log_evidence - flat.log_evidence
    of_trees, process_belief = cells_gain, 1.0
    # A line without columns explains nothing.
    line_belief = belief(line_gain, len(values)) if line.columns else 0.0
    if belief(of_trees, len(values)) < SURE:
        by_judge = cells.judged(table[chosen], values[chosen], drawn) - nothing
        # The priors of trees of both kinds have even odds.
        of_trees = float(np.logaddexp(cells_gain, by_judge) - np.log(2.0))
        if belief(of_trees, len(values)) < SURE:
            cells = replace(cells, unlike=float(expit(by_judge - cells_gain)))
    cells_belief = belief(of_trees, len(values))
    # A process is not fitted again and again only to be believed as well.
    if cells_belief < SURE:
        gain = process_gain(table, values, groups=numbers, continuous=drawn, seed=seed)
        process_belief = belief(gain, len(values))
    if len(values) < MIN_LABELS:
        share, rest, handed = believed(1.0, process_belief, cells_belief)
        return BlendedPreference(
            process=process, partition=cells, share=share, flat=flat, handed=handed, unexplained=rest
        )
    parts = Fitted(process, cells, line)
    judged = held_out(table, values, drawn, seed, parts, line.log_evidence - cells.log_evidence)
    share, rest, handed = believed(judged.share, process_belief, cells_belief)
    line_share, rest, _ = believed(judged.line_share, line_belief, 1.0 - rest)

    def blend(parts: Fitted) -> BlendedPreference:
        return BlendedPreference(
            process=parts.process,
            partition=parts.cells,
            share=share,
            flat=flat,
            handed=handed,
            line=parts.line,
            line_share=line_share,
            unexplained=rest,
        )

    return replace(
        blend(parts),
        # Half of all normal errors are smaller than the upper quartile.
        held_out_error=float(np.median(np.abs(judged.errors)) / ndtri(0.75)),
        explained_variance=judged.explained_variance if len(np.unique(table, axis=0)) >= MIN_LABELS else None,
        sketches=tuple(blend(parts) for parts in judged.sketches),
    )
