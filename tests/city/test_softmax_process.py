"""Softmax regression against brute force: the mode, the evidence, and its slope."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import log_softmax, softmax
from scipy.stats import norm

from grammarlab.city.softmax_process import contrasts, evidence_of, fisher_information, mode_of


def problem(num: int = 12, width: int = 3, zones: int = 3) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(num + width + zones)
    return rng.normal(size=(num, width)), np.eye(zones)[rng.integers(0, zones, num)]


@pytest.mark.parametrize("zones", [2, 3, 7])
def test_contrasts_are_orthonormal_and_sum_to_zero(zones: int):
    basis = contrasts(zones)
    np.testing.assert_allclose(basis.T @ basis, np.eye(zones - 1), atol=1e-12)
    np.testing.assert_allclose(basis.sum(axis=0), 0.0, atol=1e-12)


def test_the_mode_is_the_optimum_over_the_weights_of_all_zones():
    """Weights of K zones with the prior N(0, 1), found without slopes and without contrasts."""
    design, counts = problem()

    def negative(flat: np.ndarray) -> float:
        weights = flat.reshape(3, 3)
        return 0.5 * flat @ flat - (counts * log_softmax(design @ weights, axis=1)).sum()

    best = minimize(negative, np.zeros(9), method="Powell", options={"xtol": 1e-9, "ftol": 1e-14})
    mode = mode_of(design, counts)
    np.testing.assert_allclose(mode.weights @ contrasts(3).T, best.x.reshape(3, 3), atol=1e-4)
    assert mode.value == pytest.approx(-best.fun, abs=1e-9)


def test_the_mode_is_the_same_from_any_start():
    design, counts = problem()
    start = np.random.default_rng(0).normal(0, 3, (3, 2))
    np.testing.assert_allclose(mode_of(design, counts, start).weights, mode_of(design, counts).weights, atol=1e-5)


def test_rows_may_be_repeated_or_counted():
    design, counts = problem()
    repeated = mode_of(np.repeat(design, 2, axis=0), np.repeat(counts, 2, axis=0))
    np.testing.assert_allclose(mode_of(design, 2 * counts).weights, repeated.weights, atol=1e-5)


def test_the_evidence_is_the_integral_over_the_weights():
    """By quadrature over the two weights of two zones, many answers, where the Laplace approximation is good."""
    design, counts = problem(120, 2, 2)
    scale = 0.7
    axis = np.linspace(-4, 4, 161)
    first, second = np.meshgrid(axis, axis, indexing="ij")
    weights = np.stack([first.ravel(), second.ravel()])
    log_likelihood = np.zeros(weights.shape[1])
    for row, count in zip(scale * design, counts, strict=True):
        odds = (row @ weights)[:, None] * contrasts(2)[:, 0]
        log_likelihood += (count * log_softmax(odds, axis=1)).sum(axis=1)
    density = norm.pdf(weights).prod(axis=0)
    integral = np.log((np.exp(log_likelihood) * density).sum() * (axis[1] - axis[0]) ** 2)
    assert evidence_of(scale * design, counts).value == pytest.approx(integral, abs=0.015)


def test_the_evidence_of_no_design_is_the_likelihood_of_equal_chances():
    _, counts = problem()
    assert evidence_of(np.zeros((12, 3)), counts).value == pytest.approx(-12 * np.log(3))


@pytest.mark.parametrize("zones", [2, 3, 4])
def test_the_slope_of_the_evidence_is_its_difference(zones: int):
    design, counts = problem(15, 4, zones)
    rng = np.random.default_rng(1)
    counts = counts * rng.integers(1, 4, (15, 1)).astype(np.float64)
    slope = evidence_of(design, counts).slope
    for _ in range(3):
        direction = rng.normal(size=design.shape)
        ends = [evidence_of(design + step * direction, counts).value for step in (1e-3, -1e-3)]
        assert (slope * direction).sum() == pytest.approx((ends[0] - ends[1]) / 2e-3, rel=1e-4, abs=1e-4)


def test_the_covariance_is_the_inverse_of_the_second_derivative():
    design, counts = problem()
    evidence = evidence_of(design, counts)
    curvature = fisher_information(softmax(design @ evidence.mode.weights @ contrasts(3).T, axis=1), np.ones(12))
    precision = np.einsum("ip,iab,iq->apbq", design, curvature, design).reshape(6, 6) + np.eye(6)
    np.testing.assert_allclose(evidence.covariance.reshape(6, 6) @ precision, np.eye(6), atol=1e-6)


def test_the_evidence_depends_on_the_order_of_neither_answers_nor_zones():
    design, counts = problem()
    order = np.arange(12)[::-1]
    expected = evidence_of(design, counts).value
    assert evidence_of(design[order], counts[order]).value == pytest.approx(expected, abs=1e-7)
    assert evidence_of(design, counts[:, [2, 0, 1]]).value == pytest.approx(expected, abs=1e-7)
