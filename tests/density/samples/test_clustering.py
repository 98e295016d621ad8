"""Clusters to begin a mixture with, against the method written down plainly."""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from grammarlab.density.samples.mixture import Cells, cluster, complete_log_likelihood, merged

few = settings(max_examples=40)


@st.composite
def tables(draw):
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    rows = random.integers(0, draw(st.integers(1, 4)), size=(draw(st.integers(1, 25)), draw(st.integers(1, 3))))
    return rows.astype(float), random.integers(1, 4, size=len(rows)).astype(float), draw(st.sampled_from([0.001, 0.3]))


@few
@given(tables())
def test_the_model_with_most_neighbours_takes_them(table):
    rows, weights, near = table
    difference = ((rows[:, None] - rows[None]) ** 2).sum(axis=2)
    neighbours = difference <= near * difference.max()
    label = cluster(rows, weights, near)
    left = np.ones(len(rows), dtype=bool)
    for number in range(label.max() + 1):
        most = max((neighbours[i] & left) @ weights for i in np.flatnonzero(left))
        members = label == number
        assert any((members == (neighbours[i] & left)).all() for i in np.flatnonzero(members))
        assert weights[members].sum() == most
        left &= ~members
    assert not left.any()


@few
@given(tables())
def test_equal_models_share_a_cluster(table):
    rows, weights, near = table
    label = cluster(rows, weights, near)
    _, kind = np.unique(rows, axis=0, return_inverse=True)
    assert all(len(set(label[kind.reshape(-1) == k])) == 1 for k in range(kind.max() + 1))


@st.composite
def clustered(draw):
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    number = draw(st.integers(2, 20))
    counts = random.integers(0, 3, size=(number, 6)).astype(float)
    label = np.unique(random.integers(0, 5, size=number), return_inverse=True)[1].reshape(-1)
    return Cells(np.full(6, 0.5), np.repeat(np.arange(3), 2)), counts, np.ones(number), label


@few
@given(clustered(), st.integers(1, 6))
def test_merging_joins_two_clusters_at_a_time_down_to_one(table, most):
    cells, counts, weights, label = table
    steps = list(merged(cells, sparse.csr_array(counts), weights, label, most))
    first = min(most, label.max() + 1)
    assert [step.max() + 1 for step in steps] == list(range(first, 0, -1))
    for finer, coarser in zip([label, *steps], steps, strict=False):
        assert all(len(set(coarser[finer == k])) == 1 for k in range(finer.max() + 1))


@few
@given(clustered())
def test_each_step_costs_least_of_the_likelihood(table):
    cells, counts, weights, label = table

    def likelihood(parts):
        total = 0.0
        for k in range(parts.max() + 1):
            own = parts == k
            mass = weights[own].sum()
            total += complete_log_likelihood(cells, weights[own] @ counts[own]) + mass * np.log(mass)
        return total

    steps = list(merged(cells, sparse.csr_array(counts), weights, label, 100))
    for finer, coarser in itertools.pairwise(steps):
        size = finer.max() + 1
        every = [np.where(finer == b, a, finer) for a in range(size) for b in range(a + 1, size)]
        best = max(likelihood(np.unique(joined, return_inverse=True)[1].reshape(-1)) for joined in every)
        assert np.isclose(likelihood(coarser), best, atol=1e-9)
