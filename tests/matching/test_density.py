"""The density of points around the visible part of an outline."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from grammarlab.matching.point_density import OUTLIERS, log_likelihood, visible

SQUARE = np.array([[[0, 0], [2, 0]], [[2, 0], [2, 1]], [[2, 1], [0, 1]], [[0, 1], [0, 0]]], dtype=float)

ALONE = jax.jit(jax.vmap(log_likelihood, in_axes=(None, None, None, None, 0, None, None)))
"""Of one point after the other."""


@pytest.mark.parametrize(("angle", "cut"), [(0.0, 9.0), (0.0, 1.25), (0.7, 1.0), (2.0, 0.1)])
def test_it_integrates_to_one(angle, cut):
    across, up = np.meshgrid(np.arange(-1, 3, 0.02), np.arange(-1, 2, 0.02), indexing="ij")
    points = np.stack([across.ravel(), up.ravel()], axis=1)
    area = 4.0 * 3.0
    given = jnp.asarray(SQUARE), jnp.asarray(angle), jnp.asarray(cut), jnp.asarray(0.1)
    values = np.asarray(ALONE(*given, jnp.asarray(points[::7, None]), jnp.ones(1), jnp.asarray(area)))
    assert np.exp(values).mean() * area == pytest.approx(1.0, abs=0.06)
    assert values.min() >= np.log(OUTLIERS / area) - 1e-5


def test_what_lies_behind_the_half_plane_is_not_visible():
    start, end = visible(jnp.asarray(SQUARE), jnp.asarray(0.0), jnp.asarray(1.25))
    assert np.asarray(end - start) == pytest.approx([1.25, 0.0, 1.25, 1.0], abs=1e-5)
