"""Belief in the parts of a blend: what they gain on nothing explained, and who gets the share of whom."""

import numpy as np
import pytest

from grammarlab.preference.belief import belief, believed, gain_by_misses, gain_by_shares, process_gain
from grammarlab.preference.held_out_share import PROCESS_SHARES
from grammarlab.preference.person import NOISES, expected_score, log_likelihood
from grammarlab.preference.unexplained import unexplained

GRID = np.arange(0.0, 101.0, 5.0)


def test_a_belief_is_a_posterior():
    for gain, num, odds in ((0.0, 8, 10.0), (3.0, 8, 10.0), (-2.0, 40, 3.0), (1.0, 4000, 3.0)):
        assert belief(gain, num) == pytest.approx(np.exp(gain) / (np.exp(gain) + odds))
    assert belief(1e6, 1) == pytest.approx(1.0)
    assert belief(-1e6, 1) == pytest.approx(0.0)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("process", [0.1, 0.8, 1.0])
@pytest.mark.parametrize("cells", [0.2, 0.9])
def test_shares_are_those_expected_if_each_part_is_right_or_not(share, process, cells):
    both, only_process, only_cells = process * cells, process * (1.0 - cells), (1.0 - process) * cells
    by_process, by_cells = both * share + only_process, both * (1.0 - share) + only_cells
    found, unexplained_share, handed = believed(share, process, cells)
    rest = 1.0 - by_process - by_cells
    assert unexplained_share == pytest.approx(rest if rest > 0.05 else 0.0)
    assert found == pytest.approx(by_process / (by_process + by_cells))
    assert handed == pytest.approx(only_process * (1.0 - share) / (by_process + by_cells))


def test_what_is_nearly_certain_is_certain():
    assert [believed(0.5, 0.0, cells)[1] for cells in (0.04, 0.06, 0.94, 0.96)] == pytest.approx([1.0, 0.94, 0.06, 0.0])


def test_a_gain_by_misses_is_the_likelihood_of_tilted_distributions():
    randomness = np.random.default_rng(1)
    scores, fold = randomness.choice([0.0, 30.0, 100.0], 10), np.arange(10) % 5
    flat = unexplained(scores, fold, GRID)
    means, sds = randomness.uniform(0.0, 100.0, 10), randomness.uniform(1.0, 20.0, 10)
    likelihoods = np.exp(log_likelihood(scores, GRID, *flat.person).astype(float))
    prior = randomness.uniform(500.0, 2000.0, 10)
    # What a posterior was told beyond its prior of mean 0: precisions are subtracted.
    precisions = 1.0 / sds**2 - 1.0 / prior
    told = means / sds**2 / precisions
    total = 0.0
    for miss in NOISES:
        product = 1.0
        for i in range(10):
            before = flat.held_out[fold[i]]
            away = told[i] - expected_score(GRID, flat.person.noise, 0.0)
            after = before * np.exp(-0.5 * away**2 / (1.0 / precisions[i] + miss**2))
            product *= (after / after.sum()) @ likelihoods[i] / (before @ likelihoods[i])
        total += product / len(NOISES)
    assert gain_by_misses(flat, scores, fold, means, sds, 1.0 - sds**2 / prior) == pytest.approx(np.log(total))


def test_a_gain_by_shares_is_the_likelihood_of_distributions_with_the_mean_of_a_mixture():
    randomness = np.random.default_rng(3)
    grid, scores, fold = np.array([0.0, 90.0]), randomness.choice([0.0, 30.0, 100.0], 10), np.arange(10) % 5
    flat = unexplained(scores, fold, grid)
    ratios = randomness.uniform(0.5, 1.0, 10)
    likelihoods = np.exp(log_likelihood(scores, grid, *flat.person).astype(float))
    total = 0.0
    for share in PROCESS_SHARES[1:]:
        product = 1.0
        for i in range(10):
            # Of two values, the mean is the probability of the second times this value.
            liked = flat.held_out[fold[i], 1] * (1.0 - share + share * ratios[i])
            before = flat.held_out[fold[i]] @ likelihoods[i]
            product *= np.array([1.0 - liked, liked]) @ likelihoods[i] / before
        total += product / (len(PROCESS_SHARES) - 1)
    assert gain_by_shares(flat, scores, fold, ratios) == pytest.approx(np.log(total))


def test_shares_see_where_the_liked_designs_are_though_every_value_is_missed():
    randomness = np.random.default_rng(4)
    ratios = np.repeat([0.2, 1.8], 60)
    scores = np.where(randomness.random(120) < 0.2 * ratios, 100.0, 0.0)
    fold, ones = np.arange(120) % 8, np.ones(120)
    flat = unexplained(scores, fold, GRID)
    assert gain_by_shares(flat, scores, fold, ratios) > 4.0
    assert gain_by_misses(flat, scores, fold, 20.0 * ratios, ones, ones) < -10.0
    assert gain_by_shares(flat, scores, fold, ones) == pytest.approx(0.0, abs=1e-9)
    assert gain_by_shares(flat, scores, fold, 2.0 - ratios) < -1.0


def test_predictions_that_say_nothing_gain_nothing_and_wrong_ones_lose():
    randomness = np.random.default_rng(2)
    scores, fold = randomness.choice([0.0, 80.0], 40), np.arange(40) % 8
    flat, right = unexplained(scores, fold, GRID), scores
    ones = np.ones(40)
    assert gain_by_misses(flat, scores, fold, 40.0 * ones, 1e6 * ones, ones) == pytest.approx(0.0, abs=1e-6)
    # The prior of a process: most designs have a low mean, which is no reason to expect low scores of each.
    assert gain_by_misses(flat, scores, fold, 0.0 * ones, 30.0 * ones, 0.0 * ones) == pytest.approx(0.0, abs=1e-6)
    exact = gain_by_misses(flat, scores, fold, right, ones, ones)
    rough = gain_by_misses(flat, scores, fold, np.clip(right, 25.0, 55.0), ones, ones)
    wrong = gain_by_misses(flat, scores, fold, 80.0 - right, ones, ones)
    assert exact > rough > 5.0
    assert wrong < -20.0


@pytest.mark.parametrize("seed", range(3))
def test_a_process_gains_by_a_pattern_and_not_without_one(seed):
    randomness = np.random.default_rng(seed)
    rows = randomness.random((40, 8))
    options = {"groups": np.arange(8), "continuous": np.ones(8, dtype=bool), "seed": 0}
    scores = np.clip(100.0 * rows[:, 0] - 60.0 * rows[:, 1] + 5.0 * randomness.normal(size=40), 0.0, 100.0)
    assert process_gain(rows, scores, **options) > 10.0
    assert process_gain(rows, randomness.permutation(scores), **options) < 2.0
    assert process_gain(np.ones((5, 8)), scores[:5], **options) == 0.0


@pytest.mark.parametrize("scores", [[100.0, 0.0], [0.0, 0.0, 100.0], [0.0, 100.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0, 0.0]])
def test_a_process_gains_little_by_few_scores(scores):
    rows = np.eye(len(scores))[:, :2]
    gain = process_gain(
        rows, np.array(scores), groups=np.zeros(2, dtype=int), continuous=np.zeros(2, dtype=bool), seed=0
    )
    assert -5.0 < gain < 2.0
