"""Choices at places that a model has at most once: the number of the alternative, 0 if there is no such place.

A place is a line (`grammarlab.tastes.choice_lines`) as short as it can be: ``Roof`` if a model has one roof, else
``Tower > Roof@1``, up to the root.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial, reduce

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.features.expression import MAX_FEATURES
from grammarlab.features.patterns.pattern import Draw, Formula, Pattern
from grammarlab.tastes.choice_lines import MAX_ANCESTORS, Line, Lines
from grammarlab.tastes.quantities import MAX_TEXT, Later, Quantities

MAX_CHOICES = 240
"""Largest number of choices at places, and of those outside rules."""


@dataclass(frozen=True, eq=False)
class Choice:
    """A choice that each of n models makes at most once."""

    line: Line
    number: Ints
    """[n] number of the alternative, from 1; 0 in models without the place."""
    way: tuple[int, ...]
    """Indices of successors from the root down, at its first occurrence: the order in the text of the rules."""
    order: tuple[int, ...] = ()
    """Numbers of the alternatives in another order than that of the text."""

    @property
    def num_alternatives(self) -> int:
        """Number of the last alternative."""
        return len(self.line.labels)

    @property
    def alternatives(self) -> tuple[Pattern | Formula | None, ...]:
        """Count of each alternative, by its number; None for those that it does not have."""
        return tuple(map(summed, self.line.alternatives))

    @property
    def formula(self) -> Formula:
        """The rank of the alternative: its number, if there is no other order."""
        counts = {number: count for number, count in enumerate(self.alternatives, 1) if count is not None}
        order = self.order or range(1, self.num_alternatives + 1)
        return Formula.of("which", *(counts.get(number, 0.0) for number in order))

    @property
    def rank(self) -> Ints:
        """[n] rank of the alternative, from 1; 0 in models without the place."""
        return np.array([0, *(1 + np.argsort(self.order))])[self.number] if self.order else self.number


@dataclass(frozen=True, eq=False)
class Outcome:
    """A random choice outside rules that each of n models makes at most once, such as that of an attribute."""

    number: Ints
    """[n] number of the alternative, from 1; 0 in models that do not use it."""
    alternatives: tuple[Draw | Formula, ...]
    """Whether a model has each alternative, by its number."""

    @property
    def num_alternatives(self) -> int:
        """Number of the last alternative."""
        return len(self.alternatives)


def choices_of(lines: Lines) -> tuple[Choice, ...]:
    """Choices at places, those of short lines first; of places with equal choices the shortest."""
    choices: dict[bytes, Choice] = {}
    for length in range(MAX_ANCESTORS + 1):
        for by_symbol in (True, False):
            for line in lines.groups(length, by_symbol=by_symbol):
                model = lines.nodes.model[line.rows]
                if len(choices) >= MAX_CHOICES:
                    return tuple(choices.values())
                if (line.number == line.number[0]).all() or len(np.unique(model)) < len(model):
                    continue
                number = np.zeros(lines.nodes.num_models, dtype=np.int64)
                number[model] = line.number
                key = bytes([line.kind % 256, line.kind // 256]) + number.tobytes()
                if key not in choices and are_short([line]):
                    choices[key] = Choice(line, number, lines.way(int(line.rows[0])))
    return tuple(choices.values())


def are_short(lines: Sequence[Line]) -> bool:
    """Whether what is said about the choices of some lines, each named once, is short enough to be read back."""
    num_features = sum(len(labels) for line in lines for labels in line.labels)
    return num_features <= MAX_FEATURES and sum(line.num_characters for line in lines) <= MAX_TEXT


def as_quantities(choices: Sequence[Choice], num: int) -> Quantities:
    """The ranks of the alternatives of choices, as quantities of ``num`` models."""
    values = np.stack([np.zeros(num), *(choice.rank.astype(np.float64) for choice in choices)], axis=1)[:, 1:]
    return Quantities(Later([partial(_formula, choice) for choice in choices]), values)


def _formula(choice: Choice) -> Formula:
    return choice.formula


def total(patterns: Sequence[Pattern]) -> Pattern | Formula:
    """Sum of the counts of one pattern or more."""
    return reduce(partial(Formula.of, "+"), patterns[1:], patterns[0])


def summed(patterns: Sequence[Pattern]) -> Pattern | Formula | None:
    """Sum of the counts of patterns; None without patterns."""
    return total(patterns) if patterns else None
