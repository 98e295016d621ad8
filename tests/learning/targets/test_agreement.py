import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.stats import entropy, pearsonr

from grammarlab.learning.targets.divergence import agreement

COLUMN = arrays(np.float64, 7, elements=st.floats(0.01, 100))


@given(COLUMN, COLUMN, COLUMN)
def test_divergence_and_correlation_are_those_of_scipy(wanted, learned, weights):
    found = agreement(wanted, learned, weights)
    p, q = (density / density.sum() for density in (weights * wanted, weights * learned))
    assert found.js == pytest.approx((entropy(p, (p + q) / 2) + entropy(q, (p + q) / 2)) / 2, abs=1e-12)
    assert 0 <= found.js <= np.log(2)
    if np.ptp(weights * wanted) > 1e-6 and np.ptp(weights * learned) > 1e-6:
        assert found.correlation == pytest.approx(pearsonr(weights * wanted, weights * learned)[0], abs=1e-6)


@given(COLUMN, st.floats(0.01, 100))
def test_only_ratios_count(wanted, factor):
    found = agreement(wanted, factor * wanted, np.full(7, factor))
    assert found.js == pytest.approx(0, abs=1e-12)


def test_negative_predictions_count_as_zero():
    wanted = np.array([1.0, 2.0, 0.0])
    assert agreement(wanted, np.array([1.0, 2.0, -5.0]), np.ones(3)).js == pytest.approx(0, abs=1e-15)


def test_a_preference_that_is_zero_everywhere_leaves_the_grammar_as_it_is():
    wanted, weights = np.array([1.0, 2.0, 0.0]), np.array([1.0, 2.0, 3.0])
    assert agreement(wanted, np.zeros(3), weights) == agreement(wanted, np.ones(3), weights)


def test_constant_weights_have_no_correlation():
    assert agreement(np.array([1.0, 2.0]), np.ones(2), np.ones(2)).correlation == 0
