"""Lines of points: the likelihood of sums, the evidence of columns, and predictions over all that may be true."""

import itertools

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from grammarlab.preference.judge.unexplained_scores import UnexplainedScores
from grammarlab.preference.lines import line_preference
from grammarlab.preference.lines.distinct import Distinct
from grammarlab.preference.lines.fitted_line import POINTS, SOFTNESS, fitted
from grammarlab.preference.lines.line_preference import best_line
from grammarlab.preference.lines.line_scores import LineScores, clipped
from grammarlab.preference.lines.points_search import LineSearch
from grammarlab.preference.person import Person


def coins(num, width, seed):
    return np.random.default_rng(seed).integers(0, 2, (num, width)).astype(float)


@pytest.mark.parametrize(("mean", "deviation"), [(-20.0, 15.0), (3.0, 8.0), (60.0, 30.0), (140.0, 25.0), (50.0, 0.2)])
def test_values_are_expected_clipped_sums(mean, deviation):
    def integrand(sum_):
        return np.clip(sum_, 0.0, 100.0) * norm.pdf(sum_, mean, deviation)

    edges = [mean - 12.0 * deviation, *sorted({0.0, 100.0, mean}), mean + 12.0 * deviation]
    inside = np.clip(edges, edges[0], edges[-1])
    expected = sum(quad(integrand, low, high)[0] for low, high in itertools.pairwise(inside))
    value, slope = clipped(np.array([mean]), np.array([deviation]))
    assert value[0] == pytest.approx(expected, abs=1e-6)
    step = 1e-4 * deviation
    around = clipped(np.array([mean - step, mean + step]), np.full(2, deviation))[0]
    assert slope[0] == pytest.approx((around[1] - around[0]) / (2.0 * step), abs=1e-5)


def test_slopes_are_derivatives_of_the_likelihood():
    scores = LineScores(np.array([0.0, 37.0, 62.0, 100.0]), Person(9.0, 0.03))
    sums = np.array([8.6, 44.6, 48.6, 91.6])  # in the middle of a point, where the table is straight
    slopes = scores.slopes(sums, SOFTNESS)
    for index in range(4):
        away = np.zeros(4)
        away[index] = 0.01
        ends = [scores.slopes(sums + sign * away, SOFTNESS).log_likelihood for sign in (-1.0, 1.0)]
        assert slopes.first[index] == pytest.approx((ends[1] - ends[0]) / 0.02, abs=1e-6)
    assert slopes.curvature.max() <= 1.0 / 81.0
    # A score that is probably a blunder says little about points.
    assert scores.slopes(np.array([8.6, 90.0, 48.6, 91.6]), SOFTNESS).curvature[1] < 0.1 * slopes.curvature[1]


def test_the_evidence_of_columns_is_an_integral_over_points():
    rows = coins(40, 1, 0)
    table = (rows - rows.mean()) / rows.std()
    given = np.clip(40.0 + 25.0 * rows[:, 0] + 8.0 * np.random.default_rng(1).normal(size=40), 0.0, 100.0).round()
    scores = LineScores(given, Person(7.5, 0.002))
    middles, points = np.linspace(40.0, 65.0, 61), np.linspace(0.0, 25.0, 61)
    prior = norm.logpdf(middles, 50.0, 50.0)[:, None] + norm.logpdf(points, 0.0, POINTS)
    likelihood = [
        [scores.slopes(middle + point * table[:, 0], SOFTNESS).log_likelihood for point in points] for middle in middles
    ]
    both = np.array(likelihood) + prior
    cell = (middles[1] - middles[0]) * (points[1] - points[0])
    expected = both.max() + np.log(np.exp(both - both.max()).sum() * cell)
    line = fitted(table, (0,), scores, np.array([50.0, 0.0]), wide=True)
    assert line.log_evidence == pytest.approx(expected, abs=0.1)
    posterior = np.exp(both - both.max())
    posterior /= posterior.sum()
    assert line.points == pytest.approx([posterior.sum(axis=1) @ middles, posterior.sum(axis=0) @ points], abs=0.3)
    variances = np.diag(np.linalg.inv(line.precision))
    assert variances[1] == pytest.approx(posterior.sum(axis=0) @ (points - line.points[1]) ** 2, rel=0.1)


@pytest.mark.parametrize("noise", [0.0, 10.0])
def test_points_add_up_and_clipping_is_seen_through(noise):
    rows, randomness = coins(120, 40, 3), np.random.default_rng(4)
    sums = rows[:, [3, 8, 20]] @ [50.0, 60.0, 40.0] - 40.0
    scores = np.clip(np.clip(sums, 0.0, 100.0) + noise * randomness.normal(size=120), 0.0, 100.0).round()
    prices = np.full(40, np.log(40.0))
    assert set(best_line(rows, prices, scores).columns) == {3, 8, 20}
    # Without a pattern, any distribution of values is more likely than points.
    nothing = UnexplainedScores.of(scores)
    shuffled = best_line(rows, prices, scores[randomness.permutation(len(scores))])
    assert shuffled.total < nothing.log_evidence(nothing.members.sum(axis=0)[None])[0]


def test_the_best_of_all_small_lines_is_found():
    rows = coins(60, 7, 5)
    scores = np.clip(
        20.0 + 30.0 * rows[:, 1] - 25.0 * rows[:, 4] + 7.0 * np.random.default_rng(6).normal(size=60), 0, 100
    )
    distinct = Distinct.of(rows)
    search = LineSearch(distinct.table(rows), np.full(7, np.log(7.0)), scores.round())
    search.run()
    person = search.best.scores
    sets = [tuple(np.flatnonzero([number >> bit & 1 for bit in range(7)]).tolist()) for number in range(128)]
    every = [fitted(search.table, terms, person, np.append(30.0, np.zeros(len(terms))), wide=True) for terms in sets]
    assert set(search.best.terms) == set(max(every, key=search.total).terms) == {1, 4}


@pytest.mark.parametrize(("num", "seed"), [(48, 5042), (48, 5054), (96, 5012)])
def test_exact_scores_far_from_the_middle_have_the_line_that_they_were_made_of(num, seed):
    rows = np.random.default_rng(seed).integers(0, 3, (num, 8)).astype(float)
    distinct = Distinct.of(rows)
    # Many sums are beyond an end, where a score says hardly anything about points that are near to wrong ones.
    truth = np.array([(10.0, 50.0, 90.0)[(seed - 5000) % 3], 40.0, -25.0])
    scores = np.clip(truth[0] + distinct.table(rows)[:, :2] @ truth[1:], 0.0, 100.0).round()
    search = LineSearch(distinct.table(rows), np.full(8, 3.0), scores)
    search.run()
    made_of = fitted(search.table, (0, 1), search.best.scores, truth)
    assert set(search.best.terms) == {0, 1}
    # The likelihood of an exact score has bends, where steps end.
    assert search.total(search.best) > search.total(made_of) - 1.0


def test_predictions_are_means_over_lines_and_say_how_sure_they_are():
    rows, fresh = coins(80, 12, 7), coins(300, 12, 8)

    def wanted(some):
        return np.clip(some[:, [0, 2, 5, 9]] @ [35.0, 25.0, 20.0, -30.0] + 15.0, 0.0, 100.0)

    scores = np.clip(wanted(rows) + 8.0 * np.random.default_rng(9).normal(size=80), 0.0, 100.0).round()
    found = line_preference.fit(rows, scores, np.arange(12))
    assert found.shares.sum() == pytest.approx(1.0)
    assert set(found.columns) == {0, 2, 5, 9}
    predicted = found.predict(fresh)
    assert np.abs(predicted.mean - wanted(fresh)).mean() < 4.0
    assert predicted.std.min() > 0.8 * found.noise
    drawn = found.draws(fresh, 400, np.random.default_rng(10))
    assert np.abs(drawn.mean(axis=0) - predicted.mean).max() < 3.0
    names = [entry.name for entry in found.explain([f"c{index}" for index in range(12)])[:4]]
    assert set(names) == {"c0", "c2", "c5", "c9"}


def test_columns_that_say_the_same_count_once():
    rows = coins(50, 3, 11)
    doubled = np.column_stack([np.ones(50), rows[:, 0], 1.0 - rows[:, 0], 3.0 * rows[:, 1], rows])
    assert Distinct.of(doubled).columns.tolist() == [1, 3, 6]


def test_the_order_of_labels_changes_nothing_that_counts():
    rows = coins(64, 9, 12)
    scores = (20.0 + 40.0 * rows[:, 2] + 25.0 * rows[:, 7]).round()
    order = np.random.default_rng(13).permutation(64)
    first, second = (
        line_preference.fit(rows, scores, np.arange(9)),
        line_preference.fit(rows[order], scores[order], np.arange(9)),
    )
    assert first.columns == second.columns
    assert first.log_evidence == pytest.approx(second.log_evidence, abs=1e-6)
    assert first.predict(rows).mean == pytest.approx(second.predict(rows).mean, abs=1e-6)


def test_some_labels_know_the_points_of_the_same_columns_less():
    rows = coins(60, 6, 14)
    scores = np.clip(30.0 + 50.0 * rows[:, 3] + 8.0 * np.random.default_rng(15).normal(size=60), 0.0, 100.0).round()
    found = line_preference.fit(rows, scores, np.arange(6))
    some = found.without(rows[:20], scores[:20])
    assert [line.terms for line in some.lines] == [line.terms for line in found.lines]
    (more, few), table = (found.lines[0], some.lines[0]), found.distinct.table(rows)
    assert (few.sums(table)[1] > 1.5 * more.sums(table)[1]).all()
    assert np.abs(some.predict(rows).mean - found.predict(rows).mean).max() < 10.0


@pytest.mark.parametrize("scores", [np.zeros(12), np.full(12, 100.0), np.full(12, 40.0)])
def test_equal_scores_have_no_terms(scores):
    found = line_preference.fit(coins(12, 5, 15), scores, np.arange(5))
    assert found.columns == ()
    assert found.predict(coins(4, 5, 16)).mean == pytest.approx(np.full(4, scores[0]), abs=3.0)
