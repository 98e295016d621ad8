"""Which answers count: all of one person, the later ones after a change of taste, and what two people have together."""

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.learning.answers import Answers
from grammarlab.learning.heard import Heard, heard
from grammarlab.learning.questions import ask
from grammarlab.learning.round import init, step
from grammarlab.learning.targets.unknown_part import CHANCE, MIN_LABELS, knowledge_of
from grammarlab.preference.blended import BlendedPreference
from tests.learning.bits import study_of

NUM, CHANGE = 64, 30
STUDY = study_of(widens=False)
DESIGNS = tuple(STUDY.pool)[:NUM]
ROWS = STUDY.space.make(DESIGNS)
FIRST, LATER = 90.0 * ROWS[:, 0], 80.0 * ROWS[:, 1] * ROWS[:, 2]


def changed():
    return np.where(np.arange(NUM) < CHANGE, FIRST, LATER)


@pytest.fixture(scope="module")
def state():
    return step(STUDY, init(STUDY), [said(changed())])


def said(scores, **kinds):
    return Answers("overall", DESIGNS, scores, **kinds)


def test_all_answers_of_one_person_count():
    for scores in (FIRST, LATER):
        found = heard(said(scores), ROWS, np.zeros(0))
        assert found.answers.designs == DESIGNS
        assert found.answers.scores is scores
        assert str(found) == ""


def test_the_later_answers_count_after_a_change():
    found = heard(said(changed()), ROWS, np.zeros(0))
    assert found.division is not None
    first = found.division.number
    assert abs(first - CHANGE) <= 2
    assert found.answers.designs == DESIGNS[first:]
    assert found.answers.scores.tolist() == LATER[first:].tolist()
    assert str(found) == (f"Your scores before no. {first + 1} contradict the later ones; the later ones count.")


def test_comparisons_count_from_the_change_on():
    """Scores and comparisons in turn: the number is that of the score, and no earlier comparison counts."""
    scores = np.ravel(np.column_stack([changed(), np.full(NUM, 100.0)]))
    designs = tuple(design for design in DESIGNS for _ in range(2))
    others = tuple(None if place % 2 == 0 else DESIGNS[place // 2 - 1] for place in range(2 * NUM))
    told = Answers("overall", designs, scores, ("score", "rather") * NUM, others)
    found, plain = heard(told, ROWS, np.zeros(0)), heard(said(changed()), ROWS, np.zeros(0))
    assert found.division is not None
    assert plain.division is not None
    assert found.division.number == plain.division.number
    assert found.num_answers == 2 * NUM
    assert found.answers.kinds == ("score", "rather") * len(plain.answers.designs)
    assert found.answers.others[1::2] == DESIGNS[plain.division.number - 1 : -1]


def test_a_voice_that_likes_nothing_is_not_the_one_that_counts():
    found = heard(said(np.where(np.arange(NUM) < CHANGE, FIRST, 0.0)), ROWS, np.zeros(0))
    assert found.answers.designs == DESIGNS
    assert found.division is None


def test_two_people_count_with_what_they_say_together():
    turns = np.where(np.arange(NUM) % 2 == 0, FIRST, LATER)
    found = heard(said(turns), ROWS, np.zeros(0))
    assert found.division is not None
    assert found.division.kind == "turns"
    assert found.answers.designs == DESIGNS
    assert found.answers.scores == pytest.approx((FIRST + LATER) / 2.0, abs=1.0)
    assert "two people who disagree" in str(found)


def predicted(state):
    return state.preferences["overall"].predict(STUDY.table(state).rows).mean


def test_the_state_has_what_was_heard_and_says_so(state):
    assert state.answers["overall"].designs == DESIGNS
    later = state.heard["overall"].answers
    same = step(STUDY, init(STUDY), [later])
    assert state.columns == same.columns
    assert np.array_equal(predicted(state), predicted(same))
    assert knowledge_of(STUDY, state, True)[0] == str(state.heard["overall"])
    assert not any("contradict" in line for line in knowledge_of(STUDY, same, True))


@pytest.mark.parametrize(
    ("num", "unexplained", "explained", "sentence"),
    [
        (NUM, 0.0, 0.004, CHANCE),
        (NUM, 0.7, 0.0, f"Not enough yet: 70% of the original is kept. {CHANCE}"),
        (
            NUM,
            0.7,
            0.2,
            "Not enough yet: 70% of the original is kept (what was found explains 20% of held-out scores).",
        ),
        (NUM, 1.0, 0.0, "No pattern yet: the original is kept."),
        (NUM, 0.0, 0.006, ""),
        (NUM, 0.0, None, ""),
        (MIN_LABELS - 1, 0.0, 0.0, ""),
        (MIN_LABELS, 0.0, 0.0, CHANCE),
    ],
)
def test_what_explains_no_held_out_score_may_be_chance(num, unexplained, explained, sentence):
    known = step(STUDY, init(STUDY), [Answers("overall", DESIGNS[:num], FIRST[:num])])
    preference = known.preferences["overall"]
    assert isinstance(preference, BlendedPreference)
    preference = replace(preference, unexplained=unexplained, explained_variance=explained)
    known = replace(known, preferences={"overall": preference})
    assert knowledge_of(STUDY, known, True) == ((sentence,) if sentence else ())
    assert CHANCE not in " ".join(knowledge_of(STUDY, known, False))


def test_answers_in_steps_are_heard_as_answers_at_once(state):
    in_steps = init(STUDY)
    for part in (slice(0, 50), slice(50, NUM)):
        in_steps = step(STUDY, in_steps, [Answers("overall", DESIGNS[part], changed()[part])])
    assert in_steps.heard["overall"].answers.designs == state.heard["overall"].answers.designs
    assert np.array_equal(predicted(in_steps), predicted(state))


@pytest.mark.parametrize("way", ["default", "grammar", "uniform"])
def test_nobody_is_asked_again_about_designs_whose_scores_do_not_count(state, way):
    asked = ask(STUDY, state, 40, 0, factor="overall", way=way)
    assert len(asked) == 40
    assert not set(asked) & set(DESIGNS)
    assert not set(ask(STUDY, state, 40, 0, way=way)) & set(DESIGNS)


def test_all_answers_count_for_other_methods():
    other = study_of(widens=False, fit="kde")
    by_kde = step(other, init(other), [said(changed())])
    assert by_kde.heard["overall"] == Heard(by_kde.answers["overall"], NUM)
