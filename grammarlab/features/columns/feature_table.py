"""Tables of features: one row per model, one column per feature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.features.patterns.pattern import Feature
from grammarlab.randomness import fold, root_keys

if TYPE_CHECKING:
    from scipy import sparse

    from grammarlab.features.patterns.node_labels import NodeLabels


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
    labels: NodeLabels | None = None
    """Labels of the nodes of the models; None if they have no nodes."""

    def rows(self) -> Floats:
        """[models, F] the values divided by their scales: the input of a preference."""
        values = self.counts.toarray()
        values /= self.scales
        return values


def distinguishable(tables: Sequence[sparse.csr_array], order: Ints) -> Ints:
    """Columns that distinguish models, one of each equivalent set, in the given order.

    Two columns of integers are equivalent if their difference or their sum is constant.

    Args:
        tables: [models, F] float64, each of further models.
        order: [F] all columns; the first one of a set is kept.
    """
    width = len(order)
    # Other columns are compared by their bits: only equal columns are equivalent.
    is_integer = np.ones(width, dtype=bool)
    for counts in tables:
        is_integer[counts.indices[counts.data.astype(np.int64) != counts.data]] = False
    hashes, sums, num_models = np.zeros((width, 2), np.uint64), np.zeros(2, np.uint64), 0
    for counts in tables:
        models = np.arange(num_models, num_models + size_of(counts)[0])
        weights = np.stack([fold(root_keys(0, models), salt) for salt in (0, 1)])
        hashes += _hashes(counts, is_integer, weights)
        sums += weights.sum(axis=1, dtype=np.uint64)
        num_models += len(models)
    hashes -= _first_bits(tables, is_integer)[:, None] * sums
    mirrored = np.uint64(0) - hashes
    hashes = np.where(hashes[:, :1] > mirrored[:, :1], mirrored, hashes)
    varies: Flags = np.any(hashes, axis=1)
    varying = order[varies[order]]
    _, firsts = np.unique(hashes[varying], axis=0, return_index=True)
    return varying[np.sort(firsts)]


def _hashes(counts: sparse.csr_array, is_integer: Flags, weights: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """[F, 2] sums of the values of each column, as integers or as bits, times the weights [2, models] of models."""
    # Imported here, since a page shows its first pictures without it.
    from scipy import sparse  # noqa: PLC0415

    bits = counts.data.astype(np.int64)
    np.copyto(bits, counts.data.view(np.int64), where=~is_integer[counts.indices])
    return sparse.csr_array((bits.view(np.uint64), counts.indices, counts.indptr), shape=counts.shape).T @ weights.T


def _first_bits(tables: Sequence[sparse.csr_array], is_integer: Flags) -> NDArray[np.uint64]:
    """[F] values of the first model, as integers or as bits; zeros without models."""
    table = next((counts for counts in tables if size_of(counts)[0]), None)
    first = np.zeros(len(is_integer)) if table is None else table[[0], :].toarray()[0]
    return np.where(is_integer, first.astype(np.int64), first.view(np.int64)).astype(np.uint64)


def size_of(counts: sparse.csr_array) -> tuple[int, int]:
    """Models and columns."""
    return counts.shape or (0, 0)
