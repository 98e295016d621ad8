"""Fits: derivatives against finite differences, and recovery of known parameters."""

from dataclasses import fields, replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from grammarlab.matching import fit
from grammarlab.matching.elements import Clouds, clouds_of
from grammarlab.matching.fit import Fits, fit_all
from grammarlab.matching.library import templates_by_name
from grammarlab.matching.paper_loop import energy, residuals, similarity_energy
from grammarlab.matching.point_density import log_likelihood, outline
from grammarlab.matching.scenes import SceneOptions, rectangles
from grammarlab.matching.template import stack
from grammarlab.matching.template_text import parse_templates

ENERGY, SLOPE = jax.jit(energy), jax.jit(jax.grad(energy))
TEMPLATES = stack(templates_by_name("rectangle,gable,segment_arch"))
SEVERAL = templates_by_name("rectangle,segment_arch,arch,bulging_column")
"""Templates with 2, 3, 2 and 6 parameters, straight ones and arcs."""
EMPTY_PIECES = parse_templates("""
template last
  param width 0.9 (0.3 to 3)
  param height 1.2 (0.3 to 3)
  line (0, 0) -> (width, 0)
  line (width, 0) -> (width, height)
  line (width, height) -> (0, height)
  line (0, height) -> (0, 0)
  line (width, 0) -> (width, 0)
end
template first
  param width 0.9 (0.3 to 3)
  param height 1.2 (0.3 to 3)
  repeat i 0 to 2
    line (0, height) -> (width * i / 2, height)
  end
end
""")
"""Templates with a piece that has length 0 at all sizes."""
CLOUDS = clouds_of(rectangles(SceneOptions(elements=3, kinds=3, points=40), 2), np.arange(3))
FITS = fit_all(CLOUDS, stack((*SEVERAL, *EMPTY_PIECES)))


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


def test_distances_and_their_derivatives_are_those_of_automatic_differentiation():
    random = np.random.default_rng(5)
    for indices, wires in fit._by_parameters(stack(SEVERAL[1:2])):
        points = fit._Points(CLOUDS.points, CLOUDS.weight, CLOUDS.area, CLOUDS.reach)
        state = fit.first_guess(CLOUDS.reach, wires.stack)
        state = state * random.uniform(0.8, 1.2, state.shape)
        fitted = fit._residuals(points, state, wires)
        for row in range(len(indices)):
            pieces = jnp.asarray(wires.pieces[wires.owner == row])
            both = jax.jit(lambda state, points, pieces=pieces: (residuals(state, pieces, points),) * 2)
            with jax.enable_x64(True):
                slopes, values = jax.jacfwd(both, has_aux=True)(
                    jnp.asarray(state[1, row]), jnp.asarray(CLOUDS.points[1])
                )
            assert np.asarray(values) == pytest.approx(fitted.value[1, row], abs=1e-5)
            # A point as far from two pieces as from the other one may have either derivative.
            differ = np.abs(np.asarray(slopes).T - fitted.slopes[1, row]).max(axis=0) > 1e-3
            assert differ.mean() < 0.03


def test_costs_are_those_of_the_density_of_points():
    pieces, size = jnp.asarray(SEVERAL[1].pieces), len(SEVERAL[1].parameters)

    @jax.jit
    def density(corner: jax.Array, parameters: jax.Array, *numbers: jax.Array) -> jax.Array:
        return log_likelihood(outline(pieces, parameters) + corner, *numbers)

    for element in range(3):
        points = CLOUDS.points[element], CLOUDS.weight[element], CLOUDS.area[element]
        fitted = (
            FITS.corner[element, 1],
            FITS.parameters[element, 1, :size],
            *FITS.plane[element, 1],
            FITS.noise[element, 1],
        )
        value = float(density(*(jnp.asarray(each) for each in (*fitted, *points))))
        assert FITS.cost[element, 1] == pytest.approx(-value, abs=0.01)


def test_a_fit_does_not_depend_on_the_templates_and_elements_beside_it():
    for row, template in enumerate((*SEVERAL, *EMPTY_PIECES)):
        for elements in ([0, 1, 2], [1]):
            alone: Fits = fit_all(_subset(elements), stack([template]))
            _assert_equal(alone, FITS.subset(np.array(elements)), row, len(template.parameters))


def test_pieces_of_length_0_change_no_fit():
    for row, template in enumerate(EMPTY_PIECES, len(SEVERAL)):
        size = len(template.parameters)
        wires = template.wires[~(template.wires[:, :2] == template.wires[:, 2:4]).all(axis=(1, 2))]
        assert 0 < len(wires) < len(template.wires)
        _assert_equal(fit_all(CLOUDS, stack([replace(template, wires=wires)])), FITS, row, size)


def _assert_equal(alone: Fits, fits: Fits, row: int, size: int) -> None:
    """Fits of one template are those of a row of other fits."""
    assert alone.parameters[:, 0] == pytest.approx(fits.parameters[:, row, :size], abs=1e-6)
    assert alone.covariance[:, 0] == pytest.approx(fits.covariance[:, row, :size, :size], rel=1e-3, abs=1e-9)
    assert alone.cost[:, 0] == pytest.approx(fits.cost[:, row], abs=1e-3)


def _subset(elements: list[int]) -> Clouds:
    """Some of the elements."""
    return Clouds(**{field.name: getattr(CLOUDS, field.name)[elements] for field in fields(CLOUDS)})
