"""Fits: derivatives against finite differences, and recovery of known parameters."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from grammarlab.matching.fit import energy
from grammarlab.matching.library import templates_by_name
from grammarlab.matching.paper_loop import similarity_energy
from grammarlab.matching.template import stack

ENERGY, SLOPE = jax.jit(energy), jax.jit(jax.grad(energy))
TEMPLATES = stack(templates_by_name("rectangle,gable,segment_arch"))


@pytest.mark.parametrize("template", range(3))
def test_the_gradient_of_a_fit_is_that_of_finite_differences(template):
    random = np.random.default_rng(3)
    with jax.enable_x64(True):
        pieces = jnp.asarray(TEMPLATES.pieces[template])
        points, weight = jnp.asarray(random.uniform(-0.2, 1.8, size=(30, 2))), jnp.ones(30)
        state = jnp.concatenate([jnp.array([0.05, 0.02]), jnp.asarray(TEMPLATES.usual[template])])
        given = pieces, points, weight, jnp.asarray(0.5)
        slope = np.asarray(SLOPE(state, *given))
        steps = 1e-6 * np.eye(len(state))
        found = [(float(ENERGY(state + step, *given)) - float(ENERGY(state - step, *given))) / 2e-6 for step in steps]
    assert slope == pytest.approx(np.array(found), abs=1e-6)


def test_coupled_parameters_that_are_equal_pull_at_nothing():
    parameters = np.tile([1.0, 2.0], (4, 1, 1))
    coupled = np.ones((1, 2, 4, 4)) - np.eye(4)
    slope = jax.jit(jax.grad(similarity_energy))(jnp.asarray(parameters), jnp.asarray(coupled))
    assert np.abs(slope).max() == 0.0
    moved = parameters.copy()
    moved[0, 0, 0] = 1.5
    assert float(similarity_energy(jnp.asarray(moved), jnp.asarray(coupled))) == pytest.approx(3 * 0.25)
