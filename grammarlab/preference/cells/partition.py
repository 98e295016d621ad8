"""A preference that divides designs into cells of one value: an average over trees, in proportion to their posterior.

A person who likes some combinations of parts and dislikes all others has few values and many designs of each. Labels
of one cell then measure one number, so that noise averages out and a single inconsistent score is a blunder. The error
of the person is found by evidence, from several starts: trees found under much noise stay small, trees found under
little noise explain the noise.

Cells of value 0 are predicted as 0, which matters most to a density: Gaussian processes predict a small mean for
clipped scores.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.errors import UsageError
from grammarlab.preference.base import AbstractPreference, Floats, Ints, Prediction, Relevance, Rows, rows_to_predict
from grammarlab.preference.cells.cells import ScoreCells, grid_of, levels_of
from grammarlab.preference.cells.densities import values_for_density
from grammarlab.preference.cells.growing import Growth, Tree, grow, loosened, regrown, replanted
from grammarlab.preference.cells.ranking import MANY
from grammarlab.preference.cells.splits import Above, Flags, Splits
from grammarlab.preference.explain import level_of
from grammarlab.preference.likelihood import Intervals
from grammarlab.preference.observations import checked_groups, checked_kinds, checked_labels

NOISES = (0.5, 1.5, 3.0, 5.0, 7.5, 10.0, 13.0, 17.0, 22.0, 28.0)
"""Candidate standard deviations of the noise."""
BLUNDERS = (0.002, 0.03, 0.06, 0.1, 0.15, 0.25)
"""Candidate probabilities of blunders."""
PRICE_OF_BLUNDERS = 40.0
"""Log-prior of a probability pi of blunders: minus this times pi."""
MAX_ROWS_TO_FIT = 512
"""Largest number of labels that trees are grown from; of more, an even selection by score is used."""
NUM_TREES = 12
NUM_AROUND = 6
"""Number of further trees, found by changing the most likely one."""
NUM_DOUBTFUL = 10
"""Number of alternative trees, used only to choose questions."""
DOUBT = 4.0
"""Approximate loss in nats of these trees."""
_BEGINNINGS = (15.0, 5.0, 0.5)
_NOISY = 7.5
"""Noise of many labels in points, found from other beginnings, from which the smallest beginning is left out: its
trees explain all noise, are large, and are then unlikely. With few labels, only it finds some tastes, such as parity.
"""
_ROUNDS = 3
_NUM_SKETCHES = 4
_GUIDE = (15.0, 0.05)
"""Noise and blunders of the first guide."""
_COOL, _WARM = 0.5, 1.0
"""Temperatures of the draws of splits."""
_TEMPERATURE = 3.0
"""Shares of trees are their posteriors to the power of one over this, since the found trees are only some of all."""
_LEAST_SHARE = 1e-3
_LIKELY_NOISE = 0.25
"""Least probability of a noise that values are averaged over, relative to the most likely one: an unlikely small one
would make every disliked cell a little liked, and most designs are disliked."""


class Designs(NamedTuple):
    """Designs with a density."""

    rows: Floats
    """[m, F + shares of sums] their rows."""
    masses: Floats
    """[m] >= 0, their density; the sum is 1."""


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
    doubtful: tuple[Tree, ...]
    """Alternative trees."""
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

    @cached_property
    def shares(self) -> Floats:
        """[trees] the weight of each tree; all sum to 1."""
        return _shares(self.trees)

    def predict(self, rows: Rows) -> Prediction:
        table = widened(rows_to_predict(rows, self.num_columns), self.shares_of)
        value, mean, square = np.zeros((3, len(table)))
        for (share, tree), known in zip(self._counting(), self._known, strict=True):
            number, cells = tree.cell_of(table)
            means, variances = self._values(cells)
            mean += share * means[number]
            square += share * (variances + means**2)[number]
            told = [known.get(cell.tobytes(), own) for cell, own in zip(cells, means.tolist(), strict=True)]
            value += share * np.array(told)[number]
        variance = np.maximum(square - mean**2, 0.0) + self.noise**2
        # A blunder is any score from 0 to 100.
        chance = self.blunders
        variance = (1.0 - chance) * variance + chance * (100.0**2 / 12.0 + (1.0 - chance) * (mean - 50.0) ** 2)
        return Prediction(value, np.sqrt(variance))

    def for_density(self, rows: Floats, weights: Floats) -> PartitionPreference:
        """The preference whose predictions are a density: cells have their expected shares, see `values_for_density`.

        Args:
            rows: [m, F] designs.
            weights: [m] >= 0, their density; not all 0.
        """
        return replace(self, designs=Designs(widened(rows, self.shares_of), weights / weights.sum()))

    @cached_property
    def _known(self) -> tuple[dict[bytes, float], ...]:
        """For each tree that counts, values for the density, by the labels of the cells with designs."""
        known = list[dict[bytes, float]]()
        for _, tree in self._counting():
            values = dict[bytes, float]()
            if self.designs is not None:
                number, cells = tree.cell_of(self.designs.rows)
                masses = np.bincount(number, self.designs.masses, minlength=len(cells)).astype(np.float64)
                found = values_for_density(self._posteriors(cells), self.cells.grid, masses)
                values = dict(zip((cell.tobytes() for cell in cells), found.tolist(), strict=True))
            known.append(values)
        return tuple(known)

    def values(self, rows: Rows) -> Floats:
        """[m, G] probability of each value of the grid."""
        table = widened(rows_to_predict(rows, self.num_columns), self.shares_of)
        found = np.zeros((len(table), len(self.cells.grid)))
        for share, tree in self._counting():
            number, cells = tree.cell_of(table)
            found += share * self._posteriors(cells)[number]
        return found

    @cached_property
    def noises(self) -> Floats:
        """[N] probability of each of `NOISES`, by the evidence of the cells of the most likely tree."""
        parts, every = list(self.trees[0].cells()), np.arange(len(self.cells.scores))
        inside = np.array([np.isin(every, part) for part in parts], dtype=np.float32)
        found = np.array([replace(self.cells, noise=n).log_evidence(inside, every).sum() for n in NOISES])
        odds = np.exp(found - found.max())
        return odds / odds.sum()

    def divisions(self, rows: Floats, num: int, randomness: np.random.Generator) -> Iterator[tuple[Ints, Floats]]:
        """Trees drawn by their shares: numbers [m] of the cells of rows, and [k, G] probabilities of their values."""
        table, counting = widened(rows, self.shares_of), list(self._counting())
        times = randomness.multinomial(num, np.array([share for share, _ in counting]))
        for (_, tree), number in zip(counting, times.tolist(), strict=True):
            cell, cells = tree.cell_of(table)
            yield from [(cell, self._posteriors(cells))] * number

    def without(
        self, rows: Floats, scores: Floats, continuous: Flags, said: Intervals | None = None
    ) -> PartitionPreference:
        """Preference from some of the labels, with the known error model: a fast approximation.

        Args:
            rows: [n, F] of these labels.
            scores: [n]
            continuous: [F] whether columns are continuous instead of counts.
            said: [n] intervals of these labels, if they are not scores.
        """
        randomness, every = np.random.default_rng(0), np.arange(len(scores))
        splits = splits_of(rows, self.groups, continuous, self.shares_of)
        cells = ScoreCells(
            splits=splits, scores=scores, grid=self.cells.grid, noise=self.noise, blunders=self.blunders, said=said
        )
        guides = guides_of(cells)
        growths = [Growth(1e-2)] + [Growth(_COOL, 0.0, guides)] * (_NUM_SKETCHES - 1)
        sketches = [grow(cells, every, growth, randomness) for growth in growths]
        found = [(share, tuple(tree.cells())) for share, tree in zip(_shares(sketches).tolist(), sketches, strict=True)]
        finer = splits_of(rows, self.groups, continuous, self.shares_of, _bounds(sketches))
        cells = replace(cells, levels=levels_of(cells, found), splits=finer)
        growths = [replace(growth, guides=_with(growth.guides, finer)) for growth in growths]
        trees = [grow(cells, every, growth, randomness) for growth in growths]
        if self.noise > NOISES[0]:
            # The tree of all labels is a candidate, pruned by these labels only.
            table = widened(rows, self.shares_of)
            trees += [replanted(cells, tree, table, every) for tree in self.trees[:_NUM_SKETCHES]]
        else:
            # Exact held-out scores have influenced the splits of all labels, which would be a leak.
            best = max(trees, key=lambda tree: tree.log_posterior)
            trees += [regrown(cells, best, growth, randomness) for growth in growths[1:]]
        # A copy without the cached ranks.
        return replace(self, cells=replace(cells), trees=tuple(trees), doubtful=(), designs=None)

    def joint(self, rows: Floats) -> tuple[Floats, Floats]:
        """Mean [m] and covariance [m, m] of the values of rows [m, F], with doubtful trees weighted like the others."""
        table = widened(rows, self.shares_of)
        trees = [(share / 2.0, tree) for share, tree in self._counting()]
        trees += [(0.5 / len(self.doubtful), tree) for tree in self.doubtful]
        means, covariance = np.zeros((len(trees), len(rows))), np.zeros((len(rows), len(rows)))
        shares = np.array([share for share, _ in trees])
        shares /= shares.sum()
        for place, (_, tree) in enumerate(trees):
            number, cells = tree.cell_of(table)
            values, variances = self._values(cells)
            means[place] = values[number]
            covariance += shares[place] * (number[:, None] == number) * variances[number]
        mean = shares @ means
        away = np.sqrt(shares)[:, None] * (means - mean)
        return mean, covariance + away.T @ away

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        """Share of the variance of the labels' values that splits by each group explain."""
        if len(self.groups) and len(group_names) <= self.groups.max():
            raise UsageError(f"group_names: expected {self.groups.max() + 1} names, found {len(group_names)}.")
        found = np.zeros(len(group_names))
        for share, tree in self._counting():
            found += share * self._explained(tree, len(group_names))
        entries = [
            Relevance(name, value, level_of(value)) for name, value in zip(group_names, found.tolist(), strict=True)
        ]
        return sorted(entries, key=lambda relevance: -relevance.share)

    def _explained(self, tree: Tree, num_groups: int) -> Floats:
        """[groups] share of the variance that the splits of a tree explain."""
        found, owners = np.zeros(num_groups), np.concatenate([self.groups, *(self.groups[s] for s in self.shares_of)])
        for node in tree.nodes():
            if node.split is not None:
                parts = [part.labels for _, part in node.parts]
                means, sizes = self._values(parts)[0], np.array([len(part) for part in parts])
                between = float(sizes @ (means - sizes @ means / sizes.sum()) ** 2)
                groups = np.unique(owners[list(node.split.columns)])
                found[groups] += between / len(groups)
        return found / max(float(found.sum()), 1e-12) if found.any() else found

    def _counting(self) -> Iterator[tuple[float, Tree]]:
        counting = self.shares >= _LEAST_SHARE
        total = self.shares[counting].sum()
        for place in np.flatnonzero(counting).tolist():
            yield float(self.shares[place] / total), self.trees[place]

    def _posteriors(self, cells: Sequence[Ints]) -> Floats:
        """[k, G] probability of each value of cells, an average over the noises that the labels allow.

        Much noise and a value of 0, or less noise and a small value, can explain a disliked cell equally well.
        """
        found = np.zeros((len(cells), len(self.cells.grid)))
        for share, told in self._allowed:
            found += share * np.array([told.posterior(cell) for cell in cells]).reshape(found.shape)
        return found

    @cached_property
    def _allowed(self) -> tuple[tuple[float, ScoreCells], ...]:
        """The labels with each likely noise, and its share; all shares sum to 1."""
        likely = self.noises >= _LIKELY_NOISE * self.noises.max()
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
    seed: int = 0,
    warm: AbstractPreference | None = None,
    said: Intervals | None = None,
) -> PartitionPreference:
    """A preference that divides designs into cells.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100; equal rows may have different ones.
        groups: [F] group numbers; by default every column is its own group.
        continuous: [F] whether columns are continuous instead of counts; by default none is.
        seed: seed of the draws of splits, and of the selection of labels if there are more than `MAX_ROWS_TO_FIT`.
        warm: not used.
        said: [n] intervals of the labels, if they are not scores; the scores are then approximate values.

    Raises:
        UsageError: If labels or groups are out of range.
    """
    table, values = checked_labels(rows, scores)
    numbers = checked_groups(groups, table.shape[1])
    drawn = checked_kinds(continuous, len(numbers))
    randomness = np.random.default_rng(seed)
    if len(values) > MAX_ROWS_TO_FIT:
        by_score = np.argsort(values + 1e-6 * randomness.random(len(values)), kind="stable")
        some = np.sort(by_score[np.arange(MAX_ROWS_TO_FIT) * len(values) // MAX_ROWS_TO_FIT])
        table, values = table[some], values[some]
        said = None if said is None else said.take(some)
    shares_of = sums_of(table, numbers, drawn)
    splits = splits_of(table, numbers, drawn, shares_of)
    every = np.arange(len(values))
    num_trees, num_around, num_doubtful = (_enough(num, values) for num in (NUM_TREES, NUM_AROUND, NUM_DOUBTFUL))
    with threadpool_limits(1, "blas"):
        cells, guides, found = _erring(splits, values, said, randomness)
        finer = splits_of(table, numbers, drawn, shares_of, _bounds([found]))
        cells, guides = replace(cells, splits=finer), _with(guides, finer)
        found = replanted(cells, found, widened(table, shares_of), every)
        growths = [Growth(1e-2)] + [Growth(_COOL if n % 2 else _WARM, 0.0, guides) for n in range(num_trees - 1)]
        trees = [found] + [grow(cells, every, growth, randomness) for growth in growths]
        trees += _around(
            cells, max(trees, key=lambda tree: tree.log_posterior), Growth(_WARM, 0.0, guides), num_around, randomness
        )
        doubtful = [grow(cells, every, Growth(_WARM, DOUBT, guides), randomness) for _ in range(num_doubtful)]
        doubtful = [loosened(tree, widened(table, shares_of), randomness) for tree in doubtful]
    trees.sort(key=lambda tree: -tree.log_posterior)
    return PartitionPreference(
        num_columns=table.shape[1],
        groups=numbers,
        shares_of=shares_of,
        cells=cells,
        trees=tuple(trees),
        doubtful=tuple(doubtful),
    )


def splits_of(
    rows: Floats, groups: Ints, continuous: Flags, shares_of: tuple[Ints, ...], near: Collection[Above] = ()
) -> Splits:
    """Splits of rows, including splits by shares; columns of many values at every bound near given ones."""
    owners = np.concatenate([groups, *(groups[columns] for columns in shares_of)])
    added = np.ones(sum(len(columns) for columns in shares_of), dtype=bool)
    return Splits.of(widened(rows, shares_of), owners, np.concatenate([continuous, added]), near)


def widened(rows: Floats, shares_of: tuple[Ints, ...]) -> Floats:
    """Rows with the share of each column of some sets in their sum; -1/2 if the sum is 0."""
    if not shares_of:
        return rows
    parts = []
    for columns in shares_of:
        total = rows[:, columns].sum(axis=1, keepdims=True)
        parts.append(np.where(total > 0.0, rows[:, columns] / np.where(total > 0.0, total, 1.0), -0.5))
    return np.concatenate([rows, *parts], axis=1)


def sums_of(rows: Floats, groups: Ints, continuous: Flags) -> tuple[Ints, ...]:
    """Groups whose counts have different sums: the share of a column may be relevant."""
    found = []
    for group in np.unique(groups[~continuous]).tolist():
        columns = np.flatnonzero((groups == group) & ~continuous)
        total = rows[:, columns].sum(axis=1)
        if len(columns) > 1 and np.ptp(total) > 0.0 and total.max() > 1.0:
            found.append(columns)
    return tuple(found)


def guides_of(cells: ScoreCells) -> tuple[ScoreCells, ...]:
    """The same labels with more noise, which prefers parts that differ in their mean.

    With the spread of the scores as noise, all parts are worth dividing that are not yet of one value: the first of
    several splits, after which liked and disliked designs are still mixed, has little evidence with less noise.
    """
    spread = float(cells.scores.std())
    noises = (_GUIDE[0], spread) if spread > _GUIDE[0] else _GUIDE[:1]
    return tuple(replace(cells, noise=noise, blunders=_GUIDE[1]) for noise in noises)


def _with(guides: Sequence[ScoreCells], splits: Splits) -> tuple[ScoreCells, ...]:
    """Guides with other splits."""
    return tuple(replace(guide, splits=splits) for guide in guides)


def _bounds(trees: Sequence[Tree]) -> set[Above]:
    """The bounds of trees."""
    return {node.split for tree in trees for node in tree.nodes() if isinstance(node.split, Above)}


def _enough(num: int, scores: Floats) -> int:
    """Number of trees or rounds for a number of scores."""
    return num if len(scores) <= MANY else num - num // 3


def _around(cells: ScoreCells, tree: Tree, growth: Growth, num: int, randomness: np.random.Generator) -> Iterator[Tree]:
    """Trees drawn from each other, beginning with the most likely one, that explain the labels about equally well."""
    for _ in range(num):
        tree = regrown(cells, tree, growth, randomness, temperature=1.0)
        yield tree


def _erring(
    splits: Splits, scores: Floats, said: Intervals | None, randomness: np.random.Generator
) -> tuple[ScoreCells, tuple[ScoreCells, ...], Tree]:
    """Error model, guide and tree: the best of several starts."""
    grid, every = grid_of(scores), np.arange(len(scores))
    first = ScoreCells(splits=splits, scores=scores, grid=grid, noise=_BEGINNINGS[0], blunders=BLUNDERS[1], said=said)
    guides = guides_of(first)
    best, highest, most_likely = guides[0], -np.inf, Tree(every, -np.inf)
    seen, many = set[tuple[float, float]](), len(scores) > MANY
    for noise in _BEGINNINGS:
        if many and noise == _BEGINNINGS[-1] and best.noise >= _NOISY:
            break
        cells, seen = replace(first, noise=noise), seen if many else set[tuple[float, float]]()
        for _ in range(_enough(_ROUNDS, scores)):
            growths = [Growth(1e-2)] + [Growth(_COOL, 0.0, guides)] * (_NUM_SKETCHES - 1)
            trees = [grow(cells, every, growth, randomness) for growth in growths]
            tree = max(trees, key=lambda tree: tree.log_posterior)
            posterior = tree.log_posterior - PRICE_OF_BLUNDERS * cells.blunders
            if posterior > highest:
                best, highest, most_likely = cells, posterior, tree
            found = [(float(share), tuple(tree.cells())) for share, tree in zip(_shares(trees), trees, strict=True)]
            erring = _most_likely(cells, found)
            if erring in seen:
                break
            seen.add(erring)
            cells = replace(cells, noise=erring[0], blunders=erring[1], levels=levels_of(cells, found))
    return best, guides, most_likely


def _most_likely(cells: ScoreCells, found: Sequence[tuple[float, Sequence[Ints]]]) -> tuple[float, float]:
    """Noise and blunders with the highest posterior for the two most likely divisions."""
    top = sorted(found, key=lambda item: -item[0])[:2]
    every = np.arange(len(cells.scores))
    members = []
    for share, parts in top:
        inside = np.zeros((len(parts), len(every)), dtype=np.float32)
        for place, cell in enumerate(parts):
            inside[place, cell] = 1.0
        members.append((share, inside))

    def posterior(erring: tuple[float, float]) -> float:
        other = replace(cells, noise=erring[0], blunders=erring[1])
        evidence = sum(share * float(other.log_evidence(inside, every).sum()) for share, inside in members)
        return evidence / sum(share for share, _ in members) - PRICE_OF_BLUNDERS * erring[1]

    return max(((noise, blunders) for noise in NOISES for blunders in BLUNDERS), key=posterior)


def _shares(trees: Sequence[Tree]) -> Floats:
    posterior = np.array([tree.log_posterior for tree in trees])
    shares = np.exp((posterior - posterior.max()) / _TEMPERATURE)
    return shares / shares.sum()
