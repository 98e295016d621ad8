"""Regression trees, and preferences made of them."""

import numpy as np
import pytest

from grammarlab.features.expression import Expression
from grammarlab.preference.regression_tree import grow, leaves_of, means_of, round_between
from grammarlab.preference.simplified import SimplifiedPreference
from tests.preference.rows import bits


def fitted(rows, values, weights, size):
    tree = grow(rows, values, weights, np.arange(rows.shape[1]), size)
    return SimplifiedPreference(tree, means_of(leaves_of(tree, rows), len(tree) + 1, values, weights))


def test_a_function_of_two_columns_is_found_exactly():
    rows = bits(500, 6)
    values = 20.0 + 30.0 * rows[:, 1] * (1.0 + rows[:, 4])
    found = fitted(rows, values, np.ones(500), 8)
    assert found.columns.tolist() == [1, 4]
    np.testing.assert_allclose(found(rows), values)
    assert len(found.levels) == 3


def test_the_first_split_is_the_best_of_all():
    random = np.random.default_rng(3)
    rows, values, weights = random.integers(0, 5, (60, 4)).astype(float), random.uniform(0, 100, 60), random.random(60)

    def left(column, bound):
        above = rows[:, column] >= bound
        parts = [part for part in (above, ~above) if part.any()]
        roots = np.sqrt(values)
        return sum(weights[p] @ (roots[p] - np.average(roots[p], weights=weights[p])) ** 2 for p in parts)

    split = grow(rows, values, weights, np.arange(4), 2)[0]
    best = min(left(column, bound) for column in range(4) for bound in range(1, 5))
    assert left(split.column, split.bound) == pytest.approx(best)


def test_the_first_splits_of_a_tree_are_the_smaller_tree():
    random = np.random.default_rng(0)
    rows, values = random.random((300, 5)), random.uniform(0, 100, 300)
    whole = grow(rows, values, np.ones(300), np.arange(5), 20)
    assert grow(rows, values, np.ones(300), np.arange(5), 7) == whole[:6]


def test_rows_without_weight_decide_nothing():
    rows, values = bits(200, 3), np.random.default_rng(1).uniform(0, 100, 200)
    weights = (np.arange(200) < 100).astype(float)
    with_them = grow(rows, values, weights, np.arange(3), 4)
    assert with_them == grow(rows[:100], values[:100], np.ones(100), np.arange(3), 4)


def test_constant_values_and_no_columns_give_no_split():
    rows = bits(40, 3)
    assert grow(rows, np.full(40, 7.0), np.ones(40), np.arange(3), 9) == ()
    assert grow(rows, rows[:, 0], np.ones(40), np.zeros(0, int), 9) == ()


def test_pruning_and_the_text_change_no_score():
    random = np.random.default_rng(5)
    rows, values = random.random((400, 3)), random.uniform(0, 100, 400)
    tree = grow(rows, values, np.ones(400), np.arange(3), 40)
    simple = SimplifiedPreference(tree, np.round(random.uniform(0, 3, len(tree) + 1)))
    pruned = simple.pruned()
    assert len(pruned.tree) < len(simple.tree)
    np.testing.assert_array_equal(pruned(rows), simple(rows))
    expression = Expression.parse(pruned.text(lambda column, bound: f"$x{column} + 0 >= {bound!r}"))
    columns = [int(str(feature)[1:]) for feature in expression.features]
    np.testing.assert_array_equal(expression.evaluate(rows[:, columns]), simple(rows))


@pytest.mark.parametrize(
    ("low", "high", "wanted"), [(1.0, 2.0, 2.0), (9.0, 11.0, 10.0), (0.31, 0.39, 0.39), (-2.5, -1.2, -2.0)]
)
def test_bounds_are_round(low, high, wanted):
    assert round_between(low, high) == wanted
