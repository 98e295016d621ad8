"""Tables of features: one row per model, one column per feature."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.features.patterns.pattern import Feature
from grammarlab.randomness import fold, root_keys

if TYPE_CHECKING:
    from scipy import sparse


@dataclass(frozen=True)
class FeatureTable:
    """Features of models."""

    counts: sparse.csr_array
    """[models, F] float64: counts, and values of draws."""
    features: tuple[Feature, ...]
    """[F] features of the columns."""
    names: tuple[str, ...]
    """[F] readable names, all different."""
    groups: Ints
    """[F] index into `group_names`: alternatives of one choice in one context share a group."""
    group_names: tuple[str, ...]
    scales: Floats
    """[F] a typical difference between models, > 0: 1 for counts, the range of the draws for draws."""
    logarithmic: Flags | None = None
    """[F] whether values are logarithms of the features; None if none is."""
    priors: Floats | None = None
    """[F] how likely columns are to matter to a person, relative to each other; None if all are equally likely."""

    def rows(self) -> Floats:
        """[models, F] the values divided by their scales: the input of a preference."""
        return self.counts.toarray() / self.scales


def distinguishable(counts: sparse.csr_array, order: Ints) -> Ints:
    """Columns that distinguish models, one of each equivalent set, in the given order.

    Two columns of integers are equivalent if their difference or their sum is constant.

    Args:
        counts: [models, F] float64.
        order: [F] all columns; the first one of a set is kept.
    """
    # Imported here, since a page shows its first pictures without it.
    from scipy import sparse  # noqa: PLC0415

    num_models, width = size_of(counts)
    models = np.arange(num_models, dtype=np.int64)
    weights = np.stack([fold(root_keys(0, models), salt) for salt in (0, 1)])
    # Other columns are compared by their bits: only equal columns are equivalent.
    bits = counts.data.astype(np.int64)
    is_integer = np.bincount(counts.indices[bits != counts.data], minlength=width) == 0
    np.copyto(bits, counts.data.view(np.int64), where=~is_integer[counts.indices])
    hashes = (
        sparse.csr_array((bits.view(np.uint64), counts.indices, counts.indptr), shape=(num_models, width)).T @ weights.T
    )
    first = counts[[0], :].toarray()[0] if num_models else np.zeros(width)
    first = np.where(is_integer, first.astype(np.int64), first.view(np.int64)).astype(np.uint64)
    hashes -= first[:, None] * weights.sum(axis=1, dtype=np.uint64)
    mirrored = np.uint64(0) - hashes
    hashes = np.where(hashes[:, :1] > mirrored[:, :1], mirrored, hashes)
    varying = order[hashes.any(axis=1)[order]]
    _, firsts = np.unique(hashes[varying], axis=0, return_index=True)
    return varying[np.sort(firsts)]


def size_of(counts: sparse.csr_array) -> tuple[int, int]:
    """Models and columns."""
    return counts.shape or (0, 0)
