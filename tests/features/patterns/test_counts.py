"""Counts of features against their definition."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import UsageError
from grammarlab.features.patterns.counts import MAX_EMBEDDINGS, count
from grammarlab.features.patterns.pattern import Draw, Formula, Present, Threshold
from grammarlab.features.patterns.pattern_text import parse
from tests.features.forests import brute_force, forest_of, patterns, random_forest

SEEDS = st.integers(0, 2**32)


@given(SEEDS, st.lists(patterns(), min_size=1, max_size=4), st.floats(0, 1))
def test_patterns_are_counted_as_their_definition_says(seed, wanted, depth):
    forest = random_forest(np.random.default_rng(seed), 3, 12, depth)
    expected = np.array([brute_force(forest, pattern) for pattern in wanted]).T
    np.testing.assert_array_equal(count(forest, wanted), expected)


@given(SEEDS, patterns())
def test_a_model_counts_the_same_alone(seed, pattern):
    forest = random_forest(np.random.default_rng(seed), 4, 10)
    together = count(forest, [pattern])[:, 0]
    for model in range(4):
        rows = np.flatnonzero(forest.nodes.model == model)
        new = {-1: -1} | {int(row): place for place, row in enumerate(rows)}
        fields = ("symbol", "rule", "child", "repeat")
        nodes = [
            (0, new[int(forest.nodes.parent[r])], *(int(getattr(forest.nodes, f)[r]) for f in fields)) for r in rows
        ]
        assert count(forest_of(nodes, num_models=1), [pattern])[0, 0] == together[model]


@pytest.mark.parametrize("text", ["A >> A", "A >> *", "* >> A[>> Leaf.]", "A[>> B + A]", "A[>> A, >> B]"])
def test_deep_trees_are_counted_as_shallow_ones(text):
    forest = random_forest(np.random.default_rng(5), 2, 400, depth=0.999)
    assert brute_force(forest, parse(text)) == count(forest, [parse(text)])[:, 0].tolist()


def test_a_chain_of_a_hundred_thousand_nodes_is_counted():
    size = 100_000
    forest = forest_of([(0, row - 1, 0, 0, 0, 0) for row in range(size)])
    pairs = count(forest, [parse("A >> A")])[0, 0]
    assert pairs == size * (size - 1) / 2


def test_more_ways_than_can_be_told_apart_stay_finite():
    forest = forest_of([(0, -1, 0, 0, 0, 0), *((0, 0, 0, 0, 0, repeat) for repeat in range(1000))])
    pattern = parse("A[" + ", ".join(["A"] * 200) + "]")
    assert count(forest, [pattern])[0, 0] == MAX_EMBEDDINGS


def test_draws():
    nodes = [(model, -1, 0, 0, 0, 0) for model in range(3)]
    forest = forest_of(nodes, [(0, 0, 2.0), (0, 2, 4.0), (1, 0, 8.0), (1, 1, 2.0), (2, 1, 0.0), (2, 1, 2.0)])
    features = [
        Draw("h"),
        Threshold("h", 4.0),
        Draw("A", 2),
        Present(Draw("A", 2)),
        Present(Draw("h")),
        Draw("nothing"),
        Present(parse("A")),
        Formula.of("*", Formula.of("-", Draw("h"), Draw("nothing")), parse("A")),
        Formula.of("+", Formula.of("log", Draw("h")), Threshold("h", 4.0)),
    ]
    assert count(forest, features).tolist() == [
        [3.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 3.0, np.log(3.0) + 1.0],
        [8.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 8.0, np.log(8.0)],
        [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0],
    ]


def test_nothing_to_count():
    forest = forest_of([], num_models=3)
    assert count(forest, [parse("A >> B"), parse("A[B + A]"), Draw("h")]).tolist() == [[0.0] * 3] * 3
    assert count(forest, []).shape == (3, 0)


class Watched(tuple):
    """A tuple that knows how many of its elements were looked at."""

    num = 0

    def __iter__(self):
        for element in super().__iter__():
            self.num += 1
            yield element

    def __getitem__(self, index):
        self.num += 1
        return super().__getitem__(index)


def test_rules_of_other_symbols_are_looked_at_once():
    forest = random_forest(np.random.default_rng(2), 3, 20)
    rules = Watched((*forest.rules, *(replace(forest.rules[0], symbol=f"S{number}") for number in range(200))))
    count(replace(forest, rules=rules), [parse(f"S{number}:0") for number in range(200)])
    assert rules.num <= 2 * len(rules)


def damaged(forest, **columns):
    return replace(forest, nodes=replace(forest.nodes, **columns))


def test_columns_that_make_no_trees_are_refused():
    forest = random_forest(np.random.default_rng(1), 2, 8)
    size = len(forest.nodes)
    ones = np.ones(size, np.int32)
    for columns in (
        {"parent": np.arange(size, dtype=np.int32)},
        {"parent": -7 * ones},
        {"rule": (99 * ones).astype(np.int16)},
        {"symbol": (-1 * ones).astype(np.int16)},
        {"model": 5 * ones},
    ):
        with pytest.raises(UsageError, match="damaged"):
            count(damaged(forest, **columns), [parse("A")])
