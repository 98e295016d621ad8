"""Arithmetic on columns of 3-vectors, written out per coordinate.

So a row has the same last bits alone and in any batch (NumPy's general reductions do not guarantee this),
and columns of three are several times faster.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats


def dot(a: Floats, b: Floats) -> Floats:
    """[...] scalar products of vectors [..., 3]."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def cross(a: Floats, b: Floats) -> Floats:
    """[..., 3] vector products of vectors [..., 3]."""
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    product[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    product[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    product[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def norm(a: Floats) -> Floats:
    """[...] lengths of vectors [..., 3]."""
    return np.sqrt(dot(a, a))


def has_length(a: Floats) -> NDArray[np.bool_]:
    """[..., 1] whether vectors [..., 3] are not zero, as a mask for vectors."""
    return (a[..., 0:1] != 0.0) | (a[..., 1:2] != 0.0) | (a[..., 2:3] != 0.0)


def unit(a: Floats) -> Floats:
    """Vectors [..., 3] at length 1; zero vectors stay zero."""
    length = norm(a)[..., None]
    return np.divide(a, length, out=np.zeros(a.shape), where=length > 0.0)


def apply(matrices: Floats, vectors: Floats) -> Floats:
    """[N, 3] matrices [N, 3, 3] times vectors [N, 3]."""
    return (
        matrices[:, :, 0] * vectors[:, 0:1] + matrices[:, :, 1] * vectors[:, 1:2] + matrices[:, :, 2] * vectors[:, 2:3]
    )


def apply_transposed(matrices: Floats, vectors: Floats) -> Floats:
    """[N, 3] transposed matrices [N, 3, 3] times vectors [N, 3]: for rotations, the inverse."""
    return apply(np.swapaxes(matrices, 1, 2), vectors)


def any_normal(vectors: Floats) -> Floats:
    """[N, 3] unit vectors at right angles to non-zero vectors [N, 3]; x for zero vectors."""
    axis = np.zeros_like(vectors)
    axis[np.arange(len(vectors)), np.argmin(np.abs(vectors), axis=1)] = 1.0
    result = unit(cross(vectors, axis))
    return np.where(has_length(vectors), result, [1.0, 0.0, 0.0])
