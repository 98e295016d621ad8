"""A preference that divides designs into cells of one value: an average over trees, in proportion to their posterior.

A person who likes some combinations of parts and dislikes all others has few values and many designs of each. Labels
of one cell then measure one number, so that noise averages out and a single inconsistent score is a blunder. The error
of the person is found by evidence (`grammarlab.preference.growth.person_search`).

Where no label lies between two bounds, the alternative trees that choose questions have any bound in between.

Cells of value 0 are predicted as 0, which matters most to a density: Gaussian processes predict a small mean for
clipped scores.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import expit
from threadpoolctl import threadpool_limits

from grammarlab.arrays import FEW, Flags, Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.preference.base import (
    MAX_SCORE,
    MIN_SHARE,
    AbstractPreference,
    Prediction,
    Relevance,
    Rows,
    rows_to_predict,
)
from grammarlab.preference.cells.box_search import NUM_CHAINS, find_boxes
from grammarlab.preference.cells.cells import ScoreCells, grid_of
from grammarlab.preference.cells.density_values import values_for_density
from grammarlab.preference.cells.sum_shares import split_columns, sums_of, widened
from grammarlab.preference.factors import level_of
from grammarlab.preference.growth.person_search import search
from grammarlab.preference.growth.tree_growth import Others, Tree, TreeGrowth, loosened, posterior_shares
from grammarlab.preference.judge.evidence_of_trees import log_evidence
from grammarlab.preference.judge.labelled_columns import selected
from grammarlab.preference.judge.unexplained_scores import UnexplainedScores
from grammarlab.preference.observations import checked_groups, checked_kinds, checked_labels
from grammarlab.preference.person import NOISES, START_PERSONS, Intervals, Person, value_of

_NUM_DOUBTFUL = 10
"""Number of alternative trees, used only to choose questions."""
_DOUBT_TEMPERATURE = 4.0
"""Approximate loss in nats of the alternative trees."""


class Designs(NamedTuple):
    """Designs with a density."""

    rows: Floats
    """[m, F + shares of sums] rows of the designs."""
    masses: Floats
    """[m] >= 0, density of the designs; the sum is 1."""


@dataclass(frozen=True, eq=False)
class PartitionPreference(AbstractPreference):
    """Result of `fit` with `method="partition"`."""

    num_columns: int
    groups: Ints
    """[F] group number of each column."""
    shares_of: tuple[Ints, ...]
    """Sets of columns whose shares of their sum are further columns."""
    cells: ScoreCells
    """The labels and the error model."""
    trees: tuple[Tree, ...]
    """Trees, most likely first."""
    log_evidence: float
    """Log of the evidence of the most likely tree and of other divisions of its nodes, with the prices of splits and of
    blunders, in nats."""
    doubtful: tuple[Tree, ...]
    """Alternative trees, used only to choose questions."""
    priors: Floats | None = None
    """[F] how likely columns are to matter, relative to each other; None if all are equally likely."""
    boxes: tuple[Tree, ...] = ()
    """Trees of boxes that explain the scores (`grammarlab.preference.cells.box_search`), with all their bounds, whether
    these are worth their price or not; used only to choose questions."""
    unlike: float = 0.0
    """Probability that the designs of a cell may have different values, 0 to 1: if the scores do not show that all
    have one, see `judged`."""
    designs: Designs | None = None
    """The designs over which predictions are a density; None for predictions of scores only."""

    @property
    def noise(self) -> float:
        """Standard deviation of a score around its value, in points."""
        return self.cells.noise

    @property
    def blunders(self) -> float:
        """Probability of a blunder."""
        return self.cells.blunders

    @property
    def person(self) -> Person:
        """Both."""
        return Person(self.noise, self.blunders)

    @cached_property
    def shares(self) -> Floats:
        """[trees] the weight of each tree; all sum to 1."""
        return posterior_shares(self.trees)

    def predict(self, rows: Rows) -> Prediction:
        table = widened(rows_to_predict(rows, self.num_columns), self.shares_of)
        value, mean, square = np.zeros((3, len(table)))
        for (share, tree), cache in zip(self._counting(), self._density_values, strict=True):
            number, cells = tree.cell_of(table)
            means, variances = self._values(cells)
            mean += share * means[number]
            square += share * (variances + means**2)[number]
            cell_values = [
                cache.get(cell.tobytes(), expected) for cell, expected in zip(cells, means.tolist(), strict=True)
            ]
            value += share * np.array(cell_values)[number]
        variance = np.maximum(square - mean**2, 0.0) + self.noise**2
        # A blunder is any score from 0 to 100.
        chance, away = self.blunders, mean - MAX_SCORE / 2.0
        variance = (1.0 - chance) * variance + chance * (MAX_SCORE**2 / 12.0 + (1.0 - chance) * away**2)
        return Prediction(value, np.sqrt(variance))

    def for_density(self, rows: Floats, weights: Floats) -> PartitionPreference:
        """The preference whose predictions are a density: cells have their expected shares, see `values_for_density`.

        Args:
            rows: [m, F] designs.
            weights: [m] >= 0, their density; not all 0.
        """
        return replace(self, designs=Designs(widened(rows, self.shares_of), weights / weights.sum()))

    @cached_property
    def _density_values(self) -> tuple[dict[bytes, float], ...]:
        """For each tree that counts, values for the density, by the labels of the cells with designs."""
        caches = list[dict[bytes, float]]()
        for _, tree in self._counting():
            values = dict[bytes, float]()
            if self.designs is not None:
                number, cells = tree.cell_of(self.designs.rows)
                masses = np.bincount(number, self.designs.masses, minlength=len(cells)).astype(np.float64)
                adjusted = values_for_density(self._posteriors(cells), self.cells.grid, masses)
                values = dict(zip((cell.tobytes() for cell in cells), adjusted.tolist(), strict=True))
            caches.append(values)
        return tuple(caches)

    def values(self, rows: Rows) -> Floats:
        """[m, G] probability of each value of the grid."""
        table = widened(rows_to_predict(rows, self.num_columns), self.shares_of)
        probabilities = np.zeros((len(table), len(self.cells.grid)))
        for share, tree in self._counting():
            number, cells = tree.cell_of(table)
            probabilities += share * self._posteriors(cells)[number]
        return probabilities

    @cached_property
    def noises(self) -> Floats:
        """[N] probability of each of `NOISES`, by the evidence of the cells of the most likely tree."""
        parts, every = list(self.trees[0].cells()), np.arange(len(self.cells.scores))
        inside = np.array([np.isin(every, part) for part in parts], dtype=np.float32)
        log_evidence = np.array([replace(self.cells, noise=n).log_evidence(inside).sum() for n in NOISES])
        odds = np.exp(log_evidence - log_evidence.max())
        return odds / odds.sum()

    def divisions(self, rows: Floats, num: int, randomness: np.random.Generator) -> Iterator[tuple[Ints, Floats]]:
        """Trees drawn by their shares: numbers [m] of the cells of rows, and [k, G] probabilities of their values."""
        table, counting = widened(rows, self.shares_of), list(self._counting())
        times = randomness.multinomial(num, np.array([share for share, _ in counting]))
        for (_, tree), number in zip(counting, times.tolist(), strict=True):
            cell, cells = tree.cell_of(table)
            yield from [(cell, self._posteriors(cells))] * number

    def judged(self, rows: Floats, scores: Floats, continuous: Flags) -> float:
        """Evidence of the trees for some of the labels as the judge sees it, in nats (`judge.evidence_of_trees`).

        Args:
            rows: [n, F] rows of these labels.
            scores: [n] scores of these labels, 0-100.
            continuous: [F] whether columns are continuous instead of counts.
        """
        columns = split_columns(rows, self.groups, continuous, self.shares_of, scores, self.priors)
        return log_evidence(columns, Others(self.trees, widened(rows, self.shares_of)), scores, self.person)

    def without(
        self, rows: Floats, scores: Floats, continuous: Flags, intervals: Intervals | None = None
    ) -> PartitionPreference:
        """Preference from some of the labels, with the known error model: a fast approximation.

        Args:
            rows: [n, F] rows of these labels.
            scores: [n] scores of these labels, 0-100.
            continuous: [F] whether columns are continuous instead of counts.
            intervals: [n] intervals of these labels, if they are not scores.
        """
        columns = split_columns(rows, self.groups, continuous, self.shares_of, scores, self.priors)
        table, randomness = widened(rows, self.shares_of), np.random.default_rng(0)
        boxes = find_boxes(table, scores, continuous, randomness, intervals, FEW, self.priors)
        others = Others([box.tree(table) for box in boxes], table)
        growth = TreeGrowth(columns, ScoreCells(scores, self.cells.grid, *self.person, intervals=intervals))
        # Without errors, held-out scores have influenced the splits of all labels, which would be a leak. Boxes are so
        # hard to find again with fewer chains that it would be worse to do without.
        if self.person.errs or self.boxes:
            # The structure of all labels is kept, pruned by these labels only, as a process keeps its kernel.
            trees = growth.replanted(Others([*others.trees, *self.trees[:FEW]], table))
        else:
            trees = growth.trees(others)
        return replace(self, cells=growth.evidence, trees=tuple(trees), doubtful=(), boxes=(), designs=None)

    def joint(self, rows: Floats) -> tuple[Floats, Floats]:
        """Mean [m] and covariance [m, m] of the values of rows [m, F], with doubtful trees weighted like the others."""
        table = widened(rows, self.shares_of)
        trees = [(share / 2.0, tree) for share, tree in self._counting()]
        trees += [(0.5 / len(self.doubtful), tree) for tree in self.doubtful]
        means, covariance = np.zeros((len(trees), len(rows))), np.zeros((len(rows), len(rows)))
        shares = np.array([share for share, _ in trees])
        shares /= shares.sum()
        for index, (_, tree) in enumerate(trees):
            number, cells = tree.cell_of(table)
            values, variances = self._values(cells)
            means[index] = values[number]
            covariance += shares[index] * (number[:, None] == number) * variances[number]
        mean = shares @ means
        away = np.sqrt(shares)[:, None] * (means - mean)
        return mean, covariance + away.T @ away

    def opinions(self, rows: Floats) -> tuple[Floats, Floats]:
        """Shares [B] of the boxes, which are drawn in proportion to their posterior, and the value [B, m] of each row.

        Trees do not count: most of them are one or two of these boxes without the bounds that are not worth their
        price.
        """
        table = widened(rows, self.shares_of)
        values = np.zeros((len(self.boxes), len(rows)))
        for index, tree in enumerate(self.boxes):
            number, cells = tree.cell_of(table)
            values[index] = self._values(cells)[0][number]
        return np.full(len(self.boxes), 1.0 / len(self.boxes)), values

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        """Share of the variance of the labels' values that splits by each group explain."""
        if len(self.groups) and len(group_names) <= self.groups.max():
            raise UsageError(f"group_names: expected {self.groups.max() + 1} names, found {len(group_names)}.")
        totals = np.zeros(len(group_names))
        for share, tree in self._counting():
            totals += share * self._explained(tree, len(group_names))
        entries = [
            Relevance(name, value, level_of(value)) for name, value in zip(group_names, totals.tolist(), strict=True)
        ]
        return sorted(entries, key=lambda relevance: -relevance.share)

    def _explained(self, tree: Tree, num_groups: int) -> Floats:
        """[groups] share of the variance that the splits of a tree explain."""
        explained, owners = (
            np.zeros(num_groups),
            np.concatenate([self.groups, *(self.groups[s] for s in self.shares_of)]),
        )
        for node in tree.nodes():
            if node.split is not None:
                parts = [part.labels for _, part in node.parts]
                means, sizes = self._values(parts)[0], np.array([len(part) for part in parts])
                between = float(sizes @ (means - sizes @ means / sizes.sum()) ** 2)
                groups = np.unique(owners[list(node.split.columns)])
                explained[groups] += between / len(groups)
        return explained / explained.sum() if explained.any() else explained

    def _counting(self) -> Iterator[tuple[float, Tree]]:
        counting = self.shares >= MIN_SHARE
        total = self.shares[counting].sum()
        for index in np.flatnonzero(counting).tolist():
            yield float(self.shares[index] / total), self.trees[index]

    def _posteriors(self, cells: Sequence[Ints]) -> Floats:
        """[k, G] probability of each value of cells, an average over the noises that the labels allow.

        Much noise and a value of 0, or less noise and a small value, can explain a disliked cell equally well.
        """
        probabilities = np.zeros((len(cells), len(self.cells.grid)))
        for share, labelled in self._allowed:
            probabilities += share * np.array([labelled.posterior(cell) for cell in cells]).reshape(probabilities.shape)
        if self.unlike == 0.0:
            return probabilities
        unlike = self.unlike * self._are_unlike(cells)[:, None]
        return (1.0 - unlike) * probabilities + unlike * self._mean_values(cells)

    def _are_unlike(self, cells: Sequence[Ints]) -> Floats:
        """[k] probability that the designs of each cell have different values, with even odds before any score."""
        any_values = self._any_values
        counts = np.array([any_values.members[cell].sum(axis=0) for cell in cells]).reshape(
            len(cells), any_values.members.shape[1]
        )
        one_value = np.array([self.cells.of_labels(cell) for cell in cells])
        return expit(any_values.log_evidence(counts) - one_value)

    @cached_property
    def _any_values(self) -> UnexplainedScores:
        """The evidence of any distribution of scores."""
        return UnexplainedScores.of(self.cells.scores)

    def _mean_values(self, cells: Sequence[Ints]) -> Floats:
        """[k, G] the value with the mean score of each cell, as shares of the values of the grid beside it."""
        means = value_of(np.array([self.cells.scores[cell].mean() for cell in cells]), self.noise, 0.0)
        grid, every = self.cells.grid, np.arange(len(cells))
        above = np.clip(np.searchsorted(grid, means), 1, len(grid) - 1)
        share = (means - grid[above - 1]) / (grid[above] - grid[above - 1])
        probabilities = np.zeros((len(cells), len(grid)))
        probabilities[every, above - 1], probabilities[every, above] = 1.0 - share, share
        return probabilities

    @cached_property
    def _allowed(self) -> tuple[tuple[float, ScoreCells], ...]:
        """The labels with each likely noise, and its share; all shares sum to 1."""
        likely = self.noises >= MIN_SHARE
        shares = self.noises[likely] / self.noises[likely].sum()
        noises = np.array(NOISES)[likely]
        return tuple(
            (share, self.cells if noise == self.cells.noise else replace(self.cells, noise=noise))
            for share, noise in zip(shares.tolist(), noises.tolist(), strict=True)
        )

    def _values(self, cells: Sequence[Ints]) -> tuple[Floats, Floats]:
        """[k] means and variances of the values of cells."""
        posterior = self._posteriors(cells)
        means = posterior @ self.cells.grid
        return means, np.maximum(posterior @ self.cells.grid**2 - means**2, 0.0)


def fit(
    rows: Rows,
    scores: ArrayLike,
    *,
    groups: ArrayLike | None = None,
    continuous: ArrayLike | None = None,
    priors: ArrayLike | None = None,
    seed: int = 0,
    warm: AbstractPreference | None = None,
    intervals: Intervals | None = None,
) -> PartitionPreference:
    """A preference that divides designs into cells.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100; equal rows may have different ones.
        groups: [F] group numbers; by default every column is its own group.
        continuous: [F] whether columns are continuous instead of counts; by default none is.
        priors: [F] how likely columns are to matter, relative to each other; by default all are equally likely.
        seed: seed of the draws of splits.
        warm: not used.
        intervals: [n] intervals of the labels, if they are not scores; the scores are then approximate values.

    Raises:
        UsageError: If labels or groups are out of range.
    """
    table, values = checked_labels(rows, scores)
    numbers = checked_groups(groups, table.shape[1])
    drawn = checked_kinds(continuous, len(numbers))
    randomness = np.random.default_rng(seed)
    chosen = selected(values)
    table, values = table[chosen], values[chosen]
    intervals = None if intervals is None else intervals.take(chosen)
    sums = sums_of(table, numbers, drawn)
    wide = widened(table, sums)
    likely = None if priors is None else np.asarray(priors, dtype=np.float64)
    boxes = [box.tree(wide) for box in find_boxes(wide, values, drawn, randomness, intervals, priors=likely)]
    others = Others(boxes, wide)
    with threadpool_limits(1, "blas"):
        columns = split_columns(table, numbers, drawn, sums, values, likely)
        first = ScoreCells(values, grid_of(values), *START_PERSONS[0], intervals=intervals)
        found = search(columns, first, START_PERSONS, _one_of_each_chain(others))
        cells, growth = found.evidence, found.growth
        trees = growth.trees(others)
        drawn_trees = [growth.drawn(_DOUBT_TEMPERATURE, randomness) for _ in range(_NUM_DOUBTFUL)]
        doubtful = [loosened(tree, wide, randomness) for tree in drawn_trees]
    return PartitionPreference(
        num_columns=table.shape[1],
        groups=numbers,
        shares_of=sums,
        cells=cells,
        trees=tuple(trees),
        log_evidence=growth.with_others(trees[0]) - cells.person.price,
        doubtful=tuple(doubtful),
        priors=likely,
        boxes=tuple(boxes),
    )


def _one_of_each_chain(boxes: Others) -> Others:
    return boxes._replace(trees=boxes.trees[::NUM_CHAINS])
