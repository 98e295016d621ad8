"""Nothing explained: one distribution of values, found by expectation-maximisation and judged by held-out scores."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import gammaln
from scipy.stats import norm

from grammarlab.preference import unexplained as module
from grammarlab.preference.person import PERSONS, Person, log_likelihood, possible_values, prior_of_values
from grammarlab.preference.unexplained import distribution, folds_of, log_evidence_of_values, unexplained

GRID = np.append(np.arange(0.0, 101.0, 4.0), 30.0)


def likelihoods_of(scores, noise, blunders):
    """[n, G] probability of each score for each value, by the normal distribution."""
    low = np.where(scores <= 0.0, -np.inf, scores - 0.5)[:, None]
    high = np.where(scores >= 100.0, np.inf, scores + 0.5)[:, None]
    length = np.where((scores <= 0.0) | (scores >= 100.0), 0.5, 1.0)[:, None]
    inside = norm.cdf(high, GRID, noise) - norm.cdf(low, GRID, noise)
    return (1.0 - blunders) * inside + blunders * length / 100.0


def penalised(values, likelihoods):
    return np.log(likelihoods @ values).sum() + np.log(values).mean()


@pytest.mark.parametrize("seed", range(4))
def test_no_other_distribution_explains_scores_better(seed):
    randomness = np.random.default_rng(seed)
    scores = np.clip(randomness.choice([0.0, 40.0, 90.0], 12) + 8.0 * randomness.normal(size=12), 0.0, 100.0)
    likelihoods = likelihoods_of(scores, 7.5, 0.03)
    found = distribution(likelihoods, np.ones((1, 12)))[0]

    def loss(logits):
        values = np.exp(logits - logits.max())
        return -penalised(values / values.sum(), likelihoods)

    best = minimize(loss, np.log(found), method="L-BFGS-B", options={"maxiter": 2_000, "maxfun": 10**6})
    assert found.sum() == pytest.approx(1.0)
    assert penalised(found, likelihoods) >= -best.fun - 0.1
    assert penalised(found, likelihoods) > penalised(np.full(len(GRID), 1.0 / len(GRID)), likelihoods) + 1.0


def test_labels_count_as_often_as_they_are_there():
    likelihoods = likelihoods_of(np.array([0.0, 50.0, 50.0]), 5.0, 0.002)
    twice = distribution(likelihoods[:2], np.array([[1.0, 2.0], [1.0, 0.0]]))
    np.testing.assert_allclose(twice[0], distribution(likelihoods, np.ones((1, 3)))[0])
    np.testing.assert_allclose(twice[1], distribution(likelihoods[:1], np.ones((1, 1)))[0])


def test_without_labels_all_values_are_alike():
    np.testing.assert_allclose(distribution(np.ones((0, len(GRID))), np.ones((1, 0)))[0], 1.0 / len(GRID))


def test_the_evidence_is_that_of_held_out_scores_under_the_best_error():
    randomness = np.random.default_rng(3)
    scores = np.clip(randomness.choice([10.0, 70.0], 20) + 10.0 * randomness.normal(size=20), 0.0, 100.0)
    fold = np.arange(20) % 4
    evidence = []
    for noise, blunders in PERSONS:
        likelihoods = likelihoods_of(scores, noise, blunders)
        total = -40.0 * blunders
        for number in range(4):
            out = fold == number
            values = distribution(likelihoods[~out], np.ones((1, 15)))[0]
            total += np.log(likelihoods[out] @ values).sum()
        evidence.append(total)
    found = unexplained(scores, fold, GRID)
    assert found.log_evidence == pytest.approx(max(evidence), abs=1e-2)
    assert found.person == PERSONS[int(np.argmax(evidence))]
    likelihoods = likelihoods_of(scores, *found.person)
    np.testing.assert_allclose(found.probabilities, distribution(likelihoods, np.ones((1, 20)))[0], atol=1e-5)
    np.testing.assert_allclose(found.held_out[2], distribution(likelihoods[fold != 2], np.ones((1, 15)))[0], atol=1e-5)


def test_equal_scores_are_scores_of_their_own():
    """Each of 40 scores of six values, in a batch of one row each, as `distribution` counts them."""
    scores = np.random.default_rng(4).choice([0.0, 20.0, 20.5, 60.0, 99.5, 100.0], 40)
    fold, person = np.arange(40) % 8, PERSONS[20]
    found = unexplained(scores, fold, GRID, [person])
    likelihoods = likelihoods_of(scores, *person)
    held_out = distribution(likelihoods, (fold != np.arange(8)[:, None]).astype(float))
    evidence = np.log((held_out[fold] * likelihoods).sum(axis=1)).sum() - person.price
    np.testing.assert_allclose(found.held_out, held_out, atol=1e-5)
    assert found.log_evidence == pytest.approx(evidence, abs=1e-3)
    again = unexplained(np.append(scores, scores), np.append(fold, fold), GRID, [person])
    twice = distribution(likelihoods, 2.0 * (fold != np.arange(8)[:, None]))
    np.testing.assert_allclose(again.held_out, twice, atol=1e-5)


def test_a_single_value_explains_less_than_a_distribution():
    scores = np.tile([0.0, 60.0], 20)
    single = max(np.log(likelihoods_of(scores, noise, blunders)).sum(axis=0).max() for noise, blunders in PERSONS)
    assert unexplained(scores, np.arange(40) % 8, GRID).log_evidence > single + 40.0


def test_the_level_is_the_mean_value():
    fold = np.arange(16) % 8
    assert unexplained(np.zeros(16), fold, GRID).level == pytest.approx(0.0, abs=1e-9)
    assert unexplained(np.repeat([20.0, 80.0, 40.0, 0.0], 4), fold, GRID).level == pytest.approx(35.0, abs=0.1)
    flat = unexplained(np.repeat([20.0, 80.0], 8), fold, GRID)
    assert flat.sd == pytest.approx(30.0, abs=3.0)


def test_equal_rows_are_held_out_together_and_parts_are_alike():
    randomness = np.random.default_rng(0)
    rows = randomness.integers(0, 3, (60, 3)).astype(float)
    fold = folds_of(rows, 5)
    different, row = np.unique(rows, axis=0, return_inverse=True)
    parts = [np.unique(fold[row.reshape(-1) == number]) for number in range(len(different))]
    assert all(len(part) == 1 for part in parts)
    sizes = np.bincount(np.concatenate(parts), minlength=8)
    assert sizes.max() - sizes.min() <= 1
    assert set(folds_of(rows[:1], 0).tolist()) == {0}
    assert sorted(folds_of(np.eye(5), 1).tolist()) == [0, 1, 2, 3, 4]
    assert np.array_equal(fold, folds_of(rows, 5))
    assert not np.array_equal(fold, folds_of(rows, 6))


@pytest.mark.parametrize(
    "scores", [[0.0], [0.0, 0.0, 100.0], [100.0] * 20 + [0.0] * 12 + [48.0] * 3, [52.0, 4.0, 96.0]]
)
def test_values_of_exact_scores_have_the_evidence_of_a_dirichlet_process(monkeypatch, scores):
    """Each distinct value costs its prior, and each score what the urn of Blackwell and MacQueen says."""
    monkeypatch.setattr(module, "PERSONS", (Person(0.01, 0.0),))
    values, counts = np.unique(scores, return_counts=True)
    prior = prior_of_values()[np.searchsorted(possible_values(), values)]
    exact = np.log(prior).sum() + gammaln(counts).sum() - gammaln(1.0 + len(scores))
    # After the first score of a value others of it come from the prior as well.
    exact += sum(np.log1p(p / np.arange(1.0, n)).sum() for p, n in zip(prior, counts, strict=True))
    assert log_evidence_of_values(np.array(scores)) == pytest.approx(exact, abs=1e-4)


def test_the_evidence_of_values_is_that_of_a_distribution_over_scores(monkeypatch):
    """Of two scores, all orders of which are equally likely: the sum of all probabilities is 1."""
    person = Person(10.0, 0.1)
    monkeypatch.setattr(module, "PERSONS", (person,))
    points = np.arange(0.0, 101.0, 1.0)
    likelihoods = np.exp(log_likelihood(points, possible_values(), *person))
    first = likelihoods @ prior_of_values()
    assert first.sum() == pytest.approx(1.0, abs=1e-3)
    for score in (0.0, 37.0, 100.0):
        both = sum(np.exp(log_evidence_of_values(np.array([score, other])) + person.price) for other in points)
        assert both == pytest.approx(first[int(score)], rel=0.05)


def test_the_evidence_of_values_knows_no_order_of_scores():
    scores = np.random.default_rng(1).integers(0, 101, 40).astype(float)
    assert log_evidence_of_values(scores) == log_evidence_of_values(scores[::-1])
