"""Partitions: the best tree by brute force, persons who err, and laws of predictions."""

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.preference.base import MIN_SHARE
from grammarlab.preference.cells import partition
from grammarlab.preference.person import BLUNDERS, NOISES
from tests.cases import takes_turns


def coins(number, width, seed):
    return np.random.default_rng(seed).integers(0, 2, (number, width)).astype(float)


def test_every_label_lies_in_its_own_cell():
    rows = coins(60, 6, 0)
    scores = 50.0 * rows[:, 0] * rows[:, 1]
    found = partition.fit(rows, scores)
    for tree in found.trees + found.doubtful:
        number, cells = tree.cell_of(rows)
        assert sorted(np.concatenate(list(tree.cells())).tolist()) == list(range(60))
        assert all(label in cells[number[label]] for label in range(60))


@pytest.mark.parametrize("seed", range(3))
def test_both_bounds_of_a_narrow_range_lie_between_the_nearest_labels(seed):
    # Few bounds, evenly spaced by rank, miss those of a range with a twentieth of the labels.
    rows = np.random.default_rng(seed).uniform(0.0, 1.0, (200, 3))
    inside = (rows[:, 1] > 0.5) & (rows[:, 1] < 0.55)
    found = partition.fit(rows, 100.0 * inside, continuous=np.ones(3, dtype=bool))
    assert found.predict(rows).mean == pytest.approx(100.0 * inside, abs=1.0)
    below, above = (rows[~inside & side, 1] for side in (rows[:, 1] <= 0.5, rows[:, 1] >= 0.55))
    ends = {below.max(): rows[inside, 1].min(), rows[inside, 1].max(): above.min()}
    bounds = sorted({bound for node in found.trees[0].nodes() if node.split for bound in node.split.bounds})
    assert bounds == pytest.approx(sorted((low + high) / 2.0 for low, high in ends.items()))
    # Where no label says more, both values are likely.
    apart = np.full((99, 3), 0.5)
    low, high = max(ends.items(), key=lambda ends: ends[1] - ends[0])
    apart[:, 1] = np.linspace(low, high, 101)[1:-1]
    spread = np.sqrt(np.diag(found.joint(apart)[1]))
    assert spread.mean() > 10.0


@takes_turns
@pytest.mark.parametrize("noise", [0.0, 10.0, 20.0])
def test_either_but_not_both_is_found_through_noise(noise):
    rows, randomness = coins(120, 8, 1), np.random.default_rng(2)
    meant = np.where(rows[:, 3] != rows[:, 7], 70.0, 0.0)
    scores = np.clip(meant + noise * randomness.normal(size=120), 0.0, 100.0)
    found = partition.fit(rows, scores)
    fresh = coins(200, 8, 3)
    wanted = np.where(fresh[:, 3] != fresh[:, 7], 70.0, 0.0)
    assert np.abs(found.predict(fresh).mean - wanted).mean() < 1.0 + 0.15 * noise
    assert 0.5 * noise <= found.noise <= max(0.5, 1.6 * noise)


def test_values_are_averages_over_the_noises_that_the_labels_allow():
    rows, randomness = coins(64, 1, 4), np.random.default_rng(5)
    scores = np.clip(50.0 * rows[:, 0] + 10.0 + 20.0 * randomness.normal(size=64), 0.0, 100.0)
    found = partition.fit(rows, scores)
    low = np.flatnonzero(rows[:, 0] == 0.0)
    likely = [(share, noise) for share, noise in zip(found.noises, NOISES, strict=True) if share >= MIN_SHARE]
    assert len(likely) > 1
    means = [share * replace(found.cells, noise=noise).posterior(low) @ found.cells.grid for share, noise in likely]
    assert found._values([low])[0][0] == pytest.approx(sum(means) / sum(share for share, _ in likely))


def test_designs_of_a_cell_may_have_different_values_if_one_value_would_make_blunders_of_scores():
    rows = np.repeat([[0.0], [1.0]], [40, 24], axis=0)
    scores = np.concatenate([np.repeat([0.0, 70.0], [34, 6]), np.full(24, 90.0)])
    one_value = partition.fit(rows, scores)
    assert one_value.trees[0].split is not None
    np.testing.assert_allclose(one_value.predict(np.array([[0.0], [1.0]])).mean, [0.0, 90.0], atol=1.0)
    unlike = replace(one_value, unlike=1.0)
    np.testing.assert_allclose(unlike.predict(np.array([[0.0], [1.0]])).mean, [10.5, 90.0], atol=1.0)
    half = replace(one_value, unlike=0.5)
    np.testing.assert_allclose(half.predict(np.array([[0.0], [1.0]])).mean, [5.25, 90.0], atol=1.0)


@takes_turns
def test_a_blunder_is_no_structure():
    rows, randomness = coins(120, 6, 4), np.random.default_rng(5)
    meant = 60.0 * rows[:, 0]
    wrong = randomness.random(120) < 0.1
    found = partition.fit(rows, np.where(wrong, 100.0 * randomness.random(120), meant))
    fresh = coins(100, 6, 6)
    np.testing.assert_allclose(found.predict(fresh).mean, 60.0 * fresh[:, 0], atol=1.0)
    assert 0.03 <= found.blunders <= 0.25


def test_alternatives_of_a_choice_are_told_apart_at_once():
    choice = np.random.default_rng(7).integers(0, 5, 150)
    rows = np.eye(5)[choice]
    scores = np.array([0.0, 20.0, 0.0, 90.0, 20.0])[choice]
    found = partition.fit(np.column_stack([rows, coins(150, 8, 8)]), scores, groups=[0] * 5 + list(range(1, 9)))
    fresh = np.column_stack([np.eye(5), coins(5, 8, 9)])
    np.testing.assert_allclose(found.predict(fresh).mean, [0.0, 20.0, 0.0, 90.0, 20.0], atol=0.5)
    assert found.explain([f"g{n}" for n in range(9)])[0].name == "g0"


def test_intervals_hold_fresh_scores_as_often_as_they_say():
    rows, randomness = coins(200, 8, 10), np.random.default_rng(11)
    person = lambda rows: np.clip(30.0 + 40.0 * rows[:, 2] + 10.0 * randomness.normal(size=len(rows)), 0.0, 100.0)  # noqa: E731 - draws anew
    found = partition.fit(rows, person(rows))
    fresh = coins(1000, 8, 12)
    told = found.predict(fresh)
    inside = np.abs(person(fresh) - told.mean) < 1.645 * told.std
    assert 0.85 <= inside.mean() <= 0.97


def test_the_same_labels_give_the_same_cells():
    rows = coins(80, 6, 13)
    scores = 40.0 * rows[:, 1] + 20.0 * rows[:, 4]
    first, second = (partition.fit(rows, scores).predict(rows) for _ in range(2))
    np.testing.assert_array_equal(first.mean, second.mean)
    np.testing.assert_array_equal(first.std, second.std)


def test_scores_without_columns_are_one_cell():
    scores = np.repeat([0.0, 90.0], 20)
    found = partition.fit(np.zeros((40, 0)), scores)
    assert [len(list(tree.cells())) for tree in found.trees] == [1] * len(found.trees)


def test_a_covariance_has_no_negative_direction():
    rows = coins(60, 6, 14)
    found = partition.fit(rows, 50.0 * rows[:, 0])
    mean, covariance = found.joint(coins(40, 6, 15))
    assert mean.shape == (40,)
    assert np.linalg.eigvalsh(covariance).min() > -1e-6


def exact_labels(seed):
    """Rows, scores without noise that four columns decide, and which labels are not held out."""
    rows = coins(60, 8, seed)
    scores = 100.0 * (rows[:, 0] * rows[:, 1] + (1.0 - rows[:, 0]) * rows[:, 2] * rows[:, 3])
    return rows, scores, np.arange(60) % 3 > 0


def test_exact_scores_that_are_held_out_leave_no_mark():
    rows, scores, known = exact_labels(2)
    continuous = np.zeros(8, dtype=bool)
    preference = partition.fit(rows, scores)
    other = partition.fit(rows, np.where(known, scores, 100.0 - scores))
    assert preference.noise == NOISES[0]
    parts = [
        replace(preference, trees=trees).without(rows[known], scores[known], continuous)
        for trees in (preference.trees, other.trees)
    ]
    own, others = (part.predict(rows).mean for part in parts)
    assert np.array_equal(own, others)


@pytest.mark.parametrize("seed", [2, 3, 11])
def test_exact_scores_are_explained_exactly_and_without_some_of_them_nearly(seed):
    rows, scores, known = exact_labels(seed)
    preference = partition.fit(rows, scores)
    assert (preference.noise, preference.blunders) == (NOISES[0], BLUNDERS[0])
    assert preference.predict(rows).mean == pytest.approx(scores, abs=0.5)
    part = preference.without(rows[known], scores[known], np.zeros(8, dtype=bool))
    assert part.predict(rows[known]).mean == pytest.approx(scores[known], abs=0.5)
    assert np.abs(part.predict(rows[~known]).mean - scores[~known]).mean() < 20.0


def noisy(scores):
    return np.clip(scores + np.random.default_rng(0).normal(0.0, 10.0, 60), 0.0, 100.0)


def blundering(scores):
    randomness = np.random.default_rng(0)
    return np.where(randomness.random(60) < 0.1, 100.0 * randomness.random(60).round(2), scores)


@takes_turns
@pytest.mark.parametrize("errs", [noisy, blundering])
def test_splits_that_errors_hide_from_few_labels_are_kept(errs):
    rows, scores, known = exact_labels(3)
    given = errs(scores)
    preference = partition.fit(rows, given)
    assert (preference.noise > NOISES[0], preference.blunders > BLUNDERS[0]) == (errs is noisy, errs is blundering)
    part = preference.without(rows[known], given[known], np.zeros(8, dtype=bool))
    alone = partition.fit(rows[known], given[known])
    read = [
        {column for node in each.trees[0].nodes() if node.split for column in node.split.columns}
        for each in (part, alone)
    ]
    assert {0, 1, 2, 3} <= read[0]
    assert part.trees[0].log_posterior > alone.trees[0].log_posterior - 10.0
