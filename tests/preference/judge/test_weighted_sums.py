"""Weighted sums: weights of bounds, bands and weighted votes, rounded, each at a price."""

from itertools import product

import numpy as np
import pytest

from grammarlab.preference.judge.judge import judged
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.judge.votes import MAX_TERMS
from grammarlab.preference.judge.weighted_sums import (
    _STEPS,
    Measures,
    _best,
    _Cells,
    _decimal,
    _different,
    _Wave,
    _Waves,
    weighted_sums,
)
from grammarlab.preference.person import START_PERSONS
from tests.cases import takes_turns

NONE = np.zeros((128, 0))


def draws(num, width, seed):
    return np.random.default_rng(seed).random((num, width))


def even(columns):
    """The price of one of some columns."""
    return np.full(columns.shape[1], np.log(2.0 * max(columns.shape[1], 1)))


def verdict_of(columns, scores):
    return judged(columns, NONE, np.zeros(0), NONE, Measures(columns, even(columns)), scores)


def sums_of(columns, scores, explained=-1e3):
    return weighted_sums(Measures(columns, even(columns)), LeafEvidence.of(scores, START_PERSONS[0]), explained)


def half_space(some):
    return 2.0 * some[:, 1] + 0.7 * some[:, 4] - some[:, 6] < 6.0


def band(some):
    return np.abs(some[:, 1] + some[:, 4] - 2.0 * some[:, 6]) < 2.0


@takes_turns
@pytest.mark.parametrize("noise", [0.0, 10.0])
@pytest.mark.parametrize("liked", [half_space, band])
def test_a_bound_or_a_band_of_a_sum_is_one_column(liked, noise):
    columns, fresh, randomness = 1.0 + 9.0 * draws(128, 8, 2), 1.0 + 9.0 * draws(4000, 8, 3), np.random.default_rng(4)
    scores = np.clip(100.0 * liked(columns) + noise * randomness.normal(size=128), 0.0, 100.0).round()
    verdict = verdict_of(columns, scores)
    (found,) = verdict.sums
    assert set(found.columns) == {1, 4, 6}
    inside, sums = liked(columns), found.values(columns)
    low, high = sums[inside].min(), sums[inside].max()
    predicted = (found.values(fresh) >= low) & (found.values(fresh) <= high)
    assert np.mean(predicted == liked(fresh)) > 0.94
    assert verdict.total > verdict.known + 5.0
    assert verdict_of(columns, scores[randomness.permutation(len(scores))]).sums == ()


def test_all_amplitudes_are_those_of_sums_with_one_column_more():
    columns, randomness = draws(40, 5, 7), np.random.default_rng(8)
    waves = _Waves.of(columns, even(columns), randomness.random(40))
    phases = randomness.normal(size=(3, 40))
    weights = [sign * phase for phase in (0.35, 0.7, 1.4) for sign in (1.0, -1.0)]
    for weight, squared in zip(weights, waves._amplitudes(phases), strict=True):
        longer = phases[:, None] + weight * waves.table.T
        expected = np.abs((waves.scores * np.exp(1j * longer)).sum(axis=2)) ** 2
        assert squared == pytest.approx(expected, abs=1e-5)


def test_of_equal_sums_the_best_stays():
    waves = [_Wave((0, 1), np.ones(2), 100.0), *(_Wave((2, k), np.ones(2), float(k)) for k in range(3, 15))]
    best = _best([*waves, _Wave((1, 0), np.ones(2), -50.0)])
    assert [wave.loss for wave in best] == [-50.0, *map(float, range(3, 10))]


def test_longer_sums_begin_with_their_best_weights():
    columns, randomness = draws(96, 8, 11), np.random.default_rng(12)
    waves = _Waves.of(columns, even(columns), np.where(columns @ randomness.normal(size=8) > 0.0, 100.0, 0.0))
    roots = [_Wave((root,), np.ones(1), 0.0) for root in range(8)]
    together = {frozenset(wave.columns): wave.loss for wave in waves._longer(roots)}
    alone = [wave for root in roots for wave in waves._longer([root])]
    for columns_of, loss in together.items():
        least = min(wave.loss for wave in alone if frozenset(wave.columns) == columns_of)
        assert loss <= least + 1e-3


def test_a_column_that_no_kept_one_resembles_is_kept():
    first, other = np.random.default_rng(13).normal(size=(2, 4000))
    first, other = first / first.std(), other / other.std()
    other -= first * (first @ other) / (first @ first)
    angles = (0.0, 0.15, 0.3)
    chain = np.stack([np.cos(angle) * first + np.sin(angle) * other for angle in angles], axis=1)
    assert _different(chain, np.array([1.0, 2.0, 3.0])).tolist() == [0, 2]


def test_weights_near_by_explain_no_less():
    columns = draws(80, 6, 9)
    waves = _Waves.of(columns, even(columns), np.where(np.abs(columns[:, 0] - columns[:, 3]) < 0.1, 100.0, 0.0))

    def amplitude(wave, weights):
        return abs((waves.scores * np.exp(1j * (waves.table[:, list(wave.columns)] @ weights))).sum())

    grown = list(waves.grown())
    assert {len(wave.columns) for wave in grown} == set(range(2, MAX_TERMS + 1))
    best = min((wave for wave in grown if len(wave.columns) == 2), key=lambda wave: wave.loss)
    assert set(best.columns) == {0, 3}
    fitted = waves._fitted([best] * 4)[0]
    for step in product((-0.05, 0.05), repeat=2):
        assert amplitude(best, fitted.weights) >= amplitude(best, fitted.weights + np.array(step))


@pytest.mark.parametrize("seed", [1, 7])
def test_no_column_of_a_sum_is_needed_only_to_find_the_others(seed):
    columns = draws(96, 10, seed)
    inside = np.abs(columns[:, :3] @ [1.0, -1.0, 0.5] - 0.2) < 0.15
    waves = _Waves.of(columns, even(columns), np.where(inside, 100.0, 0.0))
    best = {len(wave.columns): wave for wave in sorted(waves.grown(), key=lambda wave: -wave.loss)}
    for size in range(3, MAX_TERMS + 1):
        without = waves._fitted([best[size].without(index) for index in range(size)])
        # Newton's method takes few steps: from another start it ends some 1e-7 nats nearer.
        assert best[size - 1].loss <= min(wave.loss for wave in without) + 1e-6


def test_prices_of_all_weights_of_some_columns_are_a_probability():
    prices, scales = np.full(3, np.log(3.0)), np.array([1.0, 0.3, 7.0])
    total = 0.0
    for size, step in product(range(2, 4), _STEPS):
        cells = [cell for cell in range(-round(1.0 / step), round(1.0 / step) + 1) if cell]
        rounded = _Cells(tuple(range(size)), step, (cells[0],) * (size - 1)).rounded(prices, scales)
        # All sets of so many of the columns, with each of its columns as the first, and all weights of the others.
        sets = 3 if size == 2 else 1
        total += sets * size * len(cells) ** (size - 1) * np.exp(-rounded.price)
    assert 0.0 < total <= 1.0


def test_prices_grow_with_the_columns_and_with_finer_steps():
    prices, scales = np.array([1.0, 2.0, 4.0]), np.ones(3)
    coarse, fine = (_Cells((0, 2), step, (2,)).rounded(prices, scales).price for step in _STEPS[:2])
    assert fine == pytest.approx(coarse + np.log(2.0))
    assert _Cells((0, 1), _STEPS[0], (2,)).rounded(prices, scales).price == pytest.approx(coarse - 2.0)


@pytest.mark.parametrize("step", _STEPS)
def test_weights_are_rounded_within_their_step(step):
    scales, prices = np.array([2.3, 0.017, 410.0]), np.zeros(3)
    for cell in (-round(1.0 / step), -1, 1, round(1.0 / step)):
        some = _Cells((0, 1, 2), step, (cell, cell)).rounded(prices, scales)
        assert np.array(some.weights[1:]) * scales[1:] / scales[0] == pytest.approx(cell * step, abs=step / 2.0 + 1e-9)


def test_neighbours_of_weights_differ_by_one_step_and_are_never_zero():
    near = list(_Cells((0, 1, 2), 0.25, (1, -4)).near())
    assert [cells.cells for cells in near] == [(1, -4), (2, -4), (1, -3)]


@pytest.mark.parametrize("reach", [0.3, 0.01, 1e-12])
def test_decimals_are_as_near_as_asked(reach):
    for middle in (0.0371, -8.14159, 1.0, 2999.5, 1e-9):
        assert abs(_decimal(middle, reach) - middle) <= reach


def test_scores_that_are_all_liked_or_all_disliked_have_no_sums():
    columns = draws(20, 3, 6)
    assert sums_of(columns, np.full(20, 40.0)) == []
    assert sums_of(np.ones((20, 3)), np.arange(20.0)) == []
    assert sums_of(columns[:, :0], np.arange(20.0)) == []
    assert sums_of(columns[:, :1], np.arange(20.0)) == []


def test_scores_that_are_explained_need_no_sums():
    columns = draws(90, 6, 5)
    scores = np.where(columns @ [3.0, -2.0, 1.0, 0.0, 0.0, 0.0] > 1.0, 100.0, 0.0)
    assert sums_of(columns, scores)
    assert sums_of(columns, scores, explained=0.0) == []


def test_equal_columns_and_flags_of_few_are_no_parts():
    columns = draws(90, 4, 5)
    columns[:, 2] = 3.0 - 2.0 * columns[:, 1]
    columns[:, 3] = np.arange(90) < 8
    scores = np.where(columns[:, 0] - columns[:, 1] > 0.1, 100.0, 0.0)
    assert {column for some in sums_of(columns, scores) for column in some.columns} == {0, 1}


def test_sums_that_are_too_long_are_left_out():
    columns = draws(90, 6, 5)
    evidence = LeafEvidence.of(np.where(columns @ [3.0, -2.0, 1.0, 0.0, 0.0, 0.0] > 1.0, 100.0, 0.0), START_PERSONS[0])
    measures = Measures(columns, even(columns), can_be_added=lambda some: len(some) == 2)
    found = weighted_sums(measures, evidence, -1e3)
    assert found
    assert all(len(some.columns) == 2 for some in found)


def test_columns_whose_sum_is_constant_are_no_beginning():
    columns = draws(90, 4, 5)
    columns[:, 1], columns[:, 2] = columns[:, 0] < 0.3, columns[:, 0] >= 0.3
    columns[:, 2] *= columns[:, 3] > 0.5
    columns[:, 3] = 1.0 - columns[:, 1] - columns[:, 2]
    waves = _Waves.of(columns, even(columns), 100.0 * columns[:, 1])
    constant = _Wave((1, 2, 3), columns[:, 1:].std(axis=0), 0.0)
    assert waves._longer([constant]) == waves._longer([]) == []
    assert [wave.columns for wave in waves._longer([constant, _Wave((0, 1, 2), np.ones(3), 0.0)])]
