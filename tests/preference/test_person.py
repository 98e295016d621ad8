"""What a score says about the value that was meant."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from grammarlab.preference.person import expected_score, log_likelihood, mean_value, value_of

ERRING = [(0.5, 0.0), (3.0, 0.1), (10.0, 0.002), (28.0, 0.25)]


@pytest.mark.parametrize(("noise", "blunders"), ERRING)
def test_all_scores_of_a_scale_together_are_certain(noise, blunders):
    values = np.array([0.0, 3.0, 50.0, 99.0, 100.0])
    found = np.exp(log_likelihood(np.arange(0.0, 101.0), values, noise, blunders).astype(np.float64))
    np.testing.assert_allclose(found.sum(axis=0), 1.0, atol=1e-5)


@pytest.mark.parametrize(("noise", "blunders"), ERRING)
def test_a_score_has_the_mass_of_its_interval(noise, blunders):
    found = np.exp(log_likelihood(np.array([40.0]), np.array([47.0]), noise, blunders)[0, 0])
    mass, _ = quad(lambda y: norm.pdf(y, 47.0, noise), 39.5, 40.5)
    assert found == pytest.approx((1.0 - blunders) * mass + blunders / 100.0, rel=1e-4, abs=1e-9)


def test_noise_alone_makes_the_ends_of_the_scale_likely():
    at_ends = np.exp(log_likelihood(np.array([0.0, 100.0]), np.array([0.0, 100.0]), 20.0, 0.0))
    assert at_ends[0, 0] > 0.5
    assert at_ends[1, 1] > 0.5


@pytest.mark.parametrize(("noise", "blunders"), ERRING)
@pytest.mark.parametrize("value", [0.0, 5.0, 50.0, 93.0, 100.0])
def test_the_mean_score_is_that_of_clipped_noise(noise, blunders, value):
    clipped, _ = quad(
        lambda e: np.clip(value + e, 0.0, 100.0) * norm.pdf(e, 0.0, noise),
        -8.0 * noise,
        8.0 * noise,
        points=[p for p in (-value, 100.0 - value) if abs(p) < 8.0 * noise],
        limit=200,
    )
    expected = (1.0 - blunders) * clipped + 50.0 * blunders
    assert expected_score(np.array([value]), noise, blunders)[0] == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(("noise", "blunders"), ERRING)
def test_the_value_of_a_mean_score_is_the_one_it_is_the_mean_of(noise, blunders):
    values = np.linspace(0.0, 100.0, 41)
    np.testing.assert_allclose(value_of(expected_score(values, noise, blunders), noise, blunders), values, atol=0.05)


@pytest.mark.parametrize("noise", [5.0, 10.0, 20.0])
def test_the_mean_value_is_that_of_a_normal_mean_score(noise):
    means, sds = (grid.ravel() for grid in np.meshgrid(np.linspace(0.0, 100.0, 21), [1.0, 5.0, 10.0, 20.0]))
    points = np.linspace(-8.0, 8.0, 4_001)
    masses = norm.pdf(points) / norm.pdf(points).sum()
    expected = masses @ value_of(means + points[:, None] * sds, noise, 0.0)
    assert np.abs(mean_value(means, sds, noise) - expected).mean() < 0.08
