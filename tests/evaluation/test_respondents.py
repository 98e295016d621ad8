"""Simulated persons answer as their names say."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest

from grammarlab.evaluation.respondents import CHANGE, EXACT, RESPONDENTS

NUM = 40_000
OF_TWO_VOICES = ["changing", "changing_sd10", "two", "two_sd10"]
SEEDS = st.integers(0, 2**64 - 1)


def said(name, score, num=NUM, seed=3, first=0):
    """[num] what a person says about models that are all liked alike."""
    return RESPONDENTS[name].answers(np.full((num, 1), float(score)), seed, first)[:, 0]


def test_programs_rely_on_these_names():
    assert list(RESPONDENTS) == ["exact", "stars", "sd5", "sd10", "sd20", "blunders5", "blunders10", *OF_TWO_VOICES]
    assert all(name == person.name for name, person in RESPONDENTS.items())
    with pytest.raises(FrozenInstanceError):
        EXACT.noise = 1.0  # ty: ignore[invalid-assignment]  # pyright: ignore[reportAttributeAccessIssue] - that is what is tested


@pytest.mark.parametrize("sd", [5, 10, 20])
def test_noise_is_normal_with_the_sd_of_the_name(sd):
    # 50 is far from both ends, except for sd 20, of whose draws 1.2 % are cut.
    noise = (said(f"sd{sd}", 50) - 50.0) / sd
    if sd < 20:
        assert kstest(noise, "norm").pvalue > 0.01
    inside = np.abs(noise) < 2.4
    assert noise.mean() == pytest.approx(0.0, abs=4 / np.sqrt(NUM))
    assert inside.mean() == pytest.approx(0.98360, abs=0.003)
    # The variance of a normal distribution cut at 2.4 on both sides.
    assert noise[inside].var() == pytest.approx(0.8908, rel=0.03)


@pytest.mark.parametrize(("score", "end"), [(0, 0.0), (100, 100.0)])
def test_noise_beyond_the_ends_is_cut(score, end):
    answers = said("sd20", score)
    assert (answers == end).mean() == pytest.approx(0.5, abs=0.01)
    assert np.abs(answers - end).mean() == pytest.approx(20 / np.sqrt(2 * np.pi), rel=0.03)


@pytest.mark.parametrize("percent", [5, 10])
def test_blunders_are_uniform_and_as_many_as_the_name_says(percent):
    answers = said(f"blunders{percent}", 70)
    blunders = answers[answers != 70.0]
    share = percent / 100
    assert len(blunders) / NUM == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / NUM))
    assert kstest(blunders / 100, "uniform").pvalue > 0.01


def test_stars_say_and_mean_the_nearest_of_five_scores():
    stars = RESPONDENTS["stars"]
    scores = np.array([[0.0, 12.4, 12.5, 37.4], [37.5, 60.0, 87.4, 87.5]])
    rounded = [[0, 0, 25, 25], [50, 50, 75, 100]]
    assert stars.truth(scores).tolist() == rounded
    assert stars.answers(scores, 1, 0).tolist() == rounded
    assert stars.truth(stars.truth(scores)).tolist() == rounded


@given(SEEDS, st.lists(st.floats(0, 100), min_size=1, max_size=20), st.integers(0, 10**6))
def test_whoever_answers_stays_on_the_scale_and_only_stars_mean_something_else(seed, scores, first):
    values = np.array(scores)[:, None]
    for person in RESPONDENTS.values():
        answers = person.answers(values, seed, first)
        assert answers.shape == values.shape
        assert ((answers >= 0.0) & (answers <= 100.0)).all()
        assert person.name == "stars" or person.truth(values) is values
    assert np.array_equal(EXACT.answers(values, seed, first), values)


@given(SEEDS, st.integers(1, 30), st.integers(0, 30), st.integers(1, 3))
def test_answers_are_the_same_however_they_are_cut_into_rounds(seed, num, cut, factors):
    cut = min(cut, num)
    scores = np.linspace(0, 100, num * factors).reshape(num, factors)
    for person in RESPONDENTS.values():
        parts = person.answers(scores[:cut], seed, 7), person.answers(scores[cut:], seed, 7 + cut)
        assert np.array_equal(np.concatenate(parts), person.answers(scores, seed, 7))


@pytest.mark.parametrize("name", ["sd5", "sd10", "sd20", "blunders10"])
def test_later_answers_other_seeds_and_other_factors_have_draws_of_their_own(name):
    one = said(name, 50)
    both = RESPONDENTS[name].answers(np.full((NUM, 2), 50.0), 3, 0)
    assert np.array_equal(both[:, 0], one)
    for other in (said(name, 50, first=NUM), said(name, 50, seed=4), both[:, 1]):
        assert abs(np.corrcoef(one, other)[0, 1]) < 4 / np.sqrt(NUM)


def test_a_taste_changes_after_some_scores_and_two_people_take_turns():
    scores = np.array([[10.0, 50.0, 90.0]] * 4)
    numbers = np.array([CHANGE, 1, CHANGE - 1, 200])
    said_by = {name: RESPONDENTS[name].spoken(scores, numbers).tolist() for name in ("exact", "changing", "two")}
    assert said_by["exact"] == scores.tolist()
    assert said_by["changing"] == [[90.0], [10.0], [10.0], [90.0]]
    assert said_by["two"] == [[10.0], [90.0], [90.0], [10.0]]
    assert RESPONDENTS["changing_sd10"].taste(scores).tolist() == [[90.0]] * 4
    assert RESPONDENTS["two_sd10"].taste(scores).tolist() == [[50.0]] * 4
    assert RESPONDENTS["sd10"].taste(scores) is scores
