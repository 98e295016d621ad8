"""Score of a model, 0 to 100, as an exact function of its features."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.pattern import Feature

MAX_CASES = 100
"""Largest number of cases of one score."""


@dataclass(frozen=True, slots=True)
class ScoreCase:
    """One case of a preference: the score of a model if a condition holds."""

    value: float
    """0 to 100."""
    when: Expression
    means: str = ""
    """The condition in words, for captions."""


@dataclass(frozen=True, slots=True)
class Score:
    """A score for every model."""

    expression: Expression
    """The score before it is clipped to 0 to 100."""
    cases: tuple[ScoreCase, ...] = ()
    """Cases, if it was defined by cases; the first that holds counts, 0 if none holds."""

    @classmethod
    def of_cases(cls, cases: Sequence[ScoreCase]) -> Score:
        """Score with the value of the first case that holds, 0 if none holds.

        Raises:
            UsageError: If there are no cases, too many cases, or a value is not a score.
        """
        if not 1 <= len(cases) <= MAX_CASES:
            raise UsageError(f"expected 1 to {MAX_CASES} cases, found {len(cases)}")
        for case in cases:
            if not 0 <= case.value <= 100:
                raise UsageError(f"expected a score from 0 to 100, found {case.value:g}")
        names = {f"case_{i}": case.when for i, case in enumerate(cases)}
        lines = ", ".join(f"case_{i}, {case.value!r}" for i, case in enumerate(cases))
        return cls(Expression.parse(f"choose({lines}, 0)", names), tuple(cases))

    @classmethod
    def of_text(cls, text: str, definitions: Mapping[str, Expression] | None = None) -> Score:
        """Score with the value of an expression, clipped to 0 to 100.

        Raises:
            UsageError: If the text is not an expression.
        """
        return cls(Expression.parse(text, definitions))

    @classmethod
    def product(cls, scores: Sequence[Score]) -> Score:
        """Product of factors as a score: 100 times the product of the factors divided by 100.

        Raises:
            UsageError: If there are no factors.
        """
        if len(scores) < 2:
            if not scores:
                raise UsageError("expected at least one factor")
            return scores[0]
        names = {f"factor_{i}": score.expression for i, score in enumerate(scores)}
        parts = " * ".join(f"min(max({name} / 100, 0), 1)" for name in names)
        return cls(Expression.parse(f"100 * {parts}", names))

    @property
    def features(self) -> tuple[Feature, ...]:
        """Features that the score depends on: the columns that `evaluate` expects."""
        return self.expression.features

    @property
    def levels(self) -> tuple[float, ...]:
        """Possible scores, ascending, if the score was defined by cases; otherwise empty."""
        return tuple(sorted({0.0, *(case.value for case in self.cases)})) if self.cases else ()

    def evaluate(self, values: Floats) -> Floats:
        """The score of every model.

        Args:
            values: [models, F] the values of `features`, in their order.

        Returns:
            [models], 0 to 100.
        """
        return np.clip(self.expression.evaluate(values), 0.0, 100.0)
