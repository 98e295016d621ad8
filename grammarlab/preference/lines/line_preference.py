"""A preference that gives points for parts: they add up, and the sum is clipped to 0-100.

Trees need a cell for every combination of parts, and a kernel learns each of them from designs that have most parts in
common. Points of k parts are k numbers, so they are known after a few times k scores. Predictions are means over all
lines that may be true and over their points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import ROUNDING, Floats, Ints
from grammarlab.preference.base import (
    MAX_SCORE,
    MIN_SHARE,
    AbstractPreference,
    Prediction,
    Relevance,
    Rows,
    rows_to_predict,
)
from grammarlab.preference.factors import level_of
from grammarlab.preference.lines.distinct import Distinct
from grammarlab.preference.lines.fitted_line import SOFTNESS, FittedLine, fitted, with_ones
from grammarlab.preference.lines.line_scores import LineScores, clipped
from grammarlab.preference.lines.points_search import LineSearch
from grammarlab.preference.person import Person


@dataclass(frozen=True, eq=False)
class LinePreference(AbstractPreference):
    """Result of `fit`."""

    num_columns: int
    groups: Ints
    """[F] group number of each column."""
    distinct: Distinct
    """The columns that some line uses."""
    lines: tuple[FittedLine, ...]
    """Lines, the best one first."""
    totals: Floats
    """[L] evidence minus description length of each of them, in nats."""

    @property
    def log_evidence(self) -> float:
        """Evidence minus description length of the best line, in nats."""
        return float(self.totals[0])

    @property
    def noise(self) -> float:
        """Standard deviation of a score around its value by the best line, in points."""
        return self.lines[0].scores.person.noise

    @property
    def columns(self) -> tuple[int, ...]:
        """Columns of the best line."""
        return tuple(self.distinct.columns[list(self.lines[0].terms)].tolist())

    @cached_property
    def shares(self) -> Floats:
        """[L] probability of each line; the sum is 1."""
        odds = np.exp(self.totals - self.totals[0])
        return odds / odds.sum()

    def predict(self, rows: Rows) -> Prediction:
        table = self.distinct.table(rows_to_predict(rows, self.num_columns))
        mean, square = np.zeros((2, len(table)))
        for share, line in zip(self.shares.tolist(), self.lines, strict=True):
            sums, variances = line.sums(table)
            value, slope = clipped(sums, np.sqrt(variances + SOFTNESS**2))
            mean += share * value
            square += share * (value**2 + slope**2 * variances + line.scores.person.noise**2)
        return Prediction(mean, np.sqrt(np.maximum(square - mean**2, 0.0)))

    def draws(self, rows: Rows, num: int, randomness: np.random.Generator) -> Floats:
        """[num, m] values of designs by lines and points drawn by their probability."""
        table = self.distinct.table(rows_to_predict(rows, self.num_columns))
        values = np.zeros((num, len(table)))
        for index, number in enumerate(randomness.choice(len(self.lines), num, p=self.shares).tolist()):
            line = self.lines[number]
            away = np.linalg.solve(np.linalg.cholesky(line.precision).T, randomness.normal(size=len(line.points)))
            sums = with_ones(table[:, list(line.terms)]) @ (line.points + away)
            values[index] = np.clip(sums, 0.0, MAX_SCORE)
        return values

    def explain(self, group_names: Sequence[str]) -> list[Relevance]:
        shares = np.zeros(len(group_names))
        for share, line in zip(self.shares.tolist(), self.lines, strict=True):
            # Columns have variance 1.
            squares = line.points[1:] ** 2
            groups = self.groups[self.distinct.columns[list(line.terms)]]
            np.add.at(shares, groups, share * squares / max(float(squares.sum()), ROUNDING))
        entries = zip(group_names, shares.tolist(), strict=True)
        return sorted(
            (Relevance(name, share, level_of(share)) for name, share in entries), key=lambda entry: -entry.share
        )

    def without(self, rows: Floats, scores: Floats) -> LinePreference:
        """The same lines with the points that some of the labels give them.

        Args:
            rows: [n, F] rows of these labels.
            scores: [n] their scores, 0-100.
        """
        table = self.distinct.table(rows)
        refitted = [
            fitted(table, line.terms, LineScores(scores, line.scores.person), line.points) for line in self.lines
        ]
        return replace(self, lines=tuple(refitted))


class BestLine(NamedTuple):
    """The best line of some columns."""

    columns: tuple[int, ...]
    """Its columns."""
    total: float
    """Evidence minus description length, in nats."""
    person: Person
    """The most likely errors of the person."""


def best_line(rows: Floats, prices: Floats, scores: Floats) -> BestLine:
    """The line that explains scores best.

    Args:
        rows: [n, F] finite numbers.
        prices: [F] price of each column, in nats.
        scores: [n] 0-100.
    """
    distinct, search = _searched(rows, prices, scores)
    columns = distinct.columns[list(search.best.terms)]
    return BestLine(tuple(columns.tolist()), search.total(search.best), search.best.scores.person)


def fit(rows: Floats, scores: Floats, groups: Ints, priors: Floats | None = None) -> LinePreference:
    """The lines that explain scores.

    Args:
        rows: [n, F] finite numbers.
        scores: [n] 0-100.
        groups: [F] group numbers.
        priors: [F] how likely columns are to matter, relative to each other; None if all are equally likely.
    """
    likely = np.ones(rows.shape[1]) if priors is None else priors
    distinct, search = _searched(rows, np.log(groups.max(initial=0) + 1.0) - np.log(likely), scores)
    ranked = sorted(search.tried.values(), key=lambda line: -search.total(line))
    totals = np.array([search.total(line) for line in ranked])
    counting = ranked[: int(np.count_nonzero(totals > totals[0] + np.log(MIN_SHARE)))]
    used = np.unique(np.array([term for line in counting for term in line.terms], dtype=np.int64))
    number = {term: index for index, term in enumerate(used.tolist())}
    lines = tuple(replace(line, terms=tuple(number[term] for term in line.terms)) for line in counting)
    return LinePreference(rows.shape[1], groups, distinct.take(used), lines, totals[: len(lines)])


def _searched(rows: Floats, prices: Floats, scores: Floats) -> tuple[Distinct, LineSearch]:
    distinct = Distinct.of(rows)
    search = LineSearch(distinct.table(rows), prices[distinct.columns], scores)
    search.run()
    return distinct, search
