"""A common low-dimensional space of elements from their deformations by all templates (paper 001, section 5.4.2).

Dong, Frossard, Vandergheynst and Nefedov, "Clustering on multi-layer graphs via subspace analysis on Grassmann
manifolds": L_mod = sum_j L_j - alpha sum_j U_j U_j^T, whose lowest eigenvectors are near to all U_j.
"""

from __future__ import annotations

import numpy as np

from grammarlab.facade.templates.elements import Floats

ALPHA = 0.5
MOST_DIMENSIONS = 10


def laplacian(weights: Floats) -> Floats:
    """[N, N] normalised Laplacian of a graph of symmetric weights [N, N] >= 0."""
    degree = 1.0 / np.sqrt(np.maximum(weights.sum(axis=1), 1e-12))
    return np.eye(len(weights)) - degree[:, None] * weights * degree


def lowest(matrix: Floats, dimensions: int) -> Floats:
    """[N, dimensions] eigenvectors of the smallest eigenvalues of a symmetric matrix."""
    return np.linalg.eigh(matrix)[1][:, :dimensions]


def merged(weights: Floats, dimensions: int) -> Floats:
    """[N, dimensions] common basis of the graphs [J, N, N]."""
    laplacians = [laplacian(each) for each in weights]
    modified = np.sum(laplacians, axis=0)
    for each in laplacians:
        basis = lowest(each, dimensions)
        modified -= ALPHA * basis @ basis.T
    return lowest(modified, dimensions)


def weights_of(parameters: Floats, scale: float) -> Floats:
    """[T, N, N] weights exp(-|d_i - d_k|^2) of deformations [N, T, D], in units of a length (Equation 5.2)."""
    away = (parameters[:, None] - parameters[None]) / scale
    return np.moveaxis(np.exp(-(away**2).sum(axis=-1)), -1, 0)


def dimensions_of(weights: Floats) -> int:
    """Number of eigenvectors to keep: up to the largest gap between the mean eigenvalues of all graphs [T, N, N]."""
    values = np.mean([np.linalg.eigvalsh(laplacian(each)) for each in weights], axis=0)
    # The value after the last one is that of another, distant element: so a few elements may all be separate.
    return 1 + int(np.argmax(np.diff(np.append(values, 1.0)[: MOST_DIMENSIONS + 2])))


def similarity(basis: Floats) -> Floats:
    """[N, N] similarity of elements from 0 to 1, by their Euclidean distance in a space [N, K]; 0 on the diagonal."""
    rows = basis / np.maximum(np.linalg.norm(basis, axis=1, keepdims=True), 1e-12)
    distance = np.linalg.norm(rows[:, None] - rows[None], axis=-1)
    near = np.exp(-((distance / 0.5) ** 2))
    np.fill_diagonal(near, 0.0)
    return near
