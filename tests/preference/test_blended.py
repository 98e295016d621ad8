"""Blends: whichever part predicts held-out scores, and what noise does to means."""

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.preference import blended
from grammarlab.preference.cells.partition import NOISES


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


def test_a_process_keeps_a_share_unless_scores_speak_against_it():
    scores = np.array([0.0, 10.0, 0.0, 50.0, 70.0, 40.0])
    alike = np.stack([scores + 5.0, scores - 5.0])
    every = np.arange(6)
    assert blended._best_share(alike, scores, every, 0.1) == 0.5
    cells = np.stack([scores + 5.0, scores + 4.0 + np.array([0.0, 3.0, -2.0, 0.0, 1.0, 0.0])])
    assert [blended._best_share(cells, scores, every, least) for least in (0.0, 0.04, 0.1)] == [0.0, 0.04, 0.1]
    far = np.stack([scores + 50.0, scores])
    assert blended._best_share(far, scores, every, 0.14) == 0.0


def test_the_least_share_grows_with_errors_and_falls_with_labels():
    assert blended._least_share(NOISES[0], 32) == 0.0
    assert [blended._least_share(20.0, num) for num in (32, 64, 128, 256)] == pytest.approx([0.1, 0.1, 0.025, 0.00625])
    assert blended._least_share(10.0, 64) == pytest.approx(0.05)


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
    damped = found.damped(rows, np.ones(len(rows)))
    cells, process = found.partition.predict(rows).mean, found.meant(rows).mean
    odds = 0.25 * min(1.0, cells.sum() / process.sum())
    np.testing.assert_allclose(damped.predict(rows).mean, (odds * process + cells) / (1.0 + odds), rtol=1e-9, atol=1e-9)
    assert damped.damping == pytest.approx(odds / 0.25)
    for share in (0.0, 1.0):
        alone = replace(found, share=share)
        assert alone.damped(rows, np.ones(len(rows))) is alone
