"""Lines that explain scores: which columns have points, found by evidence.

A line names a set of k of C columns: its description is log 2 for each column and one more, and the prices of its
columns less log k!, since their order says nothing. Columns are added one by one, the one first that gains most by the
slopes of the likelihood; then each is exchanged for others as long as that gains. All lines that were tried are
hypotheses.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.special import gammaln

from grammarlab.arrays import FEW, Floats, Ints
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.lines.fitted_line import LEAST_SLOPE, POINTS, SOFTNESS, FittedLine, fitted, with_ones
from grammarlab.preference.lines.line_scores import LineScores
from grammarlab.preference.person import BLUNDERS, NOISES, START_PERSONS, Person


@dataclass(frozen=True, eq=False)
class LineSearch:
    """Columns and scores, and the lines that were tried."""

    table: Floats
    """[n, C] columns of mean 0 and variance 1, no two equal or opposite."""
    prices: Floats
    """[C] price of each column, in nats."""
    scores: Floats
    """[n] 0-100."""
    known: dict[Person, LineScores] = field(default_factory=dict)
    """Likelihoods by the errors of the person."""
    tried: dict[tuple[tuple[int, ...], Person], FittedLine] = field(default_factory=dict)
    """The best line of each set of columns and errors."""

    def total(self, line: FittedLine) -> float:
        """Evidence minus description length, in nats."""
        terms = list(line.terms)
        description = float(self.prices[terms].sum() - gammaln(len(terms) + 1)) + np.log(2.0) * (len(terms) + 1)
        return line.log_evidence - description - line.scores.person.price

    @property
    def best(self) -> FittedLine:
        """The best line so far."""
        return max(self.tried.values(), key=self.total)

    def run(self) -> None:
        """Try lines."""
        for person in START_PERSONS:
            self._grow(self._given(person))
        self._adapt()
        before = None
        while self.best is not before:
            before = self.best
            self._exchange(before)
        self._adapt()

    def _given(self, person: Person) -> LineScores:
        """The likelihood for errors of the person."""
        if person not in self.known:
            self.known[person] = LineScores(self.scores, person)
        return self.known[person]

    def _grow(self, scores: LineScores) -> None:
        middle = np.clip([self.scores.mean()], 1.0, MAX_SCORE - 1.0)
        line = self._try((), scores, middle, wide=True)
        highest, patience = self.total(line), FEW
        while patience and len(following := self._following(line, 1)):
            line = self._try((*line.terms, int(following[0])), scores, np.append(line.points, 0.0), wide=True)
            patience = FEW if self.total(line) > highest else patience - 1
            highest = max(highest, self.total(line))

    def _adapt(self) -> None:
        """Try other errors of the person for the best line."""
        best = self.best
        for noise in NOISES:
            self._try(best.terms, self._given(Person(noise, best.scores.person.blunders)), best.points)
        best = self.best
        for blunders in BLUNDERS:
            self._try(best.terms, self._given(Person(best.scores.person.noise, blunders)), best.points)

    def _exchange(self, line: FittedLine) -> None:
        """Try to add a column, and to leave out each one or to put another one in its place."""
        for place in (None, *range(len(line.terms))):
            fewer = line
            if place is not None:
                terms = tuple(term for index, term in enumerate(line.terms) if index != place)
                fewer = self._try(terms, line.scores, np.delete(line.points, place + 1))
            for column in self._following(fewer, FEW).tolist():
                if column not in line.terms:
                    self._try((*fewer.terms, column), line.scores, np.append(fewer.points, 0.0))

    def _try(self, terms: tuple[int, ...], scores: LineScores, start: Floats, *, wide: bool = False) -> FittedLine:
        key = tuple(sorted(terms)), scores.person
        line = fitted(self.table, terms, scores, start, wide=wide)
        if key not in self.tried or line.log_evidence > self.tried[key].log_evidence:
            self.tried[key] = line
        return line

    def _following(self, line: FittedLine, num: int) -> Ints:
        """The columns that gain most beside those of a line, by the slopes of its likelihood, best first."""
        design = with_ones(self.table[:, list(line.terms)])
        slopes = line.scores.slopes(design @ line.points, SOFTNESS, LEAST_SLOPE)
        across = (design.T * slopes.curvature) @ self.table
        # Beside columns that repeat it, a column still has the curvature of its prior.
        least = 1.0 / POINTS**2
        own = slopes.curvature @ self.table**2 + least
        own = np.maximum(own - np.einsum("kc,kc->c", across, np.linalg.solve(line.precision, across)), least)
        gains = (slopes.first @ self.table) ** 2 / (2.0 * own) - 0.5 * np.log(own * POINTS**2) - self.prices
        gains[list(line.terms)] = -np.inf
        order = np.argsort(-gains, kind="stable")[:num]
        return order[np.isfinite(gains[order])]
