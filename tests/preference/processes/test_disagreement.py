from dataclasses import replace

import numpy as np
import pytest

from grammarlab.preference.processes.disagreement import (
    cautious_weights,
    conditional_covariance,
    doubtful_weights,
    joint,
    most_doubtful,
    most_telling,
)
from grammarlab.preference.processes.grouped import fit
from tests.preference.processes.test_evidence import dense_covariance
from tests.preference.processes.test_grouped import GROUPS, styled_rows


def random_covariance(size, seed=0):
    factor = np.random.default_rng(seed).normal(size=(size, 4))
    return factor @ factor.T + 0.1 * np.eye(size)


def test_a_joint_covariance_is_symmetric_and_positive():
    found = fit(*styled_rows(14, seed=2), groups=GROUPS)
    new, _ = styled_rows(40, seed=9)
    mean, covariance = joint(found, new, cautious_weights(found, new))
    assert mean.shape == (40,)
    np.testing.assert_allclose(covariance, covariance.T, atol=1e-8 * covariance.max())
    assert np.linalg.eigvalsh(covariance).min() > -1e-6 * covariance.max()


def test_without_caution_one_explanation_has_the_covariance_of_the_textbook():
    rows, scores = styled_rows(50)
    new, _ = styled_rows(15, seed=3)
    found = fit(rows, scores, groups=GROUPS)
    found = replace(found, explanations=(replace(found.explanations[0], share=1.0),))
    theta = found.explanations[0].posterior.hyperparameters
    noise = max(theta.noise, 1e-4 * 80.0**2)

    def k(left, right):
        return dense_covariance(left, right, theta.amplitude, theta.weights)

    expected = k(new, new) - k(new, rows) @ np.linalg.solve(k(rows, rows) + noise * np.eye(50), k(rows, new))
    mean, covariance = joint(found, new, np.zeros(18))
    np.testing.assert_allclose(covariance, expected, atol=1e-5 * theta.amplitude)
    np.testing.assert_allclose(mean, found.predict(new).mean, atol=1e-9)


def test_caution_keeps_what_has_something_new_uncertain():
    rows, scores = styled_rows(60)
    found = fit(rows, scores, groups=GROUPS)
    odd = rows[:1].copy()
    odd[0, 6:9] = 2.0
    both = np.concatenate((rows[:1], odd))
    _, covariance = joint(found, both, cautious_weights(found, rows))
    assert covariance[1, 1] > 4.0 * covariance[0, 0]
    assert np.ptp(found.predict(both).std) < 0.1


def test_doubt_is_about_what_liked_models_have_never_had():
    rows, scores = styled_rows(60)
    found = fit(rows, scores, groups=GROUPS)
    liked = np.array([[1.0, 0.0, 2.0], [1.0, 3.0, 2.0], [1.0, 0.0, 5.0]]).repeat(6, axis=1)
    weights = doubtful_weights(found, liked)
    assert weights[:6].min() > 3.0 * weights[6:].max() > 0.0
    # However often a column varied in models that are not liked.
    assert np.ptp(rows[:, :6], axis=0).all()


@pytest.mark.parametrize("seed", range(3))
def test_the_most_doubtful_models_are_those_of_a_brute_force_search(seed):
    C, rng = random_covariance(14, seed), np.random.default_rng(seed)
    stakes, allowed = rng.random(14), rng.random(14) < 0.7
    expected = []
    for _ in range(4):
        variance = stakes * np.diag(conditional_covariance(C, np.array(expected, dtype=int), 0.2))
        expected.append(max(np.setdiff1d(np.flatnonzero(allowed), expected), key=lambda index: variance[index]))
    assert most_doubtful(C, 4, 0.2, stakes, allowed).tolist() == expected


def test_knowing_scores_is_conditioning_a_gaussian():
    C, chosen = random_covariance(12), np.array([2, 5, 7])
    inner = np.linalg.inv(C[np.ix_(chosen, chosen)] + 0.3 * np.eye(3))
    np.testing.assert_allclose(conditional_covariance(C, chosen, 0.3), C - C[:, chosen] @ inner @ C[chosen])
    np.testing.assert_array_equal(conditional_covariance(C, np.zeros(0, dtype=int), 0.3), C)


@pytest.mark.parametrize("seed", range(3))
def test_the_most_telling_models_are_those_of_a_brute_force_search(seed):
    C = random_covariance(14, seed)
    rng = np.random.default_rng(seed)
    stakes, allowed = rng.random(14), rng.random(14) < 0.7
    expected = []
    for _ in range(4):
        open_ = [index for index in np.flatnonzero(allowed) if index not in expected]
        left = {
            index: stakes @ np.diag(conditional_covariance(C, np.array([*expected, index]), 0.2)) for index in open_
        }
        expected.append(min(left, key=lambda index: left[index]))
    before = C.copy()
    assert most_telling(C, 4, 0.2, stakes, allowed).tolist() == expected
    np.testing.assert_array_equal(C, before)


def test_no_stakes_count_alike():
    C, allowed = random_covariance(10), np.ones(10, dtype=bool)
    np.testing.assert_array_equal(
        most_telling(C, 3, 0.1, np.zeros(10), allowed), most_telling(C, 3, 0.1, np.ones(10), allowed)
    )
