"""Mixtures of stochastic grammars, fitted to derivations by expectation maximisation from clusters of models.

A component has a probability for every branch of every choice, and a derivation is described by its counts of
branches: so the log-probabilities of N derivations under K components are one matrix product. Probabilities are stored
as ratios to those of the original grammar, so that choices that are not learned drop out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import sparse
from scipy.spatial.distance import cdist
from scipy.special import xlogy

from grammarlab.arrays import BATCH, MAX_STEPS, Floats, Ints
from grammarlab.errors import GrammarlabError

_TOLERANCE = 1e-6
"""Smallest gain of the mean log-likelihood of a step, in nats, before EM ends."""
_NEIGHBOUR_SHARE = 1e-3
"""Neighbours differ by less than this share of the largest difference (section 4.6)."""
_LOG_OF_ZERO = float(np.finfo(np.float32).min)
"""Replacement for the logarithm of 0, since its product with a count of 0 would be NaN."""
HELD_OUT_STRIDE = 5
"""One model in 5 is held out to choose the number of components."""
SMOOTHING = 0.5
"""Number of derivations by the original grammar in each component, before held-out models are evaluated."""
_MAX_DENSE = 50_000_000
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
            log_densities = dense(counts @ np.maximum(ratio, _LOG_OF_ZERO).T)
            log_densities[log_densities < 0.5 * _LOG_OF_ZERO] = -np.inf
            return log_densities + np.log(self.weights)

    def log_ratio(self, cells: Cells, counts: sparse.csr_array) -> Floats:
        """[N] log of the density of derivations divided by their original density (Eq. 4.9); -inf where it is 0."""
        return np.logaddexp.reduce(self.log_ratios(cells, counts), axis=1)


@dataclass(frozen=True, slots=True)
class MixtureFit:
    """A fitted mixture."""

    mixture: Mixture
    log_likelihoods: tuple[float, ...]
    """Mean log of the density divided by the original density, in nats, before each step and after the last."""


def fit_mixture(
    cells: Cells, counts: sparse.csr_array, weights: Floats, component: Ints, tolerance: float = _TOLERANCE
) -> MixtureFit:
    """The mixture of grammars that EM finds for a sample.

    Args:
        cells: cells of the learned choices.
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
    responsibilities = np.zeros((len(weights), int(component.max()) + 1))
    responsibilities[np.arange(len(weights)), component] = weights
    mixture = maximised(cells, counts, responsibilities)
    table = counts.toarray() if len(weights) * len(cells.original) <= _MAX_DENSE else counts
    log_likelihoods: list[float] = []
    for _ in range(MAX_STEPS):
        log_joint = mixture.log_ratios(cells, table)
        highest = log_joint.max(axis=1)
        responsibilities = np.exp(log_joint - highest[:, None])
        total = responsibilities.sum(axis=1)
        log_likelihoods.append(float(weights @ (np.log(total) + highest) / weights.sum()))
        if len(mixture.weights) == 1 or (
            len(log_likelihoods) > 1 and log_likelihoods[-1] - log_likelihoods[-2] < tolerance
        ):
            break
        # Eq. 4.10
        mixture = maximised(cells, table, responsibilities * (weights / total)[:, None])
    return MixtureFit(mixture, tuple(log_likelihoods))


def dense(product: sparse.csr_array | Floats) -> Floats:
    """A product with a sparse table as an ordinary array."""
    return product.toarray() if sparse.issparse(product) else np.asarray(product)  # type: ignore[union-attr, ty:missing-union-attribute]


def distinct_derivations(
    counts: sparse.csr_array, weights: Floats, component: Ints
) -> tuple[sparse.csr_array, Floats, Ints]:
    """Derivations with a weight; those with equal counts and the same component are merged."""
    used = weights > 0.0
    counts, weights, component = counts[used], weights[used], component[used]
    counts.sum_duplicates()
    numbers: dict[tuple[int, bytes, bytes], int] = {}
    number = np.zeros(len(weights), dtype=np.int64)
    for row, (start, end) in enumerate(pairwise(counts.indptr)):
        key = int(component[row]), counts.indices[start:end].tobytes(), counts.data[start:end].tobytes()
        number[row] = numbers.setdefault(key, len(numbers))
    _, first = np.unique(number, return_index=True)
    return counts[first], np.bincount(number, weights=weights).astype(np.float64), component[first]


def maximised(cells: Cells, counts: sparse.csr_array | Floats, responsibilities: Floats) -> Mixture:
    """Maximum-likelihood mixture for given responsibilities (Eq. 4.11).

    Args:
        cells: cells of the learned choices.
        counts: [N, A] counts of cells in each derivation.
        responsibilities: [N, K] times the weight of each derivation; components without derivations are dropped.
    """
    used = responsibilities.sum(axis=0)
    share = responsibilities[:, used > 0.0]
    return Mixture(used[used > 0.0] / used.sum(), cells.normalised(dense(counts.T @ share).T))


def merged(cells: Cells, counts: sparse.csr_array, weights: Floats, cluster: Ints, most: int) -> Iterator[Ints]:
    """Coarser and coarser clusters: the two clusters whose common grammar explains their models best are merged.

    This is the pair with the least loss of likelihood if each cluster has a grammar of its own: agglomeration by
    classification likelihood (Banfield and Raftery, Model-based Gaussian and non-Gaussian clustering, 1993).

    Args:
        cells: learned cells.
        counts: [N, A] count of each cell in each derivation.
        weights: [N] weight of each derivation.
        cluster: [N] initial clusters, from 0.
        most: number of the heaviest clusters that stay separate at first; the others are merged into them before.

    Yields:
        [N] clusters, one less each time, down to one.
    """
    size = int(cluster.max()) + 1
    share = sparse.csr_array((weights, (cluster, np.arange(len(cluster)))), shape=(size, len(cluster)))
    total = dense(share @ counts)
    mass = np.bincount(cluster, weights=weights, minlength=size).astype(np.float64)
    label = np.arange(size)
    order = np.argsort(-mass, kind="stable")
    for small in order[most:]:
        costs = _costs(cells, total, mass, int(small), order[:most])
        target = int(order[:most][np.argmin(costs)])
        _join(total, mass, label, target, int(small))
    used, number = np.unique(label, return_inverse=True)
    total, mass, label, size = total[used], mass[used], number.reshape(-1), len(used)
    cost = np.full((size, size), np.inf)
    for first in range(size - 1):
        cost[first, first + 1 :] = _costs(cells, total, mass, first, np.arange(first + 1, size))
    alive = set(range(size))
    while True:
        yield np.unique(label, return_inverse=True)[1].reshape(-1)[cluster]
        if len(alive) == 1:
            return
        first, second = divmod(int(np.argmin(cost)), size)
        _join(total, mass, label, first, second)
        alive.remove(second)
        cost[second], cost[:, second] = np.inf, np.inf
        rest = np.array(sorted(alive - {first}), dtype=np.int64)
        cost[np.minimum(first, rest), np.maximum(first, rest)] = _costs(cells, total, mass, first, rest)


def cluster(rows: Floats, weights: Floats, near: float = _NEIGHBOUR_SHARE) -> Ints:
    """Clusters of models that a preference hardly distinguishes, by the greedy method of section 4.6.

    Models are neighbours if their difference is below a share of the largest one. The model with most neighbours forms
    a cluster with them, they are removed, and so on.

    Args:
        rows: [N, F] features, scaled by their relevance: the difference of two models is the squared distance, on which
            the kernel of Eq. 4.6 depends.
        weights: [N] weight of each model, also as a neighbour.
        near: share of the largest difference.

    Returns:
        [N] cluster of each model; clusters are numbered in the order in which they are found.
    """
    distinct, number = np.unique(rows, axis=0, return_inverse=True)
    number = number.reshape(-1)
    neighbours = _neighbours(distinct, near)
    remaining = np.bincount(number, weights=weights, minlength=len(distinct))
    open_rows = np.ones(len(distinct), dtype=bool)
    label = np.zeros(len(distinct), dtype=np.int64)
    neighbour_weights = neighbours @ remaining
    clusters = 0
    while open_rows.any():
        centre = int(np.argmax(np.where(open_rows, neighbour_weights, -1.0)))
        row = neighbours.indices[neighbours.indptr[centre] : neighbours.indptr[centre + 1]]
        members = row[open_rows[row]]
        label[members] = clusters
        clusters += 1
        open_rows[members] = False
        neighbour_weights -= neighbours[:, members] @ remaining[members]
    return label[number]


def complete_log_likelihood(cells: Cells, counts: Floats) -> Floats:
    """Log-likelihood of derivations under one component with maximum-likelihood probabilities.

    Args:
        cells: cells of the learned choices.
        counts: [..., A] how often the derivations took each cell altogether.

    Returns:
        [...] sum of logarithms, without the original density.
    """
    starts = np.flatnonzero(np.diff(cells.choice, prepend=-1))
    total = np.add.reduceat(counts, starts, axis=-1) if len(starts) else np.zeros((*counts.shape[:-1], 1))
    return xlogy(counts, counts).sum(axis=-1) - xlogy(total, total).sum(axis=-1)


def _neighbours(rows: Floats, near: float) -> sparse.csr_array:
    """[N, N] whether two rows are neighbours; each row is its own neighbour."""
    blocks = [rows[i : i + BATCH] for i in range(0, len(rows), BATCH)]
    most = max(float(cdist(block, rows, "sqeuclidean").max()) for block in blocks)
    bound = near * most
    return sparse.csr_array(
        sparse.vstack([sparse.csr_array(cdist(block, rows, "sqeuclidean") <= bound) for block in blocks])
    )


def _costs(cells: Cells, total: Floats, mass: Floats, index: int, others: Ints) -> Floats:
    """Loss of likelihood by merging a cluster with each of some others."""
    apart = complete_log_likelihood(cells, total[others]) + complete_log_likelihood(cells, total[index])
    together = complete_log_likelihood(cells, total[others] + total[index])
    both = mass[others] + mass[index]
    shares = xlogy(both, both) - xlogy(mass[others], mass[others]) - xlogy(mass[index], mass[index])
    return apart - together - shares


def _join(total: Floats, mass: Floats, label: Ints, target: int, source: int) -> None:
    total[target] += total[source]
    mass[target] += mass[source]
    label[label == source] = target
