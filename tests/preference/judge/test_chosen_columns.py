"""Tables of pairs and orders that scores choose: true ones are found, at the price of their choice among all."""

import tracemalloc
from itertools import combinations
from math import comb, factorial

import numpy as np
import pytest
from scipy.special import gammaln

from grammarlab.preference.growth.screening import coarse_bins, explained, gains
from grammarlab.preference.judge.learned_orders import LearnedOrder, learned_orders
from grammarlab.preference.judge.pair_tables import pair_tables


def noisy(values, seed):
    return np.clip(values + np.random.default_rng(seed).normal(0.0, 10.0, len(values)), 0.0, 100.0).round()


def test_a_table_of_pairs_is_found_cell_by_cell():
    randomness = np.random.default_rng(1)
    numbers = randomness.integers(0, 4, (96, 9))
    wanted = {(0, 2), (1, 1), (1, 3), (3, 0)}
    liked = np.array([(a, b) in wanted for a, b in numbers[:, [2, 6]].tolist()])
    table = next(pair_tables(numbers, noisy(90.0 * liked, 1)))
    assert (table.first, table.second, set(table.cells)) == (2, 6, wanted)
    np.testing.assert_array_equal(table.values(numbers), liked)
    num_cells = len(np.unique(numbers[:, [2, 6]], axis=0))
    assert table.price == pytest.approx(np.log(comb(9, 2) * num_cells * comb(num_cells, 4)))


def test_tables_of_more_cells_than_a_number_can_count_choices_of_have_a_price():
    numbers = np.indices((40, 40)).reshape(2, -1).T
    (table,) = pair_tables(numbers, 90.0 * (numbers.sum(axis=1) % 2))
    assert len(table.cells) == 800
    assert table.price == pytest.approx(np.log(1600.0) + gammaln(1601) - 2.0 * gammaln(801))


def test_a_table_divides_scores_better_than_any_other_number_of_its_best_cells():
    randomness = np.random.default_rng(2)
    numbers, scores = randomness.integers(0, 3, (60, 4)), randomness.uniform(0.0, 100.0, 60)

    def explained(flag):
        return abs(np.corrcoef(flag, scores)[0, 1])

    for table in pair_tables(numbers, scores):
        pairs = numbers[:, [table.first, table.second]]
        cells = np.unique(pairs, axis=0)
        means = [scores[(pairs == cell).all(axis=1)].mean() for cell in cells]
        order = cells[np.argsort(means)[::-1]]
        flags = [(pairs[:, None] == order[None, :size]).all(axis=2).any(axis=1) for size in range(1, len(order))]
        assert explained(table.values(numbers)) == pytest.approx(max(map(explained, flags)))


def test_an_order_is_found_by_which_a_sequence_never_falls():
    randomness = np.random.default_rng(3)
    numbers = randomness.integers(0, 5, (160, 6))
    true = LearnedOrder((1, 2, 4), (3, 1, 4, 2), 0.0)
    (other, order) = learned_orders(numbers, [(0, 3, 5), (1, 2, 4)], noisy(90.0 * true.values(numbers), 3))
    assert order.order == true.order
    np.testing.assert_array_equal(order.values(numbers), true.values(numbers))
    assert order.price == other.price == pytest.approx(np.log(2 * factorial(4)))
    expected = [
        len(seen := [true.order.index(number) for number in row if number]) > 1 and seen == sorted(seen)
        for row in numbers[:, [1, 2, 4]].tolist()
    ]
    np.testing.assert_array_equal(true.values(numbers), expected)


def test_orders_are_found_from_both_ends():
    for seed in range(60):
        randomness = np.random.default_rng(seed)
        numbers, planted = randomness.integers(1, 7, (96, 3)), (1 + randomness.permutation(6)).tolist()
        true = LearnedOrder((0, 1, 2), tuple(planted), 0.0).values(numbers)
        (order,) = learned_orders(numbers, [(0, 1, 2)], noisy(90.0 * true, seed))
        assert (order.values(numbers) == true).mean() > 0.97, seed


def test_no_change_of_places_improves_an_order():
    randomness = np.random.default_rng(4)
    numbers, scores = randomness.integers(1, 5, (80, 3)), randomness.uniform(0.0, 100.0, 80)
    (best,) = learned_orders(numbers, [(0, 1, 2)], scores)
    orders = [best.order]
    for first, second in combinations(range(4), 2):
        swapped = list(best.order)
        swapped[first], swapped[second] = swapped[second], swapped[first]
        orders.append(tuple(swapped))
    flags = [LearnedOrder((0, 1, 2), order, 0.0).values(numbers) for order in orders]
    reached, *others = gains(coarse_bins(np.array(flags).T), np.arange(80), scores)
    assert reached >= max(others)


def description(pairs, scores):
    codes = np.unique(pairs, axis=0, return_inverse=True)[1].reshape(-1)
    num = codes.max() + 1
    return np.log(2.0) * num - explained(codes[None], num, scores)[0]


def test_tables_of_many_choices_are_those_of_pairs_of_them():
    numbers, scores = np.random.default_rng(6).integers(0, 3, (50, 40)), np.random.default_rng(7).uniform(0, 100, 50)
    tables = list(pair_tables(numbers, scores))
    best = min(combinations(range(40), 2), key=lambda pair: description(numbers[:, pair], scores))
    assert (tables[0].first, tables[0].second) == best


def test_many_choices_need_little_memory():
    randomness = np.random.default_rng(8)
    numbers = randomness.integers(0, 12, (64, 150))
    scores = randomness.uniform(0.0, 100.0, 64)
    tracemalloc.start()
    table = next(pair_tables(numbers, scores))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert table.first < table.second
    assert peak < 30e6


@pytest.mark.parametrize("num", [1, 30])
def test_equal_scores_and_few_columns_suggest_nothing(num):
    numbers, scores = np.ones((num, 3), dtype=np.int64), np.full(num, 40.0)
    assert list(pair_tables(numbers, scores)) == []
    assert list(learned_orders(numbers, [(0, 1, 2)], scores)) == []
    rising = np.linspace(0.0, 90.0, num)
    assert list(pair_tables(numbers[:, :1], rising)) == []
