"""How far scores are explained, in words: what is kept of the original, because no pattern is known yet."""

from __future__ import annotations

from collections.abc import Mapping

from grammarlab.preference.base import AbstractPreference
from grammarlab.preference.blended import BlendedPreference


def knowledge_of(preferences: Mapping[str, AbstractPreference]) -> tuple[str, ...]:
    """A sentence for each preference that has no pattern, or not enough scores for one.

    Args:
        preferences: preferences of factors by name.
    """
    blends = [(name, part) for name, part in preferences.items() if isinstance(part, BlendedPreference)]
    sentences = [(name, _sentence(part)) for name, part in blends]
    return tuple(f"{name}: {text}" if len(preferences) > 1 else text for name, text in sentences if text)


def _sentence(preference: BlendedPreference) -> str:
    if preference.unexplained == 0.0:
        return ""
    if preference.unexplained == 1.0:
        state = "No pattern yet: the original is kept"
    else:
        state = f"Not enough yet: {preference.unexplained:.0%} of the original is kept"
    if not preference.sketches:
        return f"{state}."
    return f"{state} (what was found explains {preference.explained_variance:.0%} of held-out scores)."
