"""Fitting and asking the paper's Gaussian process, beside scikit-learn and GPyTorch with the same kernel.

All three minimise E of Equation 4.8 from the same start, with the same L-BFGS and budget, on one core. The energy that
each reaches stands in extra_info: less is better. GPyTorch is optional (pip install gpytorch); scikit-learn takes
minutes at the smaller size; at the larger one, which takes gigabytes, one evaluation is timed (`seconds for 100`).
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from grammarlab.baselines import gaussian_process
from grammarlab.baselines.gaussian_process import MAX_ITERATIONS, NOISE, PENALTY, common_relevance
from grammarlab.preference.observations import observe
from grammarlab.preference.processes.evidence import minimise

SIZES = [(256, 470), (512, 1085)]
LOW, HIGH = np.log(1e-11), np.log(1e5)


def labels(num_rows, num_columns, seed=0):
    """Counts as a building's features have: choices made once or once a floor, some of them joint."""
    rng = np.random.default_rng(seed)
    floors = rng.integers(1, 6, num_rows)
    choices = []
    while sum(choice.shape[1] for choice in choices) < num_columns:
        chance = rng.dirichlet(np.full(rng.integers(3, 7), 2.0))
        times = np.ones_like(floors) if len(choices) % 3 == 0 else floors
        counts = np.array([rng.multinomial(number, chance) for number in times])
        if len(choices) % 5 == 4:
            other = choices[rng.integers(len(choices))]
            counts = (other[:, :, None] * counts[:, None, :]).reshape(num_rows, -1)
        choices.append(counts)
    rows = np.concatenate((floors[:, None], *choices), axis=1)[:, :num_columns].astype(float)
    scores = np.select([(rows[:, 1] == 1) & (floors > 2), rows[:, 2] == 1, rows[:, 3] == 1], [70.0, 20.0, 10.0], 0.0)
    return rows, scores


@pytest.fixture(params=SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def size(request):
    return request.param


def test_fit_ours(benchmark, size):
    rows, scores = labels(*size)
    gaussian_process.fit(rows, scores)  # compiles
    found = benchmark.pedantic(gaussian_process.fit, (rows, scores), rounds=3)
    benchmark.extra_info["energy"] = found.search.energy
    benchmark.extra_info["evaluations"] = found.search.evaluations


def test_predict_5000_models(benchmark, size):
    rows, scores = labels(*size)
    found = gaussian_process.fit(rows, scores)
    benchmark(found.predict, labels(5000, size[1], seed=1)[0])


def test_fit_gpytorch(benchmark, size):
    gpytorch = pytest.importorskip("gpytorch")
    import torch  # pyright: ignore[reportMissingImports]

    torch.set_num_threads(1)
    torch.set_default_dtype(torch.float64)
    rows, scores = labels(*size)
    X, u = torch.tensor(rows), torch.tensor(scores)

    class Model(gpytorch.models.ExactGP):
        def __init__(self, likelihood):
            super().__init__(X, u, likelihood)
            self.mean_module = gpytorch.means.ZeroMean()
            self.covar_module = gpytorch.kernels.ScaleKernel(gpytorch.kernels.RBFKernel(ard_num_dims=rows.shape[1]))

        def forward(self, x):
            return gpytorch.distributions.MultivariateNormal(self.mean_module(x), self.covar_module(x))

    likelihood = gpytorch.likelihoods.FixedNoiseGaussianLikelihood(torch.full((len(u),), NOISE))
    model = Model(likelihood)
    evidence = gpytorch.mlls.ExactMarginalLogLikelihood(likelihood, model)
    model.train()

    def energy(log_theta):
        point = torch.tensor(log_theta, requires_grad=True)
        theta = torch.exp(point)
        kernel = gpytorch.kernels.ScaleKernel(gpytorch.kernels.RBFKernel(ard_num_dims=rows.shape[1]))
        for module, name, value in (
            (kernel, "raw_outputscale", kernel.raw_outputscale_constraint.inverse_transform(theta[0])),
            (
                kernel.base_kernel,
                "raw_lengthscale",
                kernel.base_kernel.raw_lengthscale_constraint.inverse_transform(theta[1:] ** -0.5)[None],
            ),
        ):
            delattr(module, name)
            setattr(module, name, value)
        model.covar_module = kernel
        value = -evidence(model(X), u) * len(u) + PENALTY * theta[1:].sum()
        value.backward()
        return value.item(), point.grad.numpy()

    compare(benchmark, energy, rows, scores, rounds=2)


def test_fit_scikit_learn(benchmark, size):
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel

    rows, scores = labels(*size)
    scales: Any = np.ones(rows.shape[1])
    options: dict[str, Any] = {"kernel": ConstantKernel(1.0) * RBF(scales), "alpha": NOISE, "optimizer": None}
    regressor = GaussianProcessRegressor(**options).fit(rows, scores)

    def energy(log_theta):
        weights = np.exp(log_theta[1:])
        theta = np.concatenate((log_theta[:1], -0.5 * log_theta[1:]))
        found: Any = regressor.log_marginal_likelihood(theta, eval_gradient=True, clone_kernel=False)
        value, gradient = found
        by_log_theta = np.concatenate((-gradient[:1], 0.5 * gradient[1:] + PENALTY * weights))
        return -value + PENALTY * weights.sum(), by_log_theta

    if size[0] > 256:
        benchmark.pedantic(energy, (start_of(rows, scores),), rounds=1, warmup_rounds=0)
        benchmark.extra_info["seconds for 100"] = 100 * benchmark.stats["min"]
    else:
        compare(benchmark, energy, rows, scores, rounds=1)


def start_of(rows, scores):
    start = common_relevance(observe(rows, scores), NOISE, PENALTY)
    return np.log(np.concatenate(([start.amplitude], np.maximum(start.weights, np.exp(LOW)))))


def compare(benchmark, energy, rows, scores, rounds):
    """Minimise another library's energy, time it and note where it ended."""
    found = []

    def run():
        start = start_of(rows, scores)
        low, high = np.full(len(start), LOW), np.full(len(start), HIGH)
        with threadpool_limits(1):
            found.append(minimise(energy, start, low, high, max_iterations=MAX_ITERATIONS))

    began = time.perf_counter()
    benchmark.pedantic(run, rounds=rounds)
    benchmark.extra_info["energy"] = found[0].value
    benchmark.extra_info["evaluations"] = found[0].evaluations
    benchmark.extra_info["seconds in all"] = time.perf_counter() - began
