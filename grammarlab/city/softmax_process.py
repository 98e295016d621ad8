"""Softmax regression with Gaussian weights: the mode of the weights and the evidence of the design.

The model: answer i has zone k with probability softmax_k(φ_i · v_k), and all weights v have the distribution N(0, 1).
A Gaussian process is such a model: its kernel is a product φ φ' (C. Rasmussen and C. Williams, *Gaussian Processes for
Machine Learning*, 2006, section 2.1.2), and the scales of the columns of φ are its hyperparameters.

Adding one number to all v_k changes nothing, so the weights are written in K - 1 orthonormal contrasts Q: v = Q u.
Their distribution is the same, N(0, 1), and the evidence is unchanged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize
from scipy.special import softmax

from grammarlab.arrays import Floats

_MAX_ITERATIONS = 2000
_TOLERANCE = 1e-5
"""Largest slope of the log-posterior at the mode, per standard deviation of the prior."""


@dataclass(frozen=True, slots=True, eq=False)
class Mode:
    """The weights that are most probable."""

    weights: Floats
    """[D, K - 1] in contrasts: u."""
    value: float
    """Log-likelihood minus half the square of the weights."""


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """The Laplace approximation at the mode."""

    mode: Mode
    value: float
    """Logarithm of the evidence."""
    slope: Floats
    """[n, D] change of the evidence with each entry of the design."""
    covariance: Floats
    """[K - 1, D, K - 1, D] covariance of the weights."""


def contrasts(num: int) -> Floats:
    """[K, K - 1] orthonormal columns with the sum 0.

    >>> contrasts(2).round(3).tolist()
    [[0.707], [-0.707]]
    """
    columns = np.tril(np.ones((num, num - 1)), -1)
    index = np.arange(num - 1)
    columns[index, index] = -(num - 1.0 - index)
    return -columns / np.linalg.norm(columns, axis=0)


def mode_of(design: Floats, counts: Floats, start: Floats | None = None) -> Mode:
    """The most probable weights; the problem is convex and has one solution.

    Args:
        design: [n, D] rows φ.
        counts: [n, K] how often each zone was the answer, >= 0; fractions are weights of answers.
        start: [D, K - 1] weights to start from.
    """
    basis, num = contrasts(counts.shape[1]), counts.sum(axis=1)
    shape = (design.shape[1], basis.shape[1])

    def negative(flat: Floats) -> tuple[float, Floats]:
        odds = design @ flat.reshape(shape) @ basis.T
        odds -= odds.max(axis=1, keepdims=True)
        chance = np.exp(odds)  # in place of functions of scipy, which take most of the time for few answers
        total = chance.sum(axis=1, keepdims=True)
        value = np.vdot(counts, odds) - num @ np.log(total[:, 0]) - 0.5 * flat @ flat
        residual = counts - (num[:, None] / total) * chance
        return -float(value), flat - (design.T @ (residual @ basis)).ravel()

    flat = np.zeros(shape).ravel() if start is None else start.ravel()
    options = {"maxiter": _MAX_ITERATIONS, "maxfun": 2 * _MAX_ITERATIONS, "gtol": _TOLERANCE, "ftol": 0.0, "maxcor": 12}
    result = minimize(negative, flat, jac=True, method="L-BFGS-B", options=options)
    return Mode(result.x.reshape(shape), -float(result.fun))


def evidence_of(design: Floats, counts: Floats, start: Floats | None = None) -> Evidence:
    """The evidence of a design, with its slope (Rasmussen and Williams 2006, sections 3.5 and 5.5.1).

    Args:
        design: [n, D] rows φ.
        counts: [n, K] as for `mode_of`.
        start: [D, K - 1] weights to start from.
    """
    mode = mode_of(design, counts, start)
    basis, num = contrasts(counts.shape[1]), counts.sum(axis=1)
    odds = design @ mode.weights @ basis.T
    chance = softmax(odds, axis=1)
    curvature = fisher_information(chance, num)
    factor = cho_factor(_precision(design, curvature), lower=True)
    size = curvature.shape[1]
    covariance = cho_solve(factor, np.eye(len(factor[0]))).reshape(size, -1, size, design.shape[1])

    # Half the logarithm of the determinant depends on the design directly, and through the curvature at the mode.
    spread, direct = np.zeros_like(curvature), np.zeros_like(design)
    for one in range(size):
        for other in range(size):
            product = design @ covariance[one, :, other]
            spread[:, one, other] = (product * design).sum(axis=1)
            direct += curvature[:, one, other, None] * product
    in_zones = basis @ spread @ basis.T
    third = 0.5 * np.einsum("ikk->ik", in_zones) - (in_zones @ chance[:, :, None])[:, :, 0]
    through = (num[:, None] * chance * (third - (chance * third).sum(axis=1)[:, None])) @ basis
    response = cho_solve(factor, (design.T @ through).T.ravel()).reshape(size, -1).T
    residual = (counts - num[:, None] * chance) @ basis
    bent = (curvature @ (design @ response)[:, :, None])[:, :, 0]
    slope = (residual - through + bent) @ mode.weights.T - residual @ response.T - direct
    value = mode.value - np.log(np.diag(factor[0])).sum()
    return Evidence(mode, float(value), slope, covariance)


def fisher_information(chance: Floats, num: Floats) -> Floats:
    """[n, K - 1, K - 1] information of `num` [n] answers about the log-odds in contrasts, from chances [n, K]."""
    basis = contrasts(chance.shape[1])
    mean = chance @ basis
    return num[:, None, None] * (np.einsum("ik,ka,kb->iab", chance, basis, basis) - mean[:, :, None] * mean[:, None, :])


def _precision(design: Floats, curvature: Floats) -> Floats:
    """[(K - 1) D, (K - 1) D] inverse of the covariance of the weights."""
    size, width = curvature.shape[1], design.shape[1]
    precision = np.zeros((size, width, size, width))
    for one in range(size):
        for other in range(one + 1):
            precision[one, :, other] = precision[other, :, one] = design.T @ (curvature[:, one, other, None] * design)
    return precision.reshape(size * width, -1) + np.eye(size * width)
