"""Labels in a session: a score, stars or a thumb for one model; a preference or a tie for two models."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from grammarlab.errors import UsageError, shown
from grammarlab.learning.designs.addresses import Address
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.labels import SCORES, Kind, Label

SCALES: tuple[Kind, ...] = ("score", "stars", "thumb")
"""Kinds of labels of one model."""
_COMPARISONS: tuple[Kind, ...] = ("rather", "tie")

Subject = str
"""Subject of a label: the address of a model, or those of two, in ascending order with a space between."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """Latest label of a subject."""

    score: float
    """0 to 100, as in `Label`; for a comparison 100 if the first model is preferred, 0 if the second one is."""
    kind: Kind = "score"

    @property
    def is_positive(self) -> bool:
        """Whether it means that a model is liked."""
        return self.kind == "rather" or (self.kind != "tie" and self.score > 0.0)

    def as_json(self) -> float | list[object]:
        """Form in events: a number for a score, otherwise a kind and a number."""
        return self.score if self.kind == "score" else [self.kind, self.score]


Scores = dict[Subject, Judgement]
"""All labels of one factor."""


def models_of(subjects: Iterable[Subject]) -> dict[str, None]:
    """The different models with labels."""
    return {model: None for subject in subjects for model in subject.split(" ")}


def compared(models: Sequence[str], kind: Kind) -> tuple[Subject, Judgement]:
    """Whether the first of two models is preferred, the second, or both are equal."""
    first, second = sorted(models, key=Address.parse)
    score = SCORES[kind][0] if first == models[0] else MAX_SCORE - SCORES[kind][0]
    return f"{first} {second}", Judgement(score, kind)


def as_label(subject: Subject, judgement: Judgement, factor: str, hashes: tuple[str, str]) -> Label:
    """The label in the form of label files; see `Address.label`."""
    addresses = [Address.parse(model) for model in subject.split(" ")]
    if len(addresses) == 1:
        return replace(addresses[0].label(factor, judgement.score, hashes), kind=judgement.kind)
    # A comparison names the preferred model first.
    here, there = addresses if judgement.score >= SCORES["tie"][0] else addresses[::-1]
    other: dict[str, object] = {"seed": there.seed, "model": there.model}
    if here.flat != there.flat:
        other["grammar"] = hashes[there.flat]
    label = here.label(factor, max(judgement.score, MAX_SCORE - judgement.score), hashes)
    return replace(label, kind=judgement.kind, other=json.dumps(other, separators=(",", ":")))


def of_label(label: Label, hashes: tuple[str, str]) -> tuple[Subject, Judgement]:
    """Subject and value of a label."""
    model, other = Address.of(label, hashes), Address.of_other(label, hashes)
    if other is None:
        return str(model), Judgement(float(label.score), label.kind)
    return compared((str(model), str(other)), label.kind)


def checked_judgement(score: object, kind: object = "score") -> Judgement:
    """A label of one model on a scale.

    Raises:
        UsageError: If there is no such scale, or it has no such score.
    """
    scale: Kind | None = next((name for name in SCALES if name == kind), None)
    if scale is None:
        raise UsageError(f"kind: expected one of {', '.join(SCALES)}, found {shown(kind)}.")
    if isinstance(score, bool) or not isinstance(score, int | float) or not 0 <= score <= MAX_SCORE:
        raise UsageError(f"score: expected a number from 0 to {MAX_SCORE:g}, or null for none, found {shown(score)}.")
    if score not in SCORES.get(scale, (score,)):
        expected = ", ".join(f"{value:g}" for value in SCORES[scale])
        raise UsageError(f"score: expected one of {expected} for the kind {scale}, found {shown(score)}.")
    return Judgement(float(score), scale)


def checked_entry(subject: object, value: object) -> tuple[Subject, Judgement]:
    """A subject and its label, from the form of `Judgement.as_json`.

    Raises:
        UsageError: If it has another form.
    """
    kind, score = value if isinstance(value, list) and len(value) == 2 else ("score", value)
    models = subject.split(" ") if isinstance(subject, str) else []
    if len(models) != 2:
        return str(Address.parse(subject)), checked_judgement(score, kind)
    checked_pair(models)
    possible = [compared(order, name) for order in (models, models[::-1]) for name in _COMPARISONS]
    matches = [(pair, judgement) for pair, judgement in possible if pair == subject and judgement.as_json() == value]
    if not matches:
        raise UsageError(
            f"scores: expected a comparison of two models such as 'g5-1 g5-2' with ['rather', 100], found "
            f"{shown(subject)} with {shown(value)}."
        )
    return matches[0]


def checked_pair(models: object) -> list[str]:
    """Addresses of two different models.

    Raises:
        UsageError: If they are not two.
    """
    if not isinstance(models, list) or len(models) != 2 or Address.parse(models[0]) == Address.parse(models[1]):
        raise UsageError(f"models: expected two different ones to compare, found {shown(models)}.")
    return models
