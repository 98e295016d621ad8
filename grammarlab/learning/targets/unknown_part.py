"""How far scores are explained, in words: two voices, and what is kept of the original for want of a pattern."""

from __future__ import annotations

import numpy as np

from grammarlab.learning.round import State, Study
from grammarlab.preference.blended import BlendedPreference

_ALIKE = "All models are alike: nothing that is drawn at random tells them apart, so there is nothing to learn."

CHANCE = "No held-out score is explained, so what was found may be chance; more scores will show."
"""Before kinds of designs that held-out scores do not confirm."""
MIN_LABELS = 32
"""Least number of scores from which a share of held-out ones is given; of fewer scores, these are a handful."""


def knowledge_of(study: Study, state: State, has_kinds: bool) -> tuple[str, ...]:
    """Sentences about the scores of each liked factor: two voices in them, no pattern, or not enough for one.

    Args:
        study: the pool and its tables.
        state: what was learned.
        has_kinds: whether words name liked or disliked kinds of designs, which may be chance.
    """
    if not study.table(state).features:
        return (_ALIKE,)
    voices = voices_of(state)
    sentences = list[str]()
    for name in state.liked:
        preference = state.preferences[name]
        num_scores = len(state.answers[name].scored.scores)
        may_be_chance = has_kinds and num_scores >= MIN_LABELS
        of_pattern = _sentence(preference, may_be_chance) if isinstance(preference, BlendedPreference) else ""
        of_pattern = "All scores are equal: the original is kept." if are_equal(state, name) else of_pattern
        sentences += [text for text in (voices.get(name, ""), _of_factor(state, name, of_pattern)) if text]
    return tuple(sentences)


def are_equal(state: State, name: str) -> bool:
    """Whether all labels of a factor are scores, and these are equal: no design is better than another one."""
    answers = state.answers[name]
    scores = answers.scored.scores
    return len(scores) == len(answers.scores) and bool(np.ptp(scores) == 0.0)


def voices_of(state: State) -> dict[str, str]:
    """By liked factor, a sentence about two voices in its scores; none for one voice."""
    heard = {name: _of_factor(state, name, str(state.heard[name])) for name in state.liked if name in state.heard}
    return {name: text for name, text in heard.items() if text}


def _of_factor(state: State, name: str, text: str) -> str:
    """A sentence with the name of its factor, if there are several."""
    return f"{name}: {text}" if text and len(state.liked) > 1 else text


def is_explained(state: State) -> bool:
    """Whether the scores of each liked factor have a pattern that replaces more than half of the original."""
    preferences = [state.preferences[name] for name in state.liked]
    kept = [preference.unexplained for preference in preferences if isinstance(preference, BlendedPreference)]
    return bool(preferences) and all(2.0 * share < 1.0 for share in kept)


def _sentence(preference: BlendedPreference, may_be_chance: bool) -> str:
    unexplained, explained = preference.unexplained, preference.explained_variance
    is_nothing_explained = explained is not None and f"{explained:.0%}" == "0%"
    chance = CHANCE if may_be_chance and is_nothing_explained else ""
    if unexplained == 0.0:
        return chance
    if unexplained == 1.0:
        # Whatever was found is not believed, so its share would contradict this.
        return "No pattern yet: the original is kept."
    state = f"Not enough yet: {unexplained:.0%} of the original is kept"
    if chance:
        return f"{state}. {chance}"
    if explained is None:
        return f"{state}."
    return f"{state} (what was found explains {explained:.0%} of held-out scores)."
