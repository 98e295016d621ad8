import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import GrammarlabError
from grammarlab.preference.observations import observe
from grammarlab.preference.processes.posterior import Hyperparameters, condition
from tests.preference.processes.test_evidence import dense_covariance
from tests.preference.rows import counted_rows


def textbook(rows, scores, new, theta):
    """Equations 4.4 and 4.5 with an explicit inverse, one label at a time."""
    inverse = np.linalg.inv(
        dense_covariance(rows, rows, theta.amplitude, theta.weights) + theta.noise * np.eye(len(rows))
    )
    k = dense_covariance(new, rows, theta.amplitude, theta.weights)
    return k @ inverse @ scores, theta.amplitude + theta.noise - np.sum(k @ inverse * k, axis=1)


@given(seed=st.integers(0, 1000), num_rows=st.integers(1, 12), repeats=st.integers(0, 6))
def test_prediction_equals_the_textbooks_dense_solve(seed, num_rows, repeats):
    rng = np.random.default_rng(seed)
    rows, scores = counted_rows(num_rows, 4, seed)
    again = rng.integers(0, num_rows, repeats)
    rows, scores = np.concatenate((rows, rows[again])), np.concatenate((scores, rng.uniform(0, 100, repeats)))
    theta = Hyperparameters(500.0, rng.uniform(0.0, 1.0, 4) * rng.integers(0, 2, 4), 3.0)
    new = rng.integers(0, 4, (7, 4)).astype(float)
    mean, variance = textbook(rows, scores, new, theta)
    found = condition(theta, observe(rows, scores)).predict(new)
    np.testing.assert_allclose(found.mean, mean, rtol=1e-9, atol=1e-7)
    np.testing.assert_allclose(found.std**2, variance, rtol=1e-9, atol=1e-7)


def test_many_rows_are_predicted_as_few_are():
    rows, scores = counted_rows(20, 3)
    posterior = condition(Hyperparameters(100.0, np.full(3, 0.4), 0.1), observe(rows, scores))
    many = np.tile(rows, (500, 1))
    np.testing.assert_allclose(posterior.predict(many).mean, np.tile(posterior.predict(rows).mean, 500), rtol=1e-12)


def test_a_singular_covariance_is_an_error_with_advice():
    rows = np.array([[0.0], [1e-9]])
    with pytest.raises(GrammarlabError, match="more noise"):
        condition(Hyperparameters(1e12, np.ones(1), 1e-12), observe(rows, [1.0, 2.0]))
