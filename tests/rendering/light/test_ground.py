"""Where the ground can be darker: nothing outside that area is ever in shadow or hemmed in."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.light.ground import _hull_sides
from grammarlab.rendering.light.lighting import openness, sun_spread, sun_visibility
from grammarlab.rendering.light.look import Look
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.rendering.shot import take
from tests.rendering.models import CASCADE, TOWER, batch

UP = np.array([0, 1, 0], np.float32)


def shot_of(text, look):
    model = batch(text)
    return take(model, frame(model.vertices, 1.0, View()), RenderOptions(look=look), for_rays=True)


@pytest.mark.parametrize("text", [CASCADE, TOWER, 'Lot --> color("#ffffff") Lawn.'])
@pytest.mark.parametrize("elevation", [10.0, 44.0, 90.0])
def test_the_ground_that_rays_do_not_meet_is_in_full_light(text, elevation):
    look = Look(sun_elevation=elevation, sun_softness=0.05)
    shot = shot_of(text, look)
    side = np.linspace(-9, 9, 200, dtype=np.float32)
    x, z = (grid.ravel() for grid in np.meshgrid(side, side))
    above = np.stack([x, np.full_like(x, 5), z], axis=1)
    met, points = shot.ground.meet(above, np.broadcast_to(-UP, above.shape))
    assert np.allclose(points, above[met] * (1, 0, 1) + UP * shot.ground.height, atol=1e-5)
    outside = np.setdiff1d(np.arange(len(x)), met)
    places = above[outside] * (1, 0, 1) + UP * shot.ground.height
    normals = np.broadcast_to(UP, places.shape)
    spot = (np.arange(len(places)) % 16 / 16).astype(np.float32)
    assert sun_visibility(shot.model.blockers, places, normals, shot.sun, look, spot).all()
    assert (openness(shot.model.blockers, places, normals, np.arange(len(places)), 4) == 1).all()


@pytest.mark.parametrize("elevation", [-5.0, 0.0])
def test_without_sun_only_what_is_near_can_be_dark(elevation):
    shot = shot_of(CASCADE, Look(sun_elevation=elevation))
    above = np.array([[0, 5, 0], [5, 5, 0], [0, 5, -5]], np.float32)
    met, _ = shot.ground.meet(above, np.broadcast_to(-UP, above.shape))
    assert met.tolist() == [0]


def test_rays_that_look_up_meet_no_ground():
    shot = shot_of(CASCADE, Look())
    origins = np.zeros((3, 3), np.float32)
    met, _ = shot.ground.meet(origins, np.array([[0, 1, 0], [1, 0, 0], [0, -1, 0]], np.float32))
    assert met.tolist() == [2]


def test_the_spread_of_the_sun_holds_its_disc():
    look = Look(sun_softness=0.1)
    sun = np.array([0.6, 0.8, 0.0], np.float32)
    corners = sun_spread(sun, look)
    assert np.allclose(corners.mean(axis=0), sun, atol=1e-6)
    assert np.linalg.norm(corners - sun, axis=1) == pytest.approx(0.1 * np.sqrt(2), abs=1e-5)
    assert np.allclose((corners - sun) @ sun, 0, atol=1e-6)


@pytest.mark.parametrize("num", [3, 8, 128])
def test_sides_around_all_shadow_are_those_of_the_convex_hull(num: int):
    points = np.random.default_rng(num).normal(size=(num, 2))
    sides, expected = _hull_sides(np.vstack([points, points[:2]])), ConvexHull(points).equations
    found, wanted = (values[np.lexsort(values.round(6).T)] for values in (sides, expected))
    np.testing.assert_allclose(found, wanted, atol=1e-12)
    # Points on a side are no corners of their own.
    grid = np.indices((4, 3)).reshape(2, -1).T.astype(np.float64)
    assert len(_hull_sides(grid)) == 4
