"""Clusters of models, as the initial components of a mixture."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial.distance import cdist
from scipy.special import xlogy

from grammarlab.arrays import Ints
from grammarlab.density.mixtures.mixture import Cells, complete_log_likelihood, dense

Floats = NDArray[np.float64]

NEAR = 1e-3
"""Neighbours differ by less than this share of the largest difference (section 4.6)."""
_BLOCK = 1_000


def cluster(rows: Floats, weights: Floats, near: float = NEAR) -> Ints:
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
    found, number = np.unique(rows, axis=0, return_inverse=True)
    number = number.reshape(-1)
    near_by = _neighbours(found, near)
    left = np.bincount(number, weights=weights, minlength=len(found))
    open_rows = np.ones(len(found), dtype=bool)
    label = np.zeros(len(found), dtype=np.int64)
    around = near_by @ left
    clusters = 0
    while open_rows.any():
        centre = int(np.argmax(np.where(open_rows, around, -1.0)))
        row = near_by.indices[near_by.indptr[centre] : near_by.indptr[centre + 1]]
        taken = row[open_rows[row]]
        label[taken] = clusters
        clusters += 1
        open_rows[taken] = False
        around -= near_by[:, taken] @ left[taken]
    return label[number]


def _neighbours(rows: Floats, near: float) -> sparse.csr_array:
    """[N, N] whether two rows are neighbours; each row is its own neighbour."""
    blocks = [rows[i : i + _BLOCK] for i in range(0, len(rows), _BLOCK)]
    most = max(float(cdist(block, rows, "sqeuclidean").max()) for block in blocks)
    bound = near * most
    return sparse.csr_array(
        sparse.vstack([sparse.csr_array(cdist(block, rows, "sqeuclidean") <= bound) for block in blocks])
    )


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
    kept, number = np.unique(label, return_inverse=True)
    total, mass, label, size = total[kept], mass[kept], number.reshape(-1), len(kept)
    cost = np.full((size, size), np.inf)
    for one in range(size - 1):
        cost[one, one + 1 :] = _costs(cells, total, mass, one, np.arange(one + 1, size))
    alive = set(range(size))
    while True:
        yield np.unique(label, return_inverse=True)[1].reshape(-1)[cluster]
        if len(alive) == 1:
            return
        one, other = divmod(int(np.argmin(cost)), size)
        _join(total, mass, label, one, other)
        alive.remove(other)
        cost[other], cost[:, other] = np.inf, np.inf
        rest = np.array(sorted(alive - {one}), dtype=np.int64)
        cost[np.minimum(one, rest), np.maximum(one, rest)] = _costs(cells, total, mass, one, rest)


def _join(total: Floats, mass: Floats, label: Ints, one: int, other: int) -> None:
    total[one] += total[other]
    mass[one] += mass[other]
    label[label == other] = one


def _costs(cells: Cells, total: Floats, mass: Floats, one: int, others: Ints) -> Floats:
    """Loss of likelihood by merging a cluster with each of some others."""
    apart = complete_log_likelihood(cells, total[others]) + complete_log_likelihood(cells, total[one])
    together = complete_log_likelihood(cells, total[others] + total[one])
    both = mass[others] + mass[one]
    shares = xlogy(both, both) - xlogy(mass[others], mass[others]) - xlogy(mass[one], mass[one])
    return apart - together - shares
