"""Blends: whichever part predicts held-out scores, and what noise does to means."""

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.learning.fitting import fit
from grammarlab.preference import blended
from grammarlab.preference.cells import partition
from grammarlab.preference.factors import ProductPreference
from grammarlab.preference.held_out_share import Fitted, held_out
from grammarlab.preference.lines import line_preference
from grammarlab.preference.person import value_of
from grammarlab.preference.processes import grouped
from tests.cases import some, takes_turns


def coins(number, width, seed):
    return np.random.default_rng(seed).integers(0, 2, (number, width)).astype(float)


def wanted(name, rows):
    if name == "sum":
        return rows[:, :5] @ np.array([30.0, 25.0, 20.0, 15.0, 10.0])
    return 80.0 * rows[:, 0] * rows[:, 1] * rows[:, 2]


@takes_turns
@pytest.mark.parametrize(("name", "noise"), [("sum", 0.0), ("all three", 0.0), ("all three", 10.0)])
def test_a_blend_is_about_as_good_as_the_better_part(name, noise):
    rows, fresh = coins(80, 10, 0), coins(200, 10, 1)
    given = np.clip(wanted(name, rows) + noise * np.random.default_rng(2).normal(size=80), 0.0, 100.0)
    found = blended.fit(rows, given)
    missed = [
        np.abs(np.clip(part.predict(fresh).mean, 0.0, 100.0) - wanted(name, fresh)).mean()
        for part in (found, found.process, found.partition)
    ]
    assert missed[0] <= 1.5 * min(missed[1:]) + 1.0


@takes_turns
def test_what_adds_up_is_left_to_lines_and_to_the_process():
    rows = coins(80, 10, 3)
    found = blended.fit(rows, wanted("sum", rows))
    # Trees of many cells explain exact sums as well, but for less of them.
    assert found.line_share + (1.0 - found.line_share) * found.share >= 0.75
    assert found.share >= 0.5
    assert found.line_share > 0.2
    given = np.clip(wanted("sum", rows) + 10.0 * np.random.default_rng(2).normal(size=80), 0.0, 100.0)
    assert blended.fit(rows, given).line_share > 0.3
    assert blended.fit(rows, wanted("all three", rows)).line_share < 0.05


@pytest.mark.parametrize("seed", some(range(3)))
def test_what_is_smooth_is_left_to_the_process_although_scores_have_errors(seed):
    randomness = np.random.default_rng(seed)
    rows, fresh = randomness.random((48, 8)), randomness.random((300, 8))

    def smooth(some):
        return 90.0 * np.exp(-8.0 * ((some[:, 0] - 0.5) ** 2 + (some[:, 1] - 0.4) ** 2))

    given = np.clip(smooth(rows) + 8.0 * randomness.normal(size=48), 0.0, 100.0)
    found = blended.fit(rows, given, continuous=np.ones(8, dtype=bool))
    missed = [np.abs(part.predict(fresh).mean - smooth(fresh)).mean() for part in (found, found.partition)]
    assert found.share >= 0.25
    assert missed[0] < missed[1]


def test_predictions_are_scores():
    rows = coins(60, 10, 4)
    told = blended.fit(rows, 100.0 * rows[:, 0]).predict(coins(500, 10, 5))
    assert told.mean.min() >= 0.0
    assert told.mean.max() <= 100.0


@takes_turns
def test_noise_that_a_process_explains_by_many_draws_is_noise():
    randomness = np.random.default_rng(9)
    draws = randomness.random((48, 40))
    rows = np.column_stack([coins(48, 8, 9), draws])
    given = np.clip(70.0 * rows[:, 0] * rows[:, 1] + 10.0 * randomness.normal(size=48), 0.0, 100.0)
    found = blended.fit(rows, given, continuous=np.arange(48) >= 8)
    assert 5.0 < found.noise < 20.0


def test_cells_that_like_no_scored_design_have_no_share():
    rows, scores = coins(20, 6, 1), np.zeros(20)
    scores[12] = 67.0
    process, cells = grouped.fit(rows, scores), partition.fit(rows, scores)
    assert cells.predict(rows).mean.max() < 1.0
    parts = Fitted(process, cells, line_preference.fit(rows, scores, np.arange(6)))
    assert held_out(rows, scores, np.zeros(6, dtype=bool), 0, parts, 0.0).share == 1.0
    assert blended.fit(rows, 80.0 * rows[:, 0]).share < 1.0


def test_few_scores_that_two_columns_explain_are_believed_and_a_few_less_are_not():
    rows = coins(40, 4, 6)
    scores = 40.0 * rows[:, 0] + 30.0 * rows[:, 1]
    kept = [blended.fit(rows[:num], scores[:num]).unexplained for num in (1, 4, 24, 40)]
    assert kept == sorted(kept, reverse=True)
    assert (kept[0], kept[-1]) == (1.0, 0.0)


def test_parts_are_explained_by_name():
    rows = coins(120, 6, 7)
    found = blended.fit(rows, 90.0 * rows[:, 4]).explain([f"part {n}" for n in range(6)])
    assert found[0].name == "part 4"
    assert len(found) == 6


def test_groups_of_one_name_are_told_apart():
    rows = coins(60, 3, 8)
    found = blended.fit(rows, 90.0 * rows[:, 2]).explain(["part", "part", "part"])
    assert len(found) == 3
    assert found[0].share > 0.1 > found[1].share


def test_a_flag_for_each_column_is_asked_for():
    with pytest.raises(UsageError, match="one flag for each of the 3 columns"):
        blended.fit(coins(5, 3, 9), [1.0] * 5, continuous=[True])


@pytest.fixture(scope="module")
def rare_and_liked():
    """Designs, of which one in 64 is liked, and what was learned from scores with errors of 48 of them."""
    rows = coins(1000, 8, 8)
    rare = rows[:, :6].min(axis=1)
    asked = np.concatenate([np.flatnonzero(rare)[:8], np.arange(40)])
    given = np.clip(90.0 * rare[asked] + 10.0 * np.random.default_rng(3).normal(size=48), 0.0, 100.0)
    return rows, blended.fit(rows[asked], given)


@pytest.mark.parametrize("unexplained", [0.0, 0.4, 1.0])
def test_a_density_is_a_mixture_of_the_densities_of_its_parts(unexplained, rare_and_liked):
    rows, learned = rare_and_liked
    weights = np.random.default_rng(4).random(1000)
    found = replace(learned, share=0.2, handed=0.05, line_share=0.3, unexplained=unexplained)
    assert found.line is not None
    mixed = found.for_density(rows, weights)
    cells, process = found.partition.for_density(rows, weights).predict(rows).mean, found.predict_values(rows).mean
    odds = (0.15 * min(1.0, (weights @ cells) / (weights @ process)) ** 7 + 0.05) / 0.8
    explained = 0.7 * (1.0 - unexplained) / (1.0 + odds)
    shares = odds * explained, explained, 0.3 * (1.0 - unexplained), unexplained
    line = found.line.predict(rows).mean
    densities = [weights * part / (weights @ part) for part in (process, cells, line, np.ones(1000))]
    learned = weights * mixed.predict(rows).mean
    np.testing.assert_allclose(learned / learned.sum(), np.array(shares) @ densities, rtol=1e-9, atol=1e-12)
    # The highest value is that of the mixture of values.
    plain = replace(found, partition=found.partition.for_density(rows, weights))
    assert mixed.predict(rows).mean.max() == pytest.approx(plain.predict(rows).mean.max())
    np.testing.assert_allclose(mixed.predict(rows).std, plain.predict(rows).std)


def test_a_part_that_likes_none_of_the_designs_has_no_share_of_them():
    rows = coins(40, 4, 2)
    found = blended.fit(rows, 80.0 * rows[:, 0] * (0.5 + 0.5 * rows[:, 1]))
    some = replace(found, share=0.3, handed=0.0)
    for by_process, by_cells, share in ((0.0, 2.0, 0.0), (3.0, 0.0, 1.0), (2.0, 2.0, 0.3), (2.0, 3.0, 0.3)):
        assert some._damped(by_process, by_cells, found.partition) == pytest.approx(share)
    assert replace(some, handed=0.3)._damped(9.0, 3.0, found.partition) == pytest.approx(0.3)
    assert replace(found, share=1.0)._damped(3.0, 1.0, found.partition) == 1.0


def test_values_by_the_process_are_means_over_what_it_does_not_know():
    rows = coins(40, 4, 2)
    found = blended.fit(rows, np.clip(70.0 * rows[:, 0] + 9.0 * np.random.default_rng(5).normal(size=40), 0.0, 100.0))
    new = coins(6, 4, 3)
    known, variance = found.process.predict(new), found.process.noise_variance
    sd = np.sqrt(np.maximum(known.std**2 - variance, 0.0))
    draws = known.mean + sd * np.random.default_rng(6).normal(size=(40_000, 6))
    expected = value_of(draws, *found.person).mean(axis=0)
    np.testing.assert_allclose(found.predict_values(new).mean, expected, atol=0.15)


def test_a_fit_with_designs_is_the_density_over_them():
    rows, designs = coins(40, 6, 1), coins(300, 6, 2)
    scores, weights = 80.0 * rows[:, 0] * rows[:, 1], np.random.default_rng(0).random(300)
    learned = fit(rows, scores, designs=(designs, weights)).predict(designs)
    expected = blended.fit(rows, scores).for_density(designs, weights).predict(designs)
    np.testing.assert_array_equal(learned.mean, expected.mean)
    np.testing.assert_array_equal(learned.std, expected.std)
    assert isinstance(fit(rows, scores, method="grouped", designs=(designs, weights)), grouped.GroupedPreference)


def test_an_unexplained_factor_changes_no_product():
    rows = coins(60, 6, 3)
    known = blended.fit(rows, 80.0 * rows[:, 0]).for_density(rows, np.ones(60))
    unknown = replace(blended.fit(rows, 50.0 * rows[:, 1] + 50.0 * rows[:, 2]), unexplained=1.0)
    product = ProductPreference({"one": known, "other": unknown.for_density(rows, np.ones(60))})
    values, alone = product.predict(rows).mean, known.predict(rows).mean
    np.testing.assert_allclose(values / values.sum(), alone / alone.sum(), atol=1e-12)
    assert np.ptp(product.explaining.factors["other"].predict(rows).mean) > 20.0


def test_what_is_unexplained_depends_on_nothing():
    rows = coins(60, 3, 8)
    found = blended.fit(rows, 90.0 * rows[:, 2])
    shares = [
        max(entry.share for entry in replace(found, unexplained=kept).explain(["a", "b", "c"]))
        for kept in (0.0, 0.5, 1.0)
    ]
    assert shares == pytest.approx([shares[0], 0.5 * shares[0], 0.0])
    assert shares[0] > 0.1


def test_an_unexplained_preference_is_as_unsure_as_its_scores_differ():
    rows, scores = coins(200, 3, 8), np.repeat([20.0, 80.0], 100)
    prediction = replace(blended.fit(rows, scores), unexplained=1.0).predict(rows)
    np.testing.assert_allclose(prediction.mean, 50.0, atol=0.5)
    np.testing.assert_allclose(prediction.std, scores.std(), atol=2.0)


def test_few_equal_exact_scores_do_not_make_blunders_of_the_others():
    # Levels that are given again and again seem to prove cells of one value each, with the rest as blunders.
    scores = np.array([*[0.0] * 7, 24.9, 27.8, *[0.0] * 6, 60.6, 78.9, 80.2, 80.2, *[92.4] * 5])
    cell = np.repeat([0, 1, 2, 3], [9, 8, 2, 5])
    others = np.random.default_rng(2).random((24, 20)) < 0.3
    rows = np.column_stack([cell > 0, cell > 1, cell > 2, others]).astype(np.float64)
    means = blended.fit(rows, scores).partition.predict(rows).mean
    assert 5.0 < means[0] < 20.0
    assert 5.0 < means[9] < 20.0
    assert means[-1] == pytest.approx(92.4, abs=1.0)
