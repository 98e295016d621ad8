"""Common parameters of elements, by the threshold of the paper (section 5.4.4)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from grammarlab.facade.templates.elements import Floats, Ints

THRESHOLD = 0.005
"""Fraction of the largest diagonal of a box."""


def close(values: Floats, threshold: float) -> np.ndarray:
    """[D, N, N] c: whether parameters [N, D] of two elements differ by less than a threshold."""
    moved = values.T
    return np.abs(moved[:, :, None] - moved[:, None, :]) < threshold


def couplings(owner: Ints, values: Floats, used: Floats, threshold: float) -> Floats:
    """[T, D, N, N] couplings of Equation 5.4: for elements of one template, and for replicas in all templates.

    Args:
        owner: [N] template of each element.
        values: [N, D] parameters of its label.
        used: [T, D] 1 for the parameters of a template.
        threshold: largest difference, metres.
    """
    number = len(owner)
    near = close(values, threshold)
    same = (owner[:, None] == owner[None]) & ~np.eye(number, dtype=bool)
    replica = near.all(axis=0) & same
    coupled = np.zeros((len(used), values.shape[1], number, number))
    for template in range(len(used)):
        own = same & (owner == template)[:, None]
        coupled[template] = (near & own) | replica
        coupled[template] *= used[template][:, None, None]
    return coupled


def replicas(owner: Ints, values: Floats, threshold: float) -> Ints:
    """[N] kind of each element, from 0: connected components of replicas."""
    near = close(values, threshold).all(axis=0) & (owner[:, None] == owner[None])
    return connected_components(csr_matrix(near), directed=False)[1].astype(np.int64)
