"""EM over counts: laws, and equal to what can be written down by hand."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from grammarlab.density.samples.mixture import (
    Cells,
    complete_log_likelihood,
    distinct_derivations,
    fit_mixture,
    maximised,
)
from grammarlab.errors import GrammarlabError

few = settings(max_examples=30)


@st.composite
def samples(draw):
    """Cells of random choices, random counts, weights and first components."""
    sizes = draw(st.lists(st.integers(2, 4), min_size=1, max_size=4))
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    choice = np.repeat(np.arange(len(sizes)), sizes)
    original = np.concatenate([random.dirichlet(np.ones(size)) for size in sizes])
    number = draw(st.integers(1, 30))
    made = random.integers(0, 3, size=(number, len(sizes)))
    counts = np.zeros((number, len(choice)))
    for row in range(number):
        for at, size in enumerate(sizes):
            start = sum(sizes[:at])
            counts[row, start : start + size] = random.multinomial(made[row, at], random.dirichlet(np.ones(size)))
    weights = random.integers(0, 4, size=number).astype(float)
    weights[0] += 1.0
    component = random.integers(0, draw(st.integers(1, 4)), size=number)
    return Cells(original, choice), counts, weights, component


@few
@given(samples())
def test_em_never_lowers_the_likelihood(sample):
    cells, counts, weights, component = sample
    found = np.array(fit_mixture(cells, sparse.csr_array(counts), weights, component).log_likelihoods)
    assert np.isfinite(found).all()
    assert (np.diff(found) >= -1e-12).all()


@few
@given(samples())
def test_a_fitted_mixture_is_a_density(sample):
    cells, counts, weights, component = sample
    mixture = fit_mixture(cells, sparse.csr_array(counts), weights, component).mixture
    assert mixture.weights.sum() == pytest.approx(1.0, abs=1e-12)
    sums = np.stack([np.bincount(cells.choice, weights=row) for row in mixture.probabilities])
    np.testing.assert_allclose(sums, 1.0, atol=1e-12)


@few
@given(samples())
def test_one_component_has_the_relative_frequencies(sample):
    cells, counts, weights, component = sample
    mixture = fit_mixture(cells, sparse.csr_array(counts), weights, 0 * component).mixture
    total = weights @ counts
    for choice in range(cells.choice.max() + 1):
        own = cells.choice == choice
        expected = total[own] / total[own].sum() if total[own].any() else cells.original[own]
        np.testing.assert_allclose(mixture.probabilities[0, own], expected, atol=1e-12)


@few
@given(samples())
def test_log_ratios_are_sums_over_derivations_and_components(sample):
    cells, counts, weights, component = sample
    mixture = fit_mixture(cells, sparse.csr_array(counts), weights, component).mixture
    expected = np.zeros(len(counts))
    for alpha, probabilities in zip(mixture.weights, mixture.probabilities, strict=True):
        expected += alpha * np.prod((probabilities / cells.original) ** counts, axis=1)
    used = weights > 0.0
    found = mixture.log_ratio(cells, sparse.csr_array(counts))
    np.testing.assert_allclose(np.exp(found[used]), expected[used], rtol=1e-10)


@few
@given(samples())
def test_weights_count_as_repeats(sample):
    cells, counts, weights, component = sample
    repeats = weights.astype(int)
    rows = np.repeat(np.arange(len(weights)), repeats)
    one = fit_mixture(cells, sparse.csr_array(counts), weights, component)
    other = fit_mixture(cells, sparse.csr_array(counts[rows]), np.ones(len(rows)), component[rows])
    np.testing.assert_allclose(one.log_likelihoods[:3], other.log_likelihoods[:3], atol=1e-10)


@few
@given(samples())
def test_complete_likelihood_is_that_of_the_likeliest_grammar(sample):
    cells, counts, weights, _ = sample
    total = weights @ counts
    likeliest = cells.normalised(total[None])[0]
    used = total > 0.0
    expected = float((total[used] * np.log(likeliest[used])).sum())
    assert complete_log_likelihood(cells, total) == pytest.approx(expected, abs=1e-9)


@few
@given(samples())
def test_joining_equal_derivations_changes_no_maximum(sample):
    cells, counts, weights, component = sample
    joined, mass, parts = distinct_derivations(sparse.csr_array(counts), weights, component)
    assert mass.sum() == pytest.approx(weights.sum())
    assert (mass > 0.0).all()

    def share(parts, mass):
        found = np.zeros((len(parts), component.max() + 1))
        found[np.arange(len(parts)), parts] = mass
        return found

    one = maximised(cells, sparse.csr_array(counts), share(component, weights))
    other = maximised(cells, joined, share(parts, mass))
    np.testing.assert_allclose(one.probabilities, other.probabilities, atol=1e-12)


def test_nothing_to_learn_from_is_told():
    cells = Cells(np.array([0.5, 0.5]), np.array([0, 0]))
    with pytest.raises(GrammarlabError, match="none that counts"):
        fit_mixture(cells, sparse.csr_array(np.ones((2, 2))), np.zeros(2), np.zeros(2, dtype=np.int64))


def test_two_styles_become_two_components():
    cells = Cells(np.full(8, 0.5), np.repeat(np.arange(4), 2))
    styles = np.array([[1, 0, 1, 0, 1, 0, 1, 0], [0, 1, 0, 1, 0, 1, 0, 1]], dtype=float)
    counts = sparse.csr_array(np.repeat(styles, [30, 10], axis=0))
    mixture = fit_mixture(cells, counts, np.ones(40), np.repeat([0, 1], [30, 10])).mixture
    np.testing.assert_allclose(mixture.weights, [0.75, 0.25])
    np.testing.assert_allclose(mixture.probabilities, styles)


@few
@given(samples(), st.sampled_from([1e-1, 1e-3, 1e-4]))
def test_a_coarser_fit_is_the_beginning_of_a_finer_one(sample, tolerance):
    cells, counts, weights, component = sample
    coarse, fine = (
        fit_mixture(cells, sparse.csr_array(counts), weights, component, some).log_likelihoods
        for some in (tolerance, 1e-6)
    )
    assert coarse == fine[: len(coarse)]
    assert all(after - before >= tolerance for before, after in pairwise(coarse[:-1]))
