"""Divergence and correlation of densities."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.distance import jensenshannon
from scipy.stats import pearsonr

from grammarlab.errors import UsageError
from grammarlab.learning.targets.divergence import correlation, jensen_shannon

WEIGHTS = st.lists(st.tuples(*[st.one_of(st.just(0.0), st.floats(1e-12, 1e12))] * 2), min_size=1, max_size=20).filter(
    lambda pairs: any(p for p, _ in pairs) and any(q for _, q in pairs)
)


@given(WEIGHTS)
def test_the_divergence_is_that_of_scipy(pairs):
    p, q = np.array(pairs).T
    # scipy gives the square root, and NaN where rounding takes it below 0.
    expected = np.nan_to_num(jensenshannon(p / p.max(), q / q.max())) ** 2
    assert jensen_shannon(p, q) == pytest.approx(expected, rel=1e-9, abs=1e-15)


@given(WEIGHTS, st.floats(1e-6, 1e6))
def test_it_is_symmetric_bounded_and_blind_to_scale_and_order(pairs, scale):
    p, q = np.array(pairs).T
    value = jensen_shannon(p, q)
    assert 0 <= value <= np.log(2)
    assert value == pytest.approx(jensen_shannon(q, p), rel=1e-12, abs=1e-15)
    assert value == pytest.approx(jensen_shannon(scale * p, q), rel=1e-9, abs=1e-15)
    assert value == pytest.approx(jensen_shannon(p[::-1], q[::-1]), rel=1e-9, abs=1e-15)
    assert jensen_shannon(p, scale * p) == pytest.approx(0, abs=1e-15)


@given(WEIGHTS)
def test_models_of_equal_weight_may_be_taken_together(pairs):
    p, q = np.array(pairs).T
    assert jensen_shannon(np.repeat(p, 3), np.repeat(q, 3)) == pytest.approx(jensen_shannon(p, q), rel=1e-9, abs=1e-15)


def test_values_known_by_hand():
    assert jensen_shannon([1, 0], [0, 5]) == np.log(2)
    # A preference that likes a share s of all models: the divergence of an indicator from the uniform density.
    s = 0.25
    expected = 0.5 * (np.log(2 / (1 + s)) + s * np.log(2 * s / (1 + s)) + (1 - s) * np.log(2))
    assert jensen_shannon([1, 0, 0, 0], [1, 1, 1, 1]) == pytest.approx(expected)


def test_huge_and_tiny_weights_do_not_overflow():
    assert jensen_shannon([1e308, 1e308, 0], [1e-308, 1e-308, 0]) == pytest.approx(0, abs=1e-15)
    assert jensen_shannon([1e308, 1e308], [0, 1e-300]) == pytest.approx(jensen_shannon([1, 1], [0, 1]))


@given(WEIGHTS.filter(lambda pairs: len(pairs) > 2))
def test_correlation_is_pearsons(pairs):
    p, q = np.array(pairs).T
    assert correlation(p, p) == pytest.approx(1) or np.ptp(p / p.max()) < 1e-9
    assert abs(correlation(p, q)) <= 1
    if min(np.ptp(p / p.max()), np.ptp(q / q.max())) > 1e-3:
        assert correlation(p, q) == pytest.approx(pearsonr(p / p.max(), q / q.max())[0], abs=1e-9)


def test_a_constant_correlates_with_nothing():
    assert correlation([1, 1, 1], [1, 2, 3]) == correlation([1, 2, 3], [1 / 3] * 3) == 0


@pytest.mark.parametrize("measure", [jensen_shannon, correlation])
@pytest.mark.parametrize(
    ("p", "says"),
    [
        ([0, 0], "zeros only"),
        ([1, np.nan], "1 of 2 that are not, nan first"),
        ([1, np.inf], "inf first"),
        ([1, -1e-9], "-1e-09 first"),
        ([], "no weights"),
        ([[1, 2]], "shape (1, 2)"),
        ([1, 2, 3], "over the same models, found 3 and 2"),
    ],
)
def test_weights_that_are_no_density_are_refused(measure, p, says):
    with pytest.raises(UsageError) as caught:
        measure(p, [1, 2])
    assert says in str(caught.value)
