"""Functions of few columns: products of trees."""

import numpy as np
import pytest

from grammarlab.preference.regression_tree import grow
from grammarlab.preference.simplified import SimplifiedPreference


def some_function(rows, random):
    tree = grow(rows, random.random(len(rows)), np.ones(len(rows)), np.arange(rows.shape[1]), 6)
    return SimplifiedPreference(tree, random.integers(0, 3, len(tree) + 1).astype(float))


@pytest.mark.parametrize("seed", range(10))
def test_a_product_has_the_products_of_the_values(seed):
    random = np.random.default_rng(seed)
    rows = random.integers(0, 3, (300, 4)).astype(float)
    first, second = some_function(rows, random), some_function(rows, random)
    product = first.times(second)
    np.testing.assert_array_equal(product(rows), first(rows) * second(rows))
    assert len(product.tree) < len(product.scores) <= len(first.scores) * len(second.scores)
    assert set(product.columns) <= set(first.columns) | set(second.columns)
