"""Labels: scores and comparisons of models, as plain data.

A label is one score of one model for one factor, or a comparison of two models. A model is named by its address, from
which it can be derived again: the grammar's hash, the seed, the index of the model, and options such as attributes.
So a preference needs only labels and the grammar. Labels keep their order and may repeat; contradicting labels of
one model are all kept, as noisy measurements of one value.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError, shown
from grammarlab.preference.base import MAX_SCORE

OVERALL = "overall"
"""Factor of labels of the whole model."""

MAX_TEXT = 4096
"""Largest number of characters of one text."""

Kind = Literal["score", "stars", "thumb", "rather", "tie"]
"""Kind of a label: a score of 0 to 100; five stars; up or down; this model preferred to another; both equal."""

COMPARISONS = ("rather", "tie")
"""Kinds of labels of two models."""

SCORES: dict[str, tuple[float, ...]] = {
    "stars": (0.0, 25.0, 50.0, 75.0, 100.0),
    "thumb": (0.0, 100.0),
    "rather": (100.0,),
    "tie": (50.0,),
}
"""Allowed scores of each kind; for ``score`` any from 0 to 100."""

Place = tuple[str, str, str, str, int, int]
"""Fields of the address of a model: grammar, start rule, attributes, footprint, seed, index."""

_PLACE = ("grammar", "start_rule", "attributes", "footprint", "seed", "model")

_HASH = re.compile(r"[0-9a-f]{64}")
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")


@dataclass(frozen=True, slots=True)
class Label:
    """One score, or one comparison.

    Raises:
        UsageError: If a value is out of range; the message names the field.

    >>> import grammarlab as gl
    >>> label = gl.Label(seed=1, model=17, factor="overall", score=80.0, grammar="0" * 64)
    >>> label.kind, label.score
    ('score', 80.0)
    """

    seed: int
    """Seed of the model, 0 <= seed < 2**64."""
    model: int
    """Index of the model under the seed, 0 <= model < 2**64."""
    factor: str
    """Factor of the score; `OVERALL` without factors."""
    score: float
    """0 (disliked) to 100: for five stars 0, 25, 50, 75 or 100, for a thumb 100 (up) or 0 (down), for a comparison 100
    if this model is preferred to the other one and 50 if they are equal."""
    grammar: str
    """SHA-256 of the grammar's text, 64 hexadecimal digits: `Grammar.hash`."""
    start_rule: str = ""
    """Start rule; empty for the marked one of the grammar."""
    attributes: str = "{}"
    """JSON object of attribute values, {} for the grammar's own."""
    footprint: str = ""
    """Footprint in the syntax of the command line, ``20x12`` or WKT; empty for the default."""
    kind: Kind = "score"
    """Kind of the label."""
    other: str = ""
    """The other model of a comparison, as a JSON object of ``seed``, ``model`` and other fields of its address that
    differ from this one's; empty for other kinds."""

    def __post_init__(self) -> None:
        _check_integer("seed", self.seed)
        _check_integer("model", self.model)
        for name in ("factor", "grammar", "start_rule", "attributes", "footprint", "kind", "other"):
            _check_text(name, getattr(self, name))
        if not self.factor:
            raise UsageError(f"factor: expected a name, found nothing; use {OVERALL!r} without factors.")
        if isinstance(self.score, bool) or not isinstance(self.score, int | float) or not 0 <= self.score <= MAX_SCORE:
            raise UsageError(
                f"score: expected a number from 0 to {MAX_SCORE:g}, found {shown(self.score)}. "
                "Leave models out that have no score."
            )
        _check_hash("grammar", self.grammar)
        if self.attributes != "{}":
            _check_attributes(self.attributes)
        if self.kind != "score" or self.other:
            _check_kind(self)

    @property
    def address(self) -> Place:
        """Address of the model: labels of equal address belong to the same model."""
        return self.grammar, self.start_rule, self.attributes, self.footprint, self.seed, self.model

    @property
    def other_address(self) -> Place | None:
        """Address of the other model of a comparison; None for other kinds."""
        if not self.other:
            return None
        parts = dict(zip(_PLACE, self.address, strict=True))
        grammar, start_rule, attributes, footprint, seed, model = (parts | json.loads(self.other)).values()
        return grammar, start_rule, attributes, footprint, seed, model


@dataclass(frozen=True, slots=True)
class Labels:
    """A table of labels.

    >>> import grammarlab as gl
    >>> labels = gl.Labels(tuple(gl.Label(1, model, "overall", 50.0 * model, "0" * 64) for model in range(3)))
    >>> labels.scores.tolist(), labels.factors
    ([0.0, 50.0, 100.0], ('overall',))
    """

    rows: tuple[Label, ...] = ()
    notes: tuple[str, ...] = field(default=(), compare=False)
    """Sentences about the file that they were read from: what was left out, and the scale of the scores."""

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Label]:
        return iter(self.rows)

    def __add__(self, other: Labels) -> Labels:
        return Labels(self.rows + other.rows, self.notes + other.notes)

    @property
    def factors(self) -> tuple[str, ...]:
        """Factors with labels, in order of their first label."""
        return tuple(dict.fromkeys(label.factor for label in self.rows))

    def of(self, factor: str) -> Labels:
        """The labels of one factor."""
        return Labels(tuple(label for label in self.rows if label.factor == factor))

    @property
    def scores(self) -> NDArray[np.float64]:
        """[n] scores."""
        return np.array([label.score for label in self.rows], dtype=np.float64)


def _check_kind(label: Label) -> None:
    """Check the fields that depend on the kind of a label."""
    if label.kind not in get_args(Kind):
        raise UsageError(f"kind: expected one of {', '.join(get_args(Kind))}, found {shown(label.kind)}.")
    allowed = SCORES.get(label.kind)
    if allowed is not None and label.score not in allowed:
        expected = " or ".join(f"{score:g}" for score in allowed)
        raise UsageError(f"score: expected {expected} for the kind {label.kind}, found {label.score:g}.")
    if (label.kind in COMPARISONS) != bool(label.other):
        example = '{"seed":5,"model":17}'
        expected = f"the model to compare with, such as {example}" if label.kind in COMPARISONS else "nothing"
        raise UsageError(f"other: expected {expected} for the kind {label.kind}, found {shown(label.other)}.")
    if label.other:
        _check_other(label)


def _check_other(label: Label) -> None:
    address: Any = _object(label.other)
    if address is None or not {"seed", "model"} <= set(address) <= set(_PLACE):
        raise UsageError(
            'other: expected a JSON object of seed and model like {"seed":5,"model":17}, and of '
            f"{', '.join(_PLACE[:4])} where they differ; found {shown(label.other)}."
        )
    for name, value in address.items():
        if name in ("seed", "model"):
            _check_integer(f"other: {name}", value)
        else:
            _check_text(f"other: {name}", value)
    if "grammar" in address:
        _check_hash("other: grammar", address["grammar"])
    if "attributes" in address:
        _check_attributes(address["attributes"])
    if label.other_address == label.address:
        raise UsageError("other: expected another model to compare with, found the same one.")


def _check_hash(name: str, value: str) -> None:
    if not _HASH.fullmatch(value):
        raise UsageError(f"{name}: expected a SHA-256 of 64 hexadecimal digits, found {shown(value)}.")


def _check_integer(name: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 1 << 64:
        raise UsageError(f"{name}: expected an integer 0 <= {name} < 2**64, found {shown(value)}.")


def _check_text(name: str, value: object) -> None:
    if not isinstance(value, str):
        raise UsageError(f"{name}: expected text, found {shown(value)}.")
    if len(value) > MAX_TEXT:
        raise UsageError(f"{name}: {len(value)} characters; {MAX_TEXT} are allowed.")
    if _CONTROL.search(value):
        raise UsageError(f"{name}: expected one line of text, found {shown(value)}.")


def _check_attributes(text: str) -> None:
    values = _object(text)
    if values is None or not all(isinstance(value, int | float | str) for value in values.values()):
        raise UsageError(f'attributes: expected a JSON object like {{"height":12}}, found {shown(text)}.')


def _object(text: str) -> dict[str, Any] | None:
    """JSON object of a text; None if it is not an object."""
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return values if isinstance(values, dict) else None
