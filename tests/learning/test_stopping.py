"""The stopping sign: what is expected to be left falls with what is known, and with what is left."""

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.learning.answers import Answers
from grammarlab.learning.fitting import fit
from grammarlab.learning.round import init, step
from grammarlab.learning.stopping import draws, expected_divergence, expected_gain
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.preference import blended
from grammarlab.preference.cells import partition
from grammarlab.preference.factors import ProductPreference
from tests.cases import takes_turns
from tests.learning.bits import BitsSpace, score_of, study_of


def known(num, noise=0.0, seed=0, factors=1, **settings):
    space = BitsSpace()
    study = study_of(space, **settings)
    designs = study.tables().addresses[:num]
    scores = score_of(space.make(designs))
    errors = noise * np.random.default_rng(seed).normal(size=scores.shape)
    said = np.clip(scores + errors, 0.0, 100.0)
    answers = [Answers(f"factor {place}", designs, said[:, place]) for place in range(factors)]
    return study, step(study, init(study), answers)


def test_nothing_is_left_to_gain_where_everything_is_known():
    assert expected_gain(*known(96)) == pytest.approx(0.0, abs=1e-3)


@takes_turns
def test_more_is_left_to_gain_for_who_errs():
    exact, erring = expected_gain(*known(48)), expected_gain(*known(48, noise=25.0))
    assert exact is not None
    assert erring is not None
    assert 0.0 <= exact < erring < np.log(2.0)


@takes_turns
def test_no_gain_is_expected_of_scores_that_nothing_explains_yet():
    space = BitsSpace()
    study = study_of(space)
    designs = study.tables().addresses[:40]
    errors = np.clip(10.0 * np.random.default_rng(1).normal(size=40), 0.0, 100.0)
    assert expected_gain(study, step(study, init(study), [Answers("factor 0", designs, errors)])) is None
    same = expected_gain(study, step(study, init(study), [Answers("factor 0", designs, np.full(40, 60.0))]))
    assert same == pytest.approx(0.0, abs=1e-9)


@takes_turns
def test_a_gain_is_a_part_of_what_is_left_and_grows_with_the_scores():
    study, state = known(24, noise=20.0)
    left = expected_divergence(study, state)
    gains = [expected_gain(study, state, more) or 0.0 for more in (0, 16, 64, 10**6)]
    assert gains[0] == 0.0
    assert gains == sorted(gains)
    assert gains[-1] == pytest.approx(left, rel=1e-4)
    assert left


@takes_turns
def test_what_parts_of_the_scores_move_is_still_open():
    study, state = known(24)
    preference = state.preferences["factor 0"]
    assert isinstance(preference, blended.BlendedPreference)
    rows, weights = study.table(state).rows[: len(study.pool)], study.tables(state.wide).pool_designs.weights
    here = preference.predict(rows).mean
    far = fit(rows[:12], 100.0 - here[:12], method="blended")
    moved = replace(preference, sketches=(replace(preference, sketches=()), far))
    left = expected_divergence(study, replace(state, preferences={"factor 0": moved}))
    # Of 24 scores 12 were held out, and the other part is not moved at all.
    made = weights > 0.0
    one, other = (weights[made] * predicted.predict(rows[made]).mean for predicted in (far, preference))
    assert left == pytest.approx(jensen_shannon(one, other) * 12 / (24 - 12) / 2)


@takes_turns
def test_several_factors_are_looked_at_together():
    study, state = known(48, noise=15.0, factors=2)
    assert 0.0 < (expected_gain(study, state) or 0.0) < np.log(2.0)


def test_nothing_is_told_where_nothing_is_liked_or_known():
    study = study_of(BitsSpace())
    assert expected_gain(study, init(study)) is None
    assert expected_gain(*known(24, fit="kde")) is None


@pytest.mark.parametrize("name", ["blended", "partition"])
def test_draws_have_the_mean_and_deviation_of_predictions(name):
    randomness = np.random.default_rng(2)
    rows = randomness.integers(0, 2, (40, 5)).astype(float)
    scores = np.clip(50.0 + 30.0 * rows[:, 0] - 20.0 * rows[:, 1] + randomness.normal(0.0, 8.0, 40), 0.0, 100.0)
    found = (blended if name == "blended" else partition).fit(rows, scores)
    told, drawn = found.predict(rows), draws(found, rows, 600, np.random.default_rng(3))
    assert drawn is not None
    assert drawn.shape == (600, 40)
    assert drawn.min() >= 0.0
    assert drawn.max() <= 100.0
    # Explanations of a process count more alike in draws than in predictions.
    assert np.abs(drawn.mean(axis=0) - told.mean).max() < 5.0
    assert (drawn.std(axis=0) < told.std + 1.0).all()


def test_draws_of_a_product_are_products():
    rows = np.random.default_rng(4).integers(0, 2, (40, 4)).astype(float)
    one, other = (fit(rows, 100.0 * rows[:, place], method="partition") for place in (0, 1))
    found = draws(ProductPreference({"a": one, "b": other}), rows, 50, np.random.default_rng(5))
    assert found is not None
    assert np.abs(found - 100.0 * rows[:, 0] * rows[:, 1]).max() < 5.0
