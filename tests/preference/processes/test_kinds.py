"""Labels of several kinds: likelihoods that are certain, posteriors beside quadrature, and what is learned."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import multivariate_normal, norm

from grammarlab.errors import UsageError
from grammarlab.learning.fitting import fit
from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.preference import blended, mixed
from grammarlab.preference.labels import Kind
from grammarlab.preference.person import (
    DISLIKED,
    START_BLUNDERS,
    TIE_DIFFERENCE,
    intervals_of,
    log_likelihood,
    matched,
)
from grammarlab.preference.processes.label_kinds import (
    Judgements,
    judgements_of,
    label_observations,
    middle_of,
    propagate,
)
from grammarlab.preference.processes.posterior import Hyperparameters, condition
from tests.cases import takes_turns

ERRING = [(0.5, 0.0), (3.0, 0.1), (20.0, 0.002)]
STARS = np.array([0.0, 25.0, 50.0, 75.0, 100.0])


def many(kind: Kind, number: int) -> list[Kind]:
    return [kind] * number


def judged(kinds, scores):
    """Labels of the rows 0, 1, ..., each compared with the row 9."""
    rows = np.arange(float(len(kinds)))[:, None]
    return judgements_of(rows, np.array(scores), kinds, np.full((len(kinds), 1), 9.0))


def said(kinds, scores, middle=50.0):
    return judged(kinds, scores).intervals(middle)


@pytest.mark.parametrize(("noise", "blunders"), ERRING)
@pytest.mark.parametrize(
    "answers",
    [
        said(many("stars", 5), STARS),
        said(many("thumb", 2), [0.0, 100.0], middle=30.0),
        said(["rather"], [100.0]) + intervals_of(np.zeros(0)),
    ],
)
def test_one_of_the_answers_to_a_question_is_given(answers, noise, blunders):
    values = np.array([-40.0, 0.0, 12.5, 31.0, 100.0])
    found = np.exp(log_likelihood(answers, values, noise, blunders).astype(float)).sum(axis=0)
    if len(answers) == 1:  # the other answer is the same about the other side
        found += np.exp(log_likelihood(answers, -values, noise, blunders).astype(float))[0]
    np.testing.assert_allclose(found, 1.0, atol=1e-6)


@pytest.mark.parametrize(("noise", "blunders"), ERRING)
def test_rather_the_other_way_round_and_alike_are_certain_together(noise, blunders):
    answers = said(["rather", "tie"], [100.0, 50.0])
    differences = np.array([-30.0, 0.0, 4.0, 60.0])
    one_way, alike = np.exp(log_likelihood(answers, differences, noise, blunders).astype(float))
    other_way = np.exp(log_likelihood(answers, -differences, noise, blunders).astype(float))[0]
    np.testing.assert_allclose(one_way + alike + other_way, 1.0, atol=1e-6)


def test_a_preference_between_two_is_a_probit_of_their_difference():
    found = np.exp(log_likelihood(said(["rather"], [100.0]), np.array([7.0]), 10.0, 0.1)[0, 0])
    assert found == pytest.approx(0.9 * norm.cdf(7.0 / (np.sqrt(2.0) * 10.0)) + 0.05, rel=1e-6)


def test_scores_of_one_point_are_as_before():
    scores, values = np.array([0.0, 0.3, 40.0, 99.9, 100.0]), np.linspace(0.0, 100.0, 21)
    for noise, blunders in ERRING:
        low = np.where(scores <= 0.25, -np.inf, scores - 0.5)[:, None]
        high = np.where(scores >= 99.75, np.inf, scores + 0.5)[:, None]
        length = np.where((scores <= 0.25) | (scores >= 99.75), 0.5, 1.0)[:, None]
        mass = norm.cdf((high - values) / noise) - norm.cdf((low - values) / noise)
        expected = np.log((1.0 - blunders) * mass + blunders * length / 100.0 + 1e-12)
        np.testing.assert_allclose(log_likelihood(scores, values, noise, blunders), expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize(("noise", "blunders"), ERRING)
@pytest.mark.parametrize("bounds", [(-np.inf, 20.0), (62.5, 87.5), (55.0, np.inf)])
def test_a_normal_value_after_one_answer_is_as_quadrature_has_it(bounds, noise, blunders):
    answers = said(["thumb"], [100.0])
    answers.low[:], answers.high[:] = bounds
    mean, variance = 48.0, 150.0

    def moment(power):
        def density(v):
            mass = norm.cdf((bounds[1] - v) / noise) - norm.cdf((bounds[0] - v) / noise)
            return ((1.0 - blunders) * mass + blunders / 2.0) * norm.pdf(v, mean, np.sqrt(variance)) * v**power

        points = [bound for bound in bounds if np.isfinite(bound)]
        return quad(density, mean - 120.0, mean + 120.0, points=points, limit=400)[0]

    evidence, first, second = (moment(power) for power in range(3))
    found = matched(answers, np.array([mean]), np.array([variance]), noise, blunders)
    assert found[0][0] == pytest.approx(np.log(evidence), abs=1e-6)
    assert found[1][0] == pytest.approx(first / evidence, rel=1e-6)
    assert found[2][0] == pytest.approx(second / evidence - (first / evidence) ** 2, rel=1e-5)


def textbook(prior_mean, prior, likelihood):
    """Mean and covariance of two values by quadrature on a fine grid."""
    steps = np.linspace(-160.0, 240.0, 1601)
    a, b = np.meshgrid(steps, steps, indexing="ij")
    mass = likelihood(a, b) * multivariate_normal(prior_mean, prior).pdf(np.stack([a, b], axis=-1))
    mass /= mass.sum()
    mean = np.array([(mass * a).sum(), (mass * b).sum()])
    away = np.stack([a - mean[0], b - mean[1]])
    return mean, np.einsum("iab,jab,ab->ij", away, away, mass)


def test_one_comparison_of_two_like_models_gives_the_textbook_posterior():
    hyperparameters = Hyperparameters(900.0, np.array([0.5]), 64.0)
    rows = np.array([[0.0], [1.0]])
    judgements = judgements_of(rows[:1], [100.0], ["rather"], rows[1:])
    found = label_observations(judgements, hyperparameters, 50.0)
    posterior = condition(hyperparameters, found.observations)
    shared = 900.0 * np.exp(-0.25)
    mean, covariance = textbook(
        [0.0, 0.0],
        [[900.0, shared], [shared, 900.0]],
        lambda a, b: (1.0 - START_BLUNDERS) * norm.cdf((a - b) / (np.sqrt(2.0) * 8.0)) + START_BLUNDERS / 2.0,
    )
    told = posterior.predict(rows)
    np.testing.assert_allclose(told.mean + posterior.level, mean, atol=0.05)
    np.testing.assert_allclose(told.std**2 - 64.0, np.diagonal(covariance), rtol=0.01)


def test_what_a_comparison_says_of_one_side_knows_the_other_side_without_it():
    hyperparameters = Hyperparameters(900.0, np.array([50.0]), 64.0)
    rows = np.array([[0.0], [1.0]])
    # The second model has a score, the first one none: before the comparison they have nothing in common.
    judgements = judgements_of(
        np.array([[1.0], [0.0]]), [40.0, 100.0], ["score", "rather"], np.concatenate([rows[1:], rows[1:]])
    )
    found = label_observations(judgements, hyperparameters, 50.0)
    known = 40.0 * 900.0 / (900.0 + 64.0)
    assert found.intervals.low[1] == pytest.approx(known, abs=1e-6)
    assert found.intervals.variance[1] == pytest.approx(900.0 * 64.0 / (900.0 + 64.0), rel=1e-6)
    assert found.intervals.high[2] == pytest.approx(0.0, abs=1e-6)
    assert found.intervals.variance[2] == pytest.approx(900.0, rel=1e-6)
    np.testing.assert_array_equal(found.rows[:, 0], [1.0, 0.0, 1.0])


def test_sites_of_several_comparisons_come_near_to_quadrature():
    prior = np.array([[400.0, 120.0], [120.0, 300.0]])
    answers = said(["thumb", "thumb"], [100.0, 0.0], middle=50.0)
    found = propagate(np.array([45.0, 55.0]), prior, answers, 6.0, 0.0)
    mean, covariance = textbook(
        [45.0, 55.0], prior, lambda a, b: norm.cdf((a - 50.0) / 6.0) * norm.cdf((50.0 - b) / 6.0)
    )
    np.testing.assert_allclose(found.mean, mean, atol=0.3)
    np.testing.assert_allclose(found.covariance, covariance, rtol=0.05)


def coins(number, width, seed):
    return np.random.default_rng(seed).integers(0, 2, (number, width)).astype(float)


def liked(rows):
    return 80.0 * rows[:, 0] * rows[:, 1]


def compared(number, width, seed):
    """Rows, kinds, scores and others of comparisons that somebody without noise makes."""
    rows, others = coins(number, width, seed), coins(number, width, seed + 100)
    turned = liked(rows) < liked(others)
    rows[turned], others[turned] = others[turned], rows[turned].copy()
    tied = np.abs(liked(rows) - liked(others)) < TIE_DIFFERENCE
    kinds: list[Kind] = ["tie" if alike else "rather" for alike in tied]
    return rows, np.where(tied, 50.0, 100.0), kinds, others


@takes_turns
def test_comparisons_and_few_scores_teach_as_scores_do():
    rows, scores, kinds, others = compared(100, 6, 0)
    known, fresh = coins(4, 6, 5), coins(200, 6, 6)
    found = fit(
        np.concatenate([known, rows]),
        np.concatenate([liked(known), scores]),
        kinds=many("score", 4) + kinds,
        others=np.concatenate([known, others]),
    )
    few = blended.fit(known, liked(known))
    missed = [np.abs(part.predict(fresh).mean - liked(fresh)).mean() for part in (found, few)]
    assert missed[0] < 4.0 < missed[1]


def test_comparisons_alone_put_models_in_order():
    rows, scores, kinds, others = compared(80, 5, 1)
    told = fit(rows, scores, kinds=kinds, others=others).predict(coins(200, 5, 7)).mean
    wanted = liked(coins(200, 5, 7)) > 0.0
    assert told[wanted].min() > told[~wanted].max()


def learned_from_comparisons(value_of, number, width, seed):
    """What random comparisons with a noise of 10 points teach of fresh designs, and their values."""
    randomness = np.random.default_rng(seed)
    rows, errors = randomness.integers(0, 3, (number, width)).astype(float), randomness.normal(0.0, 10.0, number)
    fresh = randomness.integers(0, 3, (2000, width)).astype(float)
    others, other_errors = (
        randomness.integers(0, 3, (number, width)).astype(float),
        randomness.normal(0.0, 10.0, number),
    )
    turned = value_of(rows) + errors < value_of(others) + other_errors
    rows[turned], others[turned] = others[turned], rows[turned].copy()
    of_grammar = fresh, np.ones(len(fresh))
    preference = fit(rows, [100.0] * number, kinds=many("rather", number), others=others, designs=of_grammar)
    return preference.predict(fresh).mean, value_of(fresh)


@pytest.mark.parametrize(("seed", "number"), [(0, 384), (2, 256), (0, 800)])
def test_many_comparisons_alone_find_the_level_of_disliked_designs(seed, number):
    told, wanted = learned_from_comparisons(lambda r: 100.0 * ((r[:, 0] > 0.0) & (r[:, 3] > 1.0)), number, 30, seed)
    assert jensen_shannon(told, wanted) < 0.25 * jensen_shannon(np.ones(len(told)), wanted)


@pytest.mark.parametrize("seed", range(5))
def test_comparisons_of_graded_values_are_never_worse_than_the_grammar(seed):
    told, wanted = learned_from_comparisons(
        lambda r: np.clip(20.0 * r[:, 1] + 15.0 * r[:, 4] - 10.0, 0.0, 100.0), 96, 12, seed
    )
    assert jensen_shannon(told, wanted) < jensen_shannon(np.ones(len(told)), wanted)


def test_the_level_that_comparisons_leave_open_is_that_of_the_prior():
    rows, _, _, others = compared(30, 4, 3)
    judgements = judgements_of(rows, [100.0] * 30, many("rather", 30), others)
    kernel = Hyperparameters(900.0, np.array([0.04, 0.02, 0.3, 0.0]), 9.0)
    found = label_observations(judgements, kernel, 50.0)
    posterior = condition(kernel, found.observations)
    assert np.quantile(posterior.predict(found.observations.all_rows).mean, DISLIKED) == pytest.approx(0.0, abs=1e-9)
    # Differences are as they were.
    fresh = coins(9, 4, 4)
    by_formula = posterior.covariance_with_observed(fresh) @ posterior.solution
    np.testing.assert_allclose(np.ptp(posterior.predict(fresh).mean - by_formula), 0.0, atol=1e-9)
    # One score says where the level is.
    scored = np.append([80.0], [100.0] * 30)
    kinds: list[Kind] = [*many("score", 1), *many("rather", 30)]
    known = judgements_of(np.vstack([rows[:1], rows]), scored, kinds, np.vstack([rows[:1], others]))
    assert condition(kernel, label_observations(known, kernel, 50.0).observations).level == 0.0


@pytest.mark.parametrize("kind", ["stars", "thumb"])
def test_coarse_scales_teach(kind):
    rows, fresh = coins(90, 6, 2), coins(200, 6, 3)
    said = np.round(liked(rows) / 25.0) * 25.0 if kind == "stars" else np.where(liked(rows) > 50.0, 100.0, 0.0)
    told = fit(rows, said, kinds=many(kind, 90), others=rows).predict(fresh).mean
    wanted = liked(fresh) > 0.0
    assert told[wanted].min() > 55.0
    assert told[~wanted].max() < 25.0


def test_the_middle_of_a_person_is_found_where_thumbs_turn():
    rows = np.arange(0.0, 1.01, 0.02)[:, None]
    values = 100.0 * rows[:, 0]
    thumbs = np.where(values > 70.0, 100.0, 0.0)
    kinds = many("score", 51) + many("thumb", 51)
    judgements = judgements_of(np.tile(rows, (2, 1)), np.concatenate([values, thumbs]), kinds, [[0.0]] * 102)
    assert middle_of(judgements, Hyperparameters(2000.0, np.array([4.0]), 4.0)) == pytest.approx(70.0, abs=5.0)


@pytest.mark.parametrize("away", [10.0, 25.0, 40.0])
def test_thumbs_of_symmetric_scores_turn_in_the_middle(away):
    rows, sides = np.array([[0.0], [1.0]] * 2), np.array([-1.0, 1.0])
    answers = np.concatenate([50.0 + away * sides, 50.0 + 50.0 * sides])
    judgements = judgements_of(rows, answers, many("score", 2) + many("thumb", 2), [[0.0]] * 4)
    assert middle_of(judgements, Hyperparameters(2000.0, np.array([4.0]), 4.0)) == 50.0


def test_the_order_of_labels_of_all_kinds_does_not_matter():
    rows, scores, kinds, others = compared(20, 4, 4)
    kinds[:3] = ["score", "stars", "thumb"]
    scores = np.append([33.0, 50.0, 100.0], scores[3:])
    order = np.random.default_rng(0).permutation(20)
    one = mixed.fit(rows, scores, kinds=kinds, others=others)
    two = mixed.fit(rows[order], scores[order], kinds=[kinds[i] for i in order], others=others[order])
    np.testing.assert_array_equal(one.predict(rows).mean, two.predict(rows).mean)


def test_of_many_labels_an_even_selection_counts(monkeypatch):
    rows, scores, kinds, others = compared(60, 6, 4)
    kinds[:20] = [*many("score", 10), *many("stars", 10)]
    scores[:20] = np.repeat([0.0, 25.0, 75.0, 100.0], 5)
    every = judgements_of(rows, scores, kinds, others)
    assert every.thinned(60) is every
    some = every.thinned(24)
    listed = [
        [(*rows[a], *(rows[b] if b >= 0 else ()), kind, score) for a, b, kind, score in zip(*labels, strict=True)]
        for part in (some, every)
        for rows, labels in [(part.rows, (part.first, part.second, part.kinds, part.scores))]
    ]
    assert set(listed[0]) <= set(listed[1])
    assert len(some.scores) == 24
    np.testing.assert_allclose(
        np.quantile(some.scores, [0.2, 0.5, 0.8]), np.quantile(scores, [0.2, 0.5, 0.8]), atol=25.0
    )
    np.testing.assert_array_equal(
        np.unique(np.append(some.first, some.second[some.second >= 0])), range(len(some.rows))
    )
    order = np.random.default_rng(0).permutation(60)
    turned = judgements_of(rows[order], scores[order], [kinds[i] for i in order], others[order]).thinned(24)
    np.testing.assert_array_equal(turned.rows, some.rows)
    monkeypatch.setattr(mixed, "BATCH", 24)
    preference = mixed.fit(rows, scores, kinds=kinds, others=others)
    assert preference.process.observations.counts.sum() == 24.0
    assert np.isfinite(preference.predict(rows).mean).all()


def test_scores_alone_are_learned_from_to_the_last_bit_as_ever():
    rows = coins(40, 5, 8)
    one, two = fit(rows, liked(rows)), fit(rows, liked(rows), kinds=many("score", 40), others=rows)
    np.testing.assert_array_equal(one.predict(rows).mean, two.predict(rows).mean)


@pytest.mark.parametrize("kind", ["rather", "tie", "stars", "thumb"])
def test_one_label_of_any_kind_is_enough(kind):
    score = {"tie": 50.0}.get(kind, 100.0)
    told = fit([[0.0, 1.0]], [score], kinds=[kind], others=[[1.0, 1.0]]).predict([[0.0, 1.0], [5.0, 5.0]])
    assert np.isfinite(told.mean).all()
    assert np.isfinite(told.std).all()


def test_contradictions_of_comparisons_are_noise():
    rows = np.repeat([[0.0], [1.0]], 12, axis=0)
    told = fit(rows, [100.0] * 24, kinds=many("rather", 24), others=1.0 - rows).predict([[0.0], [1.0]])
    assert abs(told.mean[0] - told.mean[1]) < 5.0


def test_other_methods_refuse_comparisons():
    with pytest.raises(UsageError, match="'kde' learns only from scores; use 'blended'"):
        fit([[0.0]], [100.0], kinds=["rather"], others=[[1.0]], method="kde")


def test_tables_of_other_sizes_are_refused():
    with pytest.raises(UsageError, match="expected one kind and one row of 1 columns for each of 1 labels"):
        fit([[0.0]], [100.0], kinds=["rather"], others=[[1.0, 2.0]])


def test_stars_are_half_a_step_wide():
    answers = said(many("stars", 5), STARS)
    np.testing.assert_allclose(answers.low[1:], (STARS[1:] + STARS[:-1]) / 2.0)
    np.testing.assert_allclose(answers.high[:-1], (STARS[1:] + STARS[:-1]) / 2.0)
    assert isinstance(judged(["stars"], [0.0]), Judgements)
