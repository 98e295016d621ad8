"""The posterior of probabilities, against sums over all groups and closed forms."""

from itertools import pairwise, product

import numpy as np
import pytest
from scipy.special import gammaln

from grammarlab.density.samples.levels import CONCENTRATIONS, ProbabilityPrior
from grammarlab.density.samples.mixture import Cells


def of_groups(counts, original, groups):
    """For each concentration, log-evidence of groups and the posterior mean (Dirichlet) by the original one."""
    share = np.array([original[g].sum() for g in groups])
    taken = np.array([counts[g].sum() for g in groups])
    for concentration in CONCENTRATIONS:
        prior = concentration * share
        log = (gammaln(prior + taken) - gammaln(prior) - taken * np.log(share)).sum()
        log += gammaln(concentration) - gammaln(concentration + taken.sum())
        ratio = np.ones(len(original))
        for group, value in zip(groups, (prior + taken) / (concentration + taken.sum()) / share, strict=True):
            ratio[group] = value
        yield float(log), ratio


def test_two_branches_have_the_posterior_mean_of_dirichlet():
    original, counts = np.array([0.3, 0.7]), np.array([[9.0, 2.0]])
    found = ProbabilityPrior.of(Cells(original, np.zeros(2, dtype=np.int64)), np.array([False])).posterior(counts)
    logs, ratios = zip(*of_groups(counts[0], original, [[0], [1]]), strict=True)
    weight = np.exp(logs) / np.exp(logs).sum()
    np.testing.assert_allclose(found.ratio[0], weight @ np.array(ratios))
    assert found.evidence[0, 0] == pytest.approx(np.log(np.exp(logs).mean()))


def test_ranges_are_summed_over_all_cuts():
    original, counts = np.array([0.1, 0.2, 0.3, 0.15, 0.25]), np.array([[0.0, 4.0, 3.0, 0.0, 1.0]])
    found = ProbabilityPrior.of(Cells(original, np.zeros(5, dtype=np.int64)), np.array([True])).posterior(counts)
    total, mean, cut = 0.0, np.zeros(5), 2.0 / 5
    for chosen in product([False, True], repeat=4):
        ends = [0, *(i + 1 for i, is_cut in enumerate(chosen) if is_cut), 5]
        prior = cut ** sum(chosen) * (1 - cut) ** (4 - sum(chosen)) / len(CONCENTRATIONS)
        for log, ratio in of_groups(counts[0], original, [list(range(*pair)) for pair in pairwise(ends)]):
            total += prior * np.exp(log)
            mean += prior * np.exp(log) * ratio
    np.testing.assert_allclose(found.evidence[0, 0], np.log(total))
    np.testing.assert_allclose(found.ratio[0], mean / total)


@pytest.mark.parametrize("ordered", [False, True])
@pytest.mark.parametrize("size", [2, 4, 7])
def test_no_examples_teach_nothing_and_many_everything(ordered, size):
    original = np.arange(1.0, size + 1) / np.arange(1.0, size + 1).sum()
    wanted = original[::-1]
    levels = ProbabilityPrior.of(Cells(original, np.zeros(size, dtype=np.int64)), np.array([ordered]))
    nothing = levels.posterior(np.zeros((1, size)))
    np.testing.assert_allclose(nothing.ratio, 1.0)
    np.testing.assert_allclose(nothing.evidence, 0.0, atol=1e-12)
    many = levels.posterior(1e6 * wanted[None])
    np.testing.assert_allclose(many.ratio[0] * original, wanted, rtol=1e-3)


def test_probabilities_sum_to_one_and_impossible_branches_stay_so():
    original = np.array([0.5, 0.0, 0.5, 0.2, 0.3, 0.5])
    levels = ProbabilityPrior.of(Cells(original, np.repeat([0, 1], 3)), np.array([False, True]))
    found = levels.posterior(np.array([[3.0, 0.0, 1.0, 0.0, 2.0, 9.0], [0.0, 0.0, 7.0, 1.0, 0.0, 0.0]]))
    mean = found.ratio * original
    np.testing.assert_allclose(mean.reshape(2, 2, 3).sum(axis=2), 1.0)
    assert (mean[:, 1] == 0.0).all()
