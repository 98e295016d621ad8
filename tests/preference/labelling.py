"""Labels as tests need them."""

from __future__ import annotations

from collections.abc import Iterable

from grammarlab.preference.labels import OVERALL, Label, Labels


def label_models(
    grammar: str, seed: int, models: Iterable[int], scores: Iterable[float], factor: str = OVERALL
) -> Labels:
    """Labels of models of one seed."""
    pairs = zip(models, scores, strict=True)
    return Labels(tuple(Label(int(seed), int(model), factor, float(score), grammar) for model, score in pairs))
