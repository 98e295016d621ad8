"""Scales of scores in label files: fractions of 1 are read as points of 100, shorter scales are named in a note."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.labels.table import Label

_LARGEST_SHORT = 10.0
"""Largest highest score that is likely one of a scale of up to five or ten."""


_MOST_NAMED = 5
"""Largest number of factors in a note."""
_ADVICE = (
    "Give scores of a shorter scale in points of 100, or stars as the kind 'stars' with the scores 0, 25, 50, 75 and "
    "100."
)


def on_one_scale(rows: Sequence[Label]) -> tuple[tuple[Label, ...], tuple[str, ...]]:
    """Labels whose scores are from 0 to 100, and notes about other scales.

    Only labels of kind ``score`` matter, since other kinds have fixed scores.

    Args:
        rows: all labels of a file.

    >>> rows = [Label(1, model, "overall", score, "0" * 64) for model, score in enumerate((0.0, 0.25))]
    >>> labels, notes = on_one_scale(rows)
    >>> [label.score for label in labels], notes
    ([0.0, 25.0], ('all scores are from 0 to 1 and are read as fractions of 100: 0.25 as 25',))
    """
    scores = {label.score for label in rows if label.kind == "score"}
    highest = max(scores, default=0.0)
    if highest > 1.0:
        return tuple(rows), _short_notes(rows, highest)
    if not highest:
        return tuple(rows), ()
    points = tuple(
        replace(label, score=round(MAX_SCORE * label.score, 9)) if label.kind == "score" else label for label in rows
    )
    if scores <= {0.0, 1.0}:
        return points, (f"all scores are 0 or 1 and are read as 0 (disliked) and {MAX_SCORE:g} (liked)",)
    example = min(value for value in scores if 0.0 < value < 1.0)
    shown = f"{example:g} as {MAX_SCORE * example:g}"
    return points, (f"all scores are from 0 to 1 and are read as fractions of {MAX_SCORE:g}: {shown}",)


def _short_notes(rows: Sequence[Label], highest: float) -> tuple[str, ...]:
    """A note if all scores, or all of some factors, are likely of a shorter scale."""
    scale = f"on a scale of 0 (disliked) to {MAX_SCORE:g}, so all models are nearly disliked"
    if highest <= _LARGEST_SHORT:
        return (f"the highest score is {highest:g}, {scale}. {_ADVICE}",)
    of_factor: dict[str, float] = {}
    for label in rows:
        if label.kind == "score":
            of_factor[label.factor] = max(label.score, of_factor.get(label.factor, 0.0))
    short = [
        f"{score:g} for the factor {factor!r}" for factor, score in of_factor.items() if 0 < score <= _LARGEST_SHORT
    ]
    if not short:
        return ()
    more = f" and {len(short) - _MOST_NAMED} more factors" if len(short) > _MOST_NAMED else ""
    return (f"the highest score is {', '.join(short[:_MOST_NAMED])}{more}, {scale} by it. {_ADVICE}",)
