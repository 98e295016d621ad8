"""Choices at places that a model has at most once: the number of the alternative, 0 if there is no such place.

A place is a line (`grammarlab.tastes.choice_lines`) as short as it can be: ``Roof`` if a model has one roof, else
``Tower > Roof@1``, up to the root.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial, reduce
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.features.patterns.pattern import Formula, Pattern
from grammarlab.tastes.choice_lines import MAX_ANCESTORS, Line, Lines
from grammarlab.tastes.quantities import Later, Quantities

MAX_CHOICES = 240
"""Largest number of choices at places."""


class Choice(NamedTuple):
    """A choice that each of n models makes at most once."""

    line: Line
    number: Ints
    """[n] number of the alternative, from 1; 0 in models without the place."""
    way: tuple[int, ...]
    """Indices of successors from the root down, at its first occurrence: the order in the text of the rules."""

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
        """The number of the alternative."""
        return Formula.of("which", *(0.0 if count is None else count for count in self.alternatives))


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
                if (key := bytes([line.kind % 256, line.kind // 256]) + number.tobytes()) not in choices:
                    choices[key] = Choice(line, number, lines.way(int(line.rows[0])))
    return tuple(choices.values())


def as_quantities(choices: Sequence[Choice], num: int) -> Quantities:
    """The numbers of the alternatives of choices, as quantities of ``num`` models."""
    values = np.stack([np.zeros(num), *(choice.number.astype(np.float64) for choice in choices)], axis=1)[:, 1:]
    return Quantities(Later([partial(_formula, choice) for choice in choices]), values)


def _formula(choice: Choice) -> Formula:
    return choice.formula


def total(patterns: Sequence[Pattern]) -> Pattern | Formula:
    """Sum of the counts of one pattern or more."""
    return reduce(partial(Formula.of, "+"), patterns[1:], patterns[0])


def summed(patterns: Sequence[Pattern]) -> Pattern | Formula | None:
    """Sum of the counts of patterns; None without patterns."""
    return total(patterns) if patterns else None
