"""Blends: whichever part predicts held-out scores, and what noise does to means."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from grammarlab.errors import UsageError
from grammarlab.preference import blended


def coins(number, width, seed):
    return np.random.default_rng(seed).integers(0, 2, (number, width)).astype(float)


def wanted(name, rows):
    if name == "sum":
        return rows[:, :5] @ np.array([30.0, 25.0, 20.0, 15.0, 10.0])
    return 80.0 * rows[:, 0] * rows[:, 1] * rows[:, 2]


@pytest.mark.parametrize(("name", "noise"), [("sum", 0.0), ("all three", 0.0), ("all three", 10.0)])
def test_a_blend_is_about_as_good_as_the_better_part(name, noise):
    rows, fresh = coins(140, 14, 0), coins(300, 14, 1)
    given = np.clip(wanted(name, rows) + noise * np.random.default_rng(2).normal(size=140), 0.0, 100.0)
    found = blended.fit(rows, given)
    missed = [
        np.abs(np.clip(part.predict(fresh).mean, 0.0, 100.0) - wanted(name, fresh)).mean()
        for part in (found, found.process, found.partition)
    ]
    assert missed[0] <= 1.5 * min(missed[1:]) + 1.0


def test_what_adds_up_is_left_to_the_process():
    rows = coins(140, 14, 3)
    assert blended.fit(rows, wanted("sum", rows)).share >= 0.75


@pytest.mark.parametrize("seed", range(3))
def test_what_is_smooth_is_left_to_the_process_although_scores_have_errors(seed):
    randomness = np.random.default_rng(seed)
    rows, fresh = randomness.random((48, 12)), randomness.random((300, 12))

    def smooth(some):
        return 90.0 * np.exp(-8.0 * ((some[:, 0] - 0.5) ** 2 + (some[:, 1] - 0.4) ** 2))

    given = np.clip(smooth(rows) + 8.0 * randomness.normal(size=48), 0.0, 100.0)
    found = blended.fit(rows, given, continuous=np.ones(12, dtype=bool))
    missed = [np.abs(part.predict(fresh).mean - smooth(fresh)).mean() for part in (found, found.partition)]
    assert found.share >= 0.25
    assert missed[0] < missed[1]


def test_predictions_are_scores():
    rows = coins(60, 10, 4)
    told = blended.fit(rows, 100.0 * rows[:, 0]).predict(coins(500, 10, 5))
    assert told.mean.min() >= 0.0
    assert told.mean.max() <= 100.0


def test_noise_that_a_process_explains_by_many_draws_is_noise():
    randomness = np.random.default_rng(9)
    draws = randomness.random((64, 60))
    rows = np.column_stack([coins(64, 10, 9), draws])
    given = np.clip(70.0 * rows[:, 0] * rows[:, 1] + 10.0 * randomness.normal(size=64), 0.0, 100.0)
    found = blended.fit(rows, given, continuous=np.arange(70) >= 10)
    assert 5.0 < found.noise < 20.0


def shared(process, cells, scores, row=None):
    """Share of a process that misses scores by some points, and cells that miss them by others."""
    predicted = np.clip(np.stack([scores + process, scores + cells]), 0.0, 100.0)
    return blended._share_by(predicted, scores, np.arange(len(scores)) if row is None else row)


def test_cells_are_preferred_if_both_parts_are_equally_good():
    scores = np.linspace(20.0, 80.0, 40)
    same = 5.0 * np.random.default_rng(0).normal(size=40)
    assert shared(same, same, scores) == pytest.approx(
        np.sum(blended.PROCESS_SHARES) / (20.0 + len(blended.PROCESS_SHARES) - 1.0)
    )


def test_the_share_is_a_mean_over_the_posterior_of_shares():
    randomness, scores = np.random.default_rng(1), np.linspace(20.0, 80.0, 30)
    process, cells = 4.0 * randomness.normal(size=30), 6.0 * randomness.normal(size=30)

    def density(share, noise):
        return np.prod(0.97 * norm.pdf(share * process + (1.0 - share) * cells, 0.0, noise) + 0.03 / 100.0)

    densities = np.array([sum(density(share, noise) for noise in blended._NOISES) for share in blended.PROCESS_SHARES])
    odds = densities**0.25 * np.append(20.0, np.ones(len(blended.PROCESS_SHARES) - 1))
    assert shared(process, cells, scores) == pytest.approx(odds @ blended.PROCESS_SHARES / odds.sum())


def test_the_better_part_gets_almost_all():
    randomness = np.random.default_rng(2)
    good, poor = 3.0 * randomness.normal(size=60), 20.0 * randomness.normal(size=60)
    scores = np.linspace(20.0, 80.0, 60)
    assert shared(good, poor, scores) > 0.85
    assert shared(poor, good, scores) < 0.05


def test_a_random_score_does_not_choose_the_part():
    randomness = np.random.default_rng(3)
    good, poor = 4.0 * randomness.normal(size=60), 12.0 * randomness.normal(size=60)
    good[7] = 70.0
    assert shared(good, poor, np.full(60, 20.0)) > 0.7


def test_scores_of_one_design_count_once():
    randomness = np.random.default_rng(4)
    good, poor = 4.0 * randomness.normal(size=20), 12.0 * randomness.normal(size=20)
    scores, row = np.linspace(20.0, 80.0, 20), np.arange(20)
    again = np.append(row, [3] * 40)
    assert shared(good[again], poor[again], scores[again], again) == pytest.approx(shared(good, poor, scores))


def test_contradicting_scores_of_a_design_are_its_mean():
    scores, row = np.append(np.zeros(8), np.full(8, 90.0)), np.tile(np.arange(8), 2)
    assert blended._share_by(np.stack([np.full(16, 45.0), np.zeros(16)]), scores, row) > 0.9


def test_cells_that_like_no_scored_design_have_no_share():
    rows, scores = coins(20, 6, 1), np.zeros(20)
    scores[12] = 67.0
    found = blended.fit(rows, scores)
    assert found.partition.predict(rows).mean.max() < 1.0
    assert found.share == 1.0
    assert blended.fit(rows, 80.0 * rows[:, 0]).share < 1.0


def test_few_labels_are_believed_to_the_process():
    rows = coins(10, 4, 6)
    assert blended.fit(rows, 50.0 * rows[:, 0]).share == 1.0


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


def test_a_process_does_not_hide_what_cells_like_of_few_designs():
    rows = coins(4000, 12, 8)
    rare = rows[:, :8].min(axis=1)
    asked = np.concatenate([np.flatnonzero(rare)[:8], np.arange(60)])
    given = np.clip(90.0 * rare[asked] + 10.0 * np.random.default_rng(3).normal(size=68), 0.0, 100.0)
    found = replace(blended.fit(rows[asked], given), share=0.2)
    damped = found.for_density(rows, np.ones(len(rows)))
    cells, process = damped.partition.predict(rows).mean, found.predict_values(rows).mean
    assert cells.sum() < found.partition.predict(rows).mean.sum()
    odds = 0.25 * min(1.0, cells.sum() / process.sum()) ** 7
    np.testing.assert_allclose(damped.predict(rows).mean, (odds * process + cells) / (1.0 + odds), rtol=1e-9, atol=1e-9)
    assert damped.damping == pytest.approx(odds / 0.25)
    alone = replace(found, share=0.0).for_density(rows, np.ones(len(rows)))
    np.testing.assert_array_equal(alone.predict(rows).mean, cells)
    assert alone.damping == 1.0
    by_process = replace(found, share=1.0)
    assert by_process.for_density(rows, np.ones(len(rows))) is by_process
