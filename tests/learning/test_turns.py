"""Whose turn it is: factors that are known wait for those that are not."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from grammarlab.learning.answers import Answers
from grammarlab.learning.interview import MIN_SCORES, MIN_TURN_SHARE, interview, next_factor
from grammarlab.learning.round import init, step
from tests.cases import takes_turns
from tests.learning.bits import BitsSpace, score_of, study_of

NAMES = ("factor 0", "factor 1")


@cache
def known(nums, errors=(0.0, 0.0), **settings):
    """A study, and the state after some scores of each factor with normal errors."""
    study = study_of(BitsSpace(), **settings)
    answers = []
    for place, (name, num) in enumerate(zip(NAMES, nums, strict=True)):
        designs = study.tables().addresses[:num]
        exact = score_of(study.space.make(designs))[:, place]
        errs = errors[place] * np.random.default_rng(place).normal(size=num)
        answers.append(Answers(name, designs, np.clip(exact + errs, 0.0, 100.0)))
    return study, step(study, init(study), answers)


@takes_turns
def test_factors_begin_in_turn():
    study = study_of(BitsSpace())
    assert next_factor(study, init(study), NAMES, 8) == 0
    for nums in ((8, 0), (16, 8), (MIN_SCORES + 40, MIN_SCORES - 8)):
        assert next_factor(*known(nums), NAMES, 8) == 1
    assert next_factor(*known((8, 8)), NAMES, 8) == 0


@takes_turns
@pytest.mark.parametrize("names", [NAMES, NAMES[::-1]])
def test_then_the_factor_that_is_still_open_is_asked_about(names):
    for nums in ((32, 32), (40, 32)):
        assert names[next_factor(*known(nums, (40.0, 0.0)), names, 8)] == "factor 0"


@takes_turns
def test_a_factor_that_seems_known_is_still_asked_about_sometimes():
    study, state = known((104, 32), (25.0, 0.0))
    assert MIN_TURN_SHARE * (104 + 32) / 2 > 32
    assert next_factor(study, state, NAMES, 8) == 1


def test_methods_without_a_posterior_take_turns():
    assert next_factor(*known((32, 40), (25.0, 25.0), fit="kde"), NAMES, 8) == 0


@takes_turns
def test_a_factor_without_a_liked_model_takes_its_turn():
    study, state = known((32, 40), (25.0, 0.0))
    assert next_factor(study, replace(state, liked=("factor 0",)), NAMES, 8) == 0
    study, state = known((40, 32), (25.0, 0.0))
    assert next_factor(study, replace(state, liked=("factor 0",)), NAMES, 8) == 1


@takes_turns
def test_one_factor_is_always_asked_about_and_no_model_twice():
    study, state = known((64, 0))
    assert next_factor(study, state, NAMES[:1], 8) == 0
    size = 48
    full = study_of(BitsSpace(), size=size)

    def person(designs, _):
        exact = score_of(full.space.make(designs))
        exact[:, 0] += np.random.default_rng(len(designs)).normal(0.0, 20.0, len(exact))
        return np.clip(exact, 0.0, 100.0)

    *_, last = interview(full, NAMES, person, budget=10_000, batch=16)
    assert [len(last.answers[name].designs) for name in NAMES] == [size, size]


@takes_turns
def test_factors_that_seem_known_take_turns_again():
    assert next_factor(*known((88, 96)), NAMES, 8) == 0
    assert next_factor(*known((96, 88)), NAMES, 8) == 1


@takes_turns
def test_with_scores_for_the_whole_pool_every_factor_is_known():
    study, state = known((48, 48), size=48)
    assert next_factor(study, state, NAMES, 8) == 0
    study, state = known((48, 40), (40.0, 0.0), size=48)
    assert next_factor(study, state, NAMES, 8) == 1
