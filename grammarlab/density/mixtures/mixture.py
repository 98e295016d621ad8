"""Mixtures of stochastic grammars, fitted to derivations by expectation maximisation.

A component has a probability for every branch of every choice, and a derivation is described by its counts of
branches: so the log-probabilities of N derivations under K components are one matrix product. Probabilities are stored
as ratios to those of the original grammar, so that choices that are not learned drop out.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.special import xlogy

from grammarlab.arrays import Ints
from grammarlab.errors import GrammarlabError

Floats = NDArray[np.float64]

MOST_STEPS = 250
TOLERANCE = 1e-6
_NEVER = -1e30
"""Replacement for the logarithm of 0, since its product with a count of 0 would be NaN."""
_MOST_DENSE = 50_000_000
"""Largest size of dense tables of counts; larger ones are sparse."""


@dataclass(frozen=True, slots=True)
class Cells:
    """The branches whose probabilities are learned."""

    original: Floats
    """[A] probability of each in the original grammar; those of one choice sum to 1."""
    choice: Ints
    """[A] choice of each cell, ascending from 0."""

    def normalised(self, counts: Floats) -> Floats:
        """Maximum-likelihood probabilities [K, A] for counts [K, A]; the original ones for choices without counts."""
        starts = np.flatnonzero(np.diff(self.choice, prepend=-1))
        total = np.add.reduceat(counts, starts, axis=1)[:, self.choice] if len(starts) else counts
        return np.where(total > 0.0, counts / np.where(total > 0.0, total, 1.0), self.original)


@dataclass(frozen=True, slots=True)
class Mixture:
    """K components."""

    weights: Floats
    """[K] probability of each component, summing to 1 (alpha in Eq. 4.9)."""
    probabilities: Floats
    """[K, A] probability of each cell."""

    def log_ratios(self, cells: Cells, counts: sparse.csr_array | Floats) -> Floats:
        """[N, K] log of weight times density of derivations under each component, divided by their original density."""
        with np.errstate(divide="ignore"):
            ratio = np.log(self.probabilities) - np.log(np.where(cells.original > 0.0, cells.original, 1.0))
            each = dense(counts @ np.maximum(ratio, _NEVER).T)
            each[each < 0.5 * _NEVER] = -np.inf
            return each + np.log(self.weights)

    def log_ratio(self, cells: Cells, counts: sparse.csr_array) -> Floats:
        """[N] log of the density of derivations divided by their original density (Eq. 4.9); -inf where it is 0."""
        return np.logaddexp.reduce(self.log_ratios(cells, counts), axis=1)


@dataclass(frozen=True, slots=True)
class MixtureFit:
    """A fitted mixture."""

    mixture: Mixture
    log_likelihoods: tuple[float, ...]
    """Mean log of the density divided by the original density, in nats, before each step and after the last."""


def maximised(cells: Cells, counts: sparse.csr_array | Floats, responsibilities: Floats) -> Mixture:
    """Maximum-likelihood mixture for given responsibilities (Eq. 4.11).

    Args:
        cells: what is learned.
        counts: [N, A] counts of cells in each derivation.
        responsibilities: [N, K] times the weight of each derivation; components without derivations are dropped.
    """
    used = responsibilities.sum(axis=0)
    share = responsibilities[:, used > 0.0]
    return Mixture(used[used > 0.0] / used.sum(), cells.normalised(dense(counts.T @ share).T))


def fit_mixture(
    cells: Cells, counts: sparse.csr_array, weights: Floats, component: Ints, tolerance: float = TOLERANCE
) -> MixtureFit:
    """The mixture of grammars that EM finds for a sample.

    Args:
        cells: what is learned.
        counts: [N, A] how often each derivation took each cell.
        weights: [N] how much each derivation counts, >= 0 and not all 0.
        component: [N] the component to begin with, 0 <= component < N.
        tolerance: smallest gain in mean log-likelihood of a step, in nats, before the fit ends.

    Raises:
        GrammarlabError: If all weights are 0.
    """
    if not weights.sum() > 0.0:
        raise GrammarlabError("expected derivations to learn from, found none that counts")
    counts, weights, component = distinct_derivations(counts, weights, component)
    share = np.zeros((len(weights), int(component.max()) + 1))
    share[np.arange(len(weights)), component] = weights
    mixture = maximised(cells, counts, share)
    table = counts.toarray() if len(weights) * len(cells.original) <= _MOST_DENSE else counts
    found: list[float] = []
    for _ in range(MOST_STEPS):
        each = mixture.log_ratios(cells, table)
        most = each.max(axis=1)
        share = np.exp(each - most[:, None])
        total = share.sum(axis=1)
        found.append(float(weights @ (np.log(total) + most) / weights.sum()))
        if len(mixture.weights) == 1 or (len(found) > 1 and found[-1] - found[-2] < tolerance):
            break
        # Eq. 4.10
        mixture = maximised(cells, table, share * (weights / total)[:, None])
    return MixtureFit(mixture, tuple(found))


def distinct_derivations(
    counts: sparse.csr_array, weights: Floats, component: Ints
) -> tuple[sparse.csr_array, Floats, Ints]:
    """Derivations with a weight; those with equal counts and the same component are merged."""
    used = weights > 0.0
    counts, weights, component = counts[used], weights[used], component[used]
    counts.sum_duplicates()
    known: dict[tuple[int, bytes, bytes], int] = {}
    number = np.zeros(len(weights), dtype=np.int64)
    for row, (start, end) in enumerate(pairwise(counts.indptr)):
        key = int(component[row]), counts.indices[start:end].tobytes(), counts.data[start:end].tobytes()
        number[row] = known.setdefault(key, len(known))
    _, first = np.unique(number, return_index=True)
    return counts[first], np.bincount(number, weights=weights).astype(np.float64), component[first]


def complete_log_likelihood(cells: Cells, counts: Floats) -> Floats:
    """Log-likelihood of derivations under one component with maximum-likelihood probabilities.

    Args:
        cells: what is learned.
        counts: [..., A] how often the derivations took each cell altogether.

    Returns:
        [...] sum of logarithms, without the original density.
    """
    starts = np.flatnonzero(np.diff(cells.choice, prepend=-1))
    total = np.add.reduceat(counts, starts, axis=-1) if len(starts) else np.zeros((*counts.shape[:-1], 1))
    return xlogy(counts, counts).sum(axis=-1) - xlogy(total, total).sum(axis=-1)


def dense(product: sparse.csr_array | Floats) -> Floats:
    """A product with a sparse table as an ordinary array."""
    return product.toarray() if sparse.issparse(product) else np.asarray(product)  # type: ignore[union-attr]
