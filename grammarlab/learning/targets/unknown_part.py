"""How far scores are explained, in words: two voices, and what is kept of the original for want of a pattern."""

from __future__ import annotations

from grammarlab.learning.round import State, Study
from grammarlab.preference.blended import BlendedPreference

_ALIKE = "All models are alike: nothing that is drawn at random tells them apart, so there is nothing to learn."


def knowledge_of(study: Study, state: State) -> tuple[str, ...]:
    """Sentences about the scores of each liked factor: two voices in them, no pattern, or not enough for one."""
    if not study.table(state).features:
        return (_ALIKE,)
    sentences = list[str]()
    for name in state.liked:
        preference, entry = state.preferences[name], state.heard.get(name)
        of_pattern = _sentence(preference) if isinstance(preference, BlendedPreference) else ""
        of_voices = "" if entry is None else str(entry)
        sentences += [f"{name}: {text}" if len(state.liked) > 1 else text for text in (of_voices, of_pattern) if text]
    return tuple(sentences)


def _sentence(preference: BlendedPreference) -> str:
    if preference.unexplained == 0.0:
        return ""
    if preference.unexplained == 1.0:
        # Whatever was found is not believed, so its share would contradict this.
        return "No pattern yet: the original is kept."
    state = f"Not enough yet: {preference.unexplained:.0%} of the original is kept"
    if not preference.sketches:
        return f"{state}."
    return f"{state} (what was found explains {preference.explained_variance:.0%} of held-out scores)."
