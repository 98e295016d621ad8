"""Random choices come as often as the grammar says. Seeds are fixed: a test that passes once passes always."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from grammarlab.derivation import derive
from grammarlab.language.grammar import Grammar

MODELS = 100_000


def drawn(text: str, site: int = 0):
    forest = derive(Grammar.parse(text), MODELS, seed=17)
    chosen = forest.draws.site == site
    return forest.draws.value[chosen], forest.draws.log_density[chosen]


@pytest.mark.parametrize("weights", [(50, 50), (10, 20, 70), (1, 99), (12.5, 12.5, 25, 50)])
def test_branches_are_taken_in_proportion(weights):
    branches = " ".join(f"{weight}% : A{i}" for i, weight in enumerate(weights))
    values, log_density = drawn(f"Lot --> {branches}")
    counts = np.bincount(values.astype(int), minlength=len(weights))
    assert stats.chisquare(counts, np.array(weights) * MODELS / 100).pvalue > 1e-4
    assert np.allclose(np.exp(log_density), np.array(weights)[values.astype(int)] / 100)


def test_else_takes_what_is_left():
    values, _ = drawn("Lot --> 20% : A 30% : B else : C")
    counts = np.bincount(values.astype(int), minlength=3)
    assert stats.chisquare(counts, np.array([0.2, 0.3, 0.5]) * MODELS).pvalue > 1e-4


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (2.0, 5.0), (-3.0, 0.5)])
def test_rand_is_uniform(low, high):
    values, log_density = drawn(f"attr h = rand({low}, {high})\nLot --> A")
    assert stats.kstest(values, stats.uniform(low, high - low).cdf).pvalue > 1e-4
    assert np.allclose(log_density, -np.log(high - low))


def test_p_is_true_as_often_as_it_says():
    values, log_density = drawn("Lot --> case p(0.3) : A else : B")
    assert stats.binomtest(int(values.sum()), MODELS, 0.3).pvalue > 1e-4
    assert np.allclose(np.exp(log_density), np.where(values > 0.5, 0.3, 0.7))


def test_draws_at_different_places_are_independent():
    text = "attr a = rand(1)\nattr b = rand(1)\nLot --> 50% : A else : B"
    forest = derive(Grammar.parse(text), MODELS, seed=17)
    a, b, c = (forest.draws.value[forest.draws.site == site] for site in range(3))
    for x, y in ((a, b), (a, c), (b, c), (a[:-1], a[1:])):
        assert abs(np.corrcoef(x, y)[0, 1]) < 5.0 / np.sqrt(MODELS)


def test_siblings_draw_independently():
    forest = derive(Grammar.parse("Lot --> A A\nA --> 50% : B else : C"), MODELS, seed=17)
    values = forest.draws.value[np.lexsort((forest.draws.node, forest.nodes.model[forest.draws.node]))]
    table = np.histogram2d(values[::2], values[1::2], bins=2)[0]
    chance = float(np.asarray(stats.chi2_contingency(table)[1]))
    assert chance > 1e-4


def test_log_probability_is_the_sum_over_all_draws():
    forest = derive(
        Grammar.parse("attr h = rand(1, 3)\nLot --> 25% : A else : B\nA --> 40% : C else : D"), 1000, seed=1
    )
    first = forest.draws.value[forest.draws.site == 1] == 0
    second = np.full(1000, 1.0)
    second[first] = np.where(forest.draws.value[forest.draws.site == 2] == 0, 0.4, 0.6)
    expected = np.log(0.5) + np.log(np.where(first, 0.25, 0.75)) + np.log(second)
    assert np.allclose(forest.log_probability(), expected)
