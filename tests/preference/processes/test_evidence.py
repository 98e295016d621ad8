import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal
from sklearn.gaussian_process.kernels import RBF, ConstantKernel

from grammarlab.preference.observations import Differences, Observations, observe
from grammarlab.preference.processes.evidence import covariance, loss, padded, padded_size
from tests.preference.rows import counted_rows


def dense_covariance(left, right, amplitude, weights):
    """Equation 4.6, term by term."""
    squared = np.sum(weights * (left[:, None, :] - right[None, :, :]) ** 2, axis=2)
    return amplitude * np.exp(-0.5 * squared)


def dense_loss(rows, scores, amplitude, weights, noise):
    """Equation 4.7 by SciPy's density, one label at a time."""
    total = dense_covariance(rows, rows, amplitude, weights) + noise * np.eye(len(rows))
    return -multivariate_normal.logpdf(scores, np.zeros(len(rows)), total)


VALUE_AND_GRADIENT = jax.jit(jax.value_and_grad(loss, argnums=(0, 1, 2)))


def our_loss(observations, amplitude, weights, noise, columns=None):
    data = padded(observations, columns or observations.rows.shape[1])
    weights = np.concatenate((weights, np.full(data.rows.shape[1] - len(weights), 0.7)))
    with jax.enable_x64(True):
        value, gradient = VALUE_AND_GRADIENT(amplitude, weights, noise, data)
    return float(value), [np.asarray(part) for part in gradient]


def example(num_rows=9, num_columns=5, seed=3):
    rng = np.random.default_rng(seed)
    rows, scores = counted_rows(num_rows, num_columns, seed)
    return rows, scores, 900.0, rng.uniform(0.01, 0.5, num_columns), 2.5


def test_the_kernel_equals_scikit_learns_anisotropic_rbf():
    rng = np.random.default_rng(1)
    left, right = rng.integers(0, 9, (40, 30)).astype(float), rng.integers(0, 9, (25, 30)).astype(float)
    weights = rng.uniform(0.0005, 0.05, 30)
    kernel = ConstantKernel(80.0) * RBF(1.0 / np.sqrt(weights))  # pyright: ignore[reportArgumentType]
    with jax.enable_x64(True):
        ours = np.asarray(covariance(jnp.asarray(left), jnp.asarray(right), jnp.asarray(80.0), jnp.asarray(weights)))
    np.testing.assert_allclose(ours, np.asarray(kernel(left, right)), rtol=1e-10, atol=1e-10)


def test_the_loss_is_minus_the_log_density_of_the_scores():
    rows, scores, *theta = example()
    value, _ = our_loss(observe(rows, scores), *theta)
    assert value == pytest.approx(dense_loss(rows, scores, *theta), rel=1e-12)


def test_taking_equal_rows_together_changes_nothing():
    rows, scores, *theta = example()
    twice = np.concatenate((rows, rows[:4], rows[:2]))
    contradicting = np.concatenate((scores, scores[:4] + 5.0, [100.0, 0.0]))
    observations = observe(twice, contradicting)
    assert len(observations.rows) == len(rows)
    value, _ = our_loss(observations, *theta)
    assert value == pytest.approx(dense_loss(twice, contradicting, *theta), rel=1e-12)


def test_the_gradient_agrees_with_central_differences():
    rows, scores, amplitude, weights, noise = example()
    observations = observe(np.concatenate((rows, rows[:3])), np.concatenate((scores, [1.0, 2.0, 90.0])))
    _, (by_amplitude, by_weights, by_noise) = our_loss(observations, amplitude, weights, noise)

    def difference(function, at):
        step = 1e-5 * at
        return (function(at + step) - function(at - step)) / (2.0 * step)

    def moved(index):
        return lambda weight: our_loss(
            observations, amplitude, np.where(np.arange(len(weights)) == index, weight, weights), noise
        )[0]

    numeric = [difference(moved(index), weight) for index, weight in enumerate(weights)]
    np.testing.assert_allclose(by_weights, numeric, rtol=1e-6)
    assert by_amplitude == pytest.approx(
        difference(lambda value: our_loss(observations, value, weights, noise)[0], amplitude), rel=1e-6
    )
    assert by_noise == pytest.approx(
        difference(lambda value: our_loss(observations, amplitude, weights, value)[0], noise), rel=1e-6
    )


def test_the_gradient_at_weight_zero_is_one_sided():
    rows, scores, amplitude, weights, noise = example()
    weights[2] = 0.0
    _, (_, by_weights, _) = our_loss(observe(rows, scores), amplitude, weights, noise)
    above = weights.copy()
    above[2] = 1e-7
    rise = our_loss(observe(rows, scores), amplitude, above, noise)[0]
    flat = our_loss(observe(rows, scores), amplitude, weights, noise)[0]
    assert by_weights[2] == pytest.approx((rise - flat) / 1e-7, rel=1e-4)


def test_the_gradient_agrees_with_automatic_differentiation_through_halved_blocks():
    rows, scores = counted_rows(140, 6, seed=2)
    weights = np.full(6, 0.3)
    observations = observe(rows, scores)

    def plain(weights):
        squared = jnp.sum(weights * (observations.rows[:, None] - observations.rows) ** 2, axis=2)
        total = 400.0 * jnp.exp(-0.5 * squared) + jnp.diag(0.5 / observations.counts)
        factor = jnp.linalg.cholesky(total)
        half = jax.scipy.linalg.solve_triangular(factor, observations.means, lower=True)
        return 0.5 * half @ half + jnp.sum(jnp.log(jnp.diagonal(factor)))

    with jax.enable_x64(True):
        expected = np.asarray(jax.jit(jax.grad(plain))(weights))
    _, (_, by_weights, _) = our_loss(observations, 400.0, weights, 0.5)
    np.testing.assert_allclose(by_weights, expected, rtol=1e-9)


@pytest.mark.parametrize(("num_rows", "num_columns", "extra"), [(1, 2, 3), (9, 5, 11), (23, 4, 0)])
def test_padding_changes_neither_value_nor_gradient(num_rows, num_columns, extra):
    rows, scores, amplitude, weights, noise = example(num_rows, num_columns)
    observations = observe(rows, scores)
    value, gradient = our_loss(observations, amplitude, weights, noise)
    wide_value, wide_gradient = our_loss(observations, amplitude, weights, noise, num_columns + extra)
    assert len(padded(observations, num_columns).rows) > len(observations.rows)
    assert value == pytest.approx(dense_loss(rows, scores, amplitude, weights, noise), rel=1e-12)
    assert wide_value == pytest.approx(value, rel=1e-12)
    np.testing.assert_allclose(wide_gradient[1][:num_columns], gradient[1], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(wide_gradient[1][num_columns:], 0.0)


@given(size=st.integers(1, 5000), steps=st.sampled_from([2, 4, 8]))
def test_padded_sizes_are_few_and_not_much_larger(size, steps):
    assert size <= padded_size(size, steps) <= max(16, size * (1.0 + 1.0 / steps))
    assert padded_size(padded_size(size, steps), steps) == padded_size(size, steps)


def test_other_users_of_jax_keep_their_precision():
    our_loss(observe(*counted_rows(4, 3)), 1.0, np.ones(3), 1.0)
    assert jnp.ones(2).dtype == jnp.float32


def test_the_loss_of_differences_is_minus_their_log_density_and_its_gradient_that_of_finite_differences():
    rng = np.random.default_rng(8)
    rows, others, means = rng.normal(size=(6, 3)), rng.normal(size=(6, 3)), rng.normal(size=6) * 20.0
    compared, variances = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 1.0]), np.array([0.0, 0.0, 30.0, 9.0, 4.0, 50.0])
    counts = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    observed = Observations(rows, means, counts, 0.0, Differences(others, compared, variances))
    theta = np.array([400.0, 0.3, 0.05, 0.6, 2.5])

    def dense(theta):
        mixing = np.hstack([np.eye(6), -np.diag(compared)])
        both = np.concatenate([rows, others])
        total = mixing @ dense_covariance(both, both, theta[0], theta[1:4]) @ mixing.T
        total += np.diag(np.where(variances > 0.0, variances, theta[4]))
        return -multivariate_normal.logpdf(means, np.zeros(6), total)

    value, gradient = our_loss(observed, theta[0], theta[1:4], theta[4], columns=4)
    assert value == pytest.approx(dense(theta), rel=1e-10)
    for place, slope in enumerate([gradient[0], *gradient[1][:3], gradient[2]]):
        step = np.zeros(5)
        step[place] = 1e-5 * theta[place]
        expected = (dense(theta + step) - dense(theta - step)) / (2.0 * step[place])
        assert float(slope) == pytest.approx(expected, rel=1e-4, abs=1e-7)
