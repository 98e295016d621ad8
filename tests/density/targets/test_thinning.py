"""Rejection on plain numbers, where every probability is known."""

import numpy as np
import pytest

from grammarlab.density.targets.rejection import thin
from grammarlab.errors import GrammarlabError

VALUES = np.array([0.0, 1.0, 2.0, 5.0])


def run(num_models, seed=1, weights=VALUES, **options):
    def propose(first, number):
        return np.random.default_rng(3).integers(0, len(weights), size=200_000)[first : first + number]

    found = thin(propose, lambda kinds: weights[kinds], lambda kinds, rows: kinds[rows], num_models, seed, **options)
    return np.concatenate([kinds[rows] for kinds, rows in found.chunks]), found.acceptance


def test_models_are_accepted_in_proportion_to_their_weight():
    kinds, acceptance = run(20_000, bound=5.0)
    counts = np.bincount(kinds, minlength=4)
    expected = 20_000 * VALUES / VALUES.sum()
    assert counts[0] == 0
    assert ((counts - expected)[1:] ** 2 / expected[1:]).sum() < 13.8  # chi-square, 2 degrees, p = 0.001
    assert acceptance.rate == pytest.approx(VALUES.mean() / 5.0, abs=0.01)
    assert acceptance.mean_weight == pytest.approx(2.0, abs=0.05)
    assert acceptance.has_bound
    assert acceptance.truncated == 0.0


def test_a_bound_that_is_found_comes_to_the_same_models():
    known, _ = run(5_000, bound=5.0)
    found, acceptance = run(5_000)
    assert (known == found).all()
    assert not acceptance.has_bound
    assert acceptance.bound == 5.0


def test_a_late_larger_weight_thins_what_was_accepted_before():
    kinds = np.zeros(100_000, dtype=np.int64)
    kinds[600::2] = 1
    weights = np.array([1.0, 4.0])
    found = thin(
        lambda first, number: kinds[first : first + number],
        lambda some: weights[some],
        lambda some, rows: some[rows],
        20_000,
        0,
        chunk=256,
    )
    accepted = np.concatenate([some[rows] for some, rows in found.chunks])
    assert found.acceptance.bound == 4.0
    assert (accepted == 1).mean() == pytest.approx(0.8, abs=0.02)


def test_a_bound_that_is_too_small_is_reported():
    kinds, acceptance = run(20_000, bound=2.0)
    assert acceptance.truncated == pytest.approx(3.0 / 8.0, abs=0.01)
    assert np.bincount(kinds, minlength=4)[3] == pytest.approx(20_000 * 2.0 / 5.0, rel=0.05)
    assert "37" in str(acceptance)


def test_chunks_do_not_matter_for_a_known_bound():
    one, _ = run(3_000, bound=5.0, chunk=97)
    other, _ = run(3_000, bound=5.0, chunk=4_096)
    assert (one == other).all()
    assert (run(1_000, bound=5.0)[0] == one[:1_000]).all()


def test_seeds_matter():
    assert (run(100, seed=1, bound=5.0)[0] != run(100, seed=2, bound=5.0)[0]).any()


def test_nothing_accepted_is_told():
    with pytest.raises(GrammarlabError, match="none of 5,000 models"):
        run(10, weights=np.zeros(4), most_proposals=5_000)


@pytest.mark.parametrize("wrong", [-1.0, np.nan, np.inf])
def test_weights_must_be_a_density(wrong):
    with pytest.raises(GrammarlabError, match="finite and at least 0"):
        run(10, weights=np.array([1.0, wrong]))


@pytest.mark.parametrize("bound", [5.0, None])
def test_few_models_are_accepted_of_few_proposed_ones(bound):
    _, acceptance = run(1, bound=bound)
    assert acceptance.proposals <= 256
