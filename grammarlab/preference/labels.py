"""Labels: what people said about which models, as plain data.

A label is one score of one model for one factor. The model is named by its address, from which it can be derived again:
the grammar's hash, the seed, the index of the model, and what was said beside the grammar. So labels and the grammar
are all that a preference needs. Labels keep their order and may repeat; two scores of one model that contradict each
other are both kept, and the methods that fit preferences take their mean.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.preference.base import MAX_SCORE

OVERALL = "overall"
"""The factor of labels that are about the whole model."""

MAX_TEXT = 4096
"""Characters of one text."""

_HASH = re.compile(r"[0-9a-f]{64}")
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")


@dataclass(frozen=True, slots=True)
class Label:
    """One score.

    Raises:
        UsageError: when a value is out of range; the message names the field.
    """

    seed: int
    """Of the model, 0 <= seed < 2**64."""
    model: int
    """Index of the model under the seed, 0 <= model < 2**63."""
    factor: str
    """What the score is about; `OVERALL` when there are no factors."""
    score: float
    """0 (not wanted) to 100."""
    grammar: str
    """SHA-256 of the grammar's text, 64 hexadecimal digits: `Grammar.hash`."""
    start_rule: str = ""
    """Empty for the one that the grammar marks."""
    attributes: str = "{}"
    """JSON object of attribute values, {} where the grammar's own were used."""
    footprint: str = ""
    """As the command line takes it, ``20x12`` or WKT; empty for the default."""

    def __post_init__(self) -> None:
        _check_integer("seed", self.seed, 64)
        _check_integer("model", self.model, 63)
        for name in ("factor", "grammar", "start_rule", "attributes", "footprint"):
            _check_text(name, getattr(self, name))
        if not self.factor:
            raise UsageError(f"factor: expected a name, found nothing; {OVERALL!r} where there are no factors.")
        if isinstance(self.score, bool) or not isinstance(self.score, int | float) or not 0 <= self.score <= MAX_SCORE:
            raise UsageError(
                f"score: expected a number from 0 to {MAX_SCORE:g}, found {_shown(self.score)}. "
                "Leave models out that have no score."
            )
        if not _HASH.fullmatch(self.grammar):
            raise UsageError(f"grammar: expected a SHA-256 of 64 hexadecimal digits, found {_shown(self.grammar)}.")
        if self.attributes != "{}":
            _check_attributes(self.attributes)

    @property
    def address(self) -> tuple[str, str, str, str, int, int]:
        """All that names the model: labels of equal address are about the same one."""
        return self.grammar, self.start_rule, self.attributes, self.footprint, self.seed, self.model


@dataclass(frozen=True, slots=True)
class Labels:
    """A table of labels."""

    rows: tuple[Label, ...] = ()

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Label]:
        return iter(self.rows)

    def __add__(self, other: Labels) -> Labels:
        return Labels(self.rows + other.rows)

    @property
    def factors(self) -> tuple[str, ...]:
        """The factors that have labels, in order of their first label."""
        return tuple(dict.fromkeys(label.factor for label in self.rows))

    def of(self, factor: str) -> Labels:
        """The labels of one factor."""
        return Labels(tuple(label for label in self.rows if label.factor == factor))

    @property
    def scores(self) -> NDArray[np.float64]:
        """[n] one a row."""
        return np.array([label.score for label in self.rows], dtype=np.float64)


def _check_integer(name: str, value: object, bits: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 1 << bits:
        raise UsageError(f"{name}: expected an integer 0 <= {name} < 2**{bits}, found {_shown(value)}.")


def _check_text(name: str, value: object) -> None:
    if not isinstance(value, str):
        raise UsageError(f"{name}: expected text, found {_shown(value)}.")
    if len(value) > MAX_TEXT:
        raise UsageError(f"{name}: {len(value)} characters; {MAX_TEXT} are allowed.")
    if _CONTROL.search(value):
        raise UsageError(f"{name}: expected one line of text, found {_shown(value)}.")


def _check_attributes(text: str) -> None:
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        values = None
    plain = isinstance(values, dict) and all(isinstance(value, int | float | str) for value in values.values())
    if not plain:
        raise UsageError(f'attributes: expected a JSON object like {{"height":12}}, found {_shown(text)}.')


def _shown(value: object) -> str:
    if isinstance(value, int) and value.bit_length() > 200:
        return f"an integer of {value.bit_length()} bits"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
