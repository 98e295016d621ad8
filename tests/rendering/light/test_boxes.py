"""Rays without Embree: the hits of a loop over all pairs, those of Embree, and bounded memory."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from grammarlab.arrays import AnyFloats
from grammarlab.rendering.light import box_tree, rays
from grammarlab.rendering.light.box_tree import BoxedTriangles
from grammarlab.rendering.light.rays import Tracer, has_embree
from tests.rendering.models import CASCADE, GLASS, TOWER, batch, picture

TEXTS = {"tower": TOWER, "glass": GLASS, "cascade": CASCADE}
needs_embree = pytest.mark.skipif(not has_embree(), reason="no package of Embree for this machine")


def soup(rng: np.random.Generator, num_triangles: int) -> tuple[AnyFloats, np.ndarray]:
    """Triangles anywhere about the middle."""
    corners = rng.normal(0, 0.3, (num_triangles, 1, 3)) + rng.normal(0, 0.5, (num_triangles, 3, 3))
    return corners.reshape(-1, 3).astype(np.float32), np.arange(3 * num_triangles).reshape(-1, 3)


def lines(rng: np.random.Generator, num_rays: int) -> tuple[AnyFloats, AnyFloats]:
    """Rays from anywhere to the middle; some are parallel to an axis."""
    origins = rng.uniform(-2, 2, (num_rays, 3)).astype(np.float32)
    directions = rng.normal(0, 0.5, (num_rays, 3)).astype(np.float32) - origins
    directions[: num_rays // 4, rng.integers(3)] = 0
    directions[: num_rays // 8] = np.eye(3, dtype=np.float32)[rng.integers(3, size=num_rays // 8)]
    return origins, directions


def distances(vertices: AnyFloats, triangles: np.ndarray, origins: AnyFloats, directions: AnyFloats) -> AnyFloats:
    """[N, T] of each ray to each triangle, infinite if it passes by: the solutions of 3 x 3 systems."""
    first, second, third = vertices.astype(np.float64)[triangles].transpose(1, 0, 2)
    systems = np.stack(
        np.broadcast_arrays(-directions[:, None].astype(np.float64), second - first, third - first), axis=-1
    )
    t, u, v = np.linalg.solve(systems, (origins[:, None] - first)[..., None])[..., 0].transpose(2, 0, 1)
    return np.where((t >= 0) & (u >= 0) & (v >= 0) & (u + v <= 1), t, np.inf)


@pytest.mark.parametrize("num_triangles", [1, 2, 3, 5, 64, 65, 300])
def test_hits_are_those_of_all_pairs(num_triangles: int):
    rng = np.random.default_rng(num_triangles)
    (vertices, triangles), (origins, directions) = soup(rng, num_triangles), lines(rng, 400)
    expected = distances(vertices, triangles, origins, directions)
    scene = BoxedTriangles(vertices, triangles)
    hits = scene.first_hit(origins, directions)
    nearest = expected.min(axis=1)
    assert np.array_equal(hits.triangle >= 0, np.isfinite(nearest))
    met = hits.triangle >= 0
    assert met.any()
    assert np.allclose(hits.distance[met], nearest[met], rtol=1e-3, atol=1e-4)
    points = origins[met] + hits.distance[met, None] * directions[met]
    u, v = hits.u[met, None], hits.v[met, None]
    first, second, third = vertices[triangles[hits.triangle[met]]].transpose(1, 0, 2)
    assert np.allclose(points, (1 - u - v) * first + u * second + v * third, atol=1e-3)
    assert np.array_equal(scene.is_blocked(origins, directions, None), met)
    reach = 0.5
    sure = np.abs(nearest - reach) > 1e-3
    assert np.array_equal(scene.is_blocked(origins, directions, reach)[sure], (nearest <= reach)[sure])


@needs_embree
@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_pictures_without_embree_are_those_with_it(text: str, monkeypatch: pytest.MonkeyPatch):
    with_embree = picture(batch(text)).astype(int)
    monkeypatch.setattr(rays, "has_embree", lambda: False)
    without = picture(batch(text)).astype(int)
    # Where two surfaces coincide, either may be hit.
    assert (np.abs(with_embree - without).max(axis=2) > 2).mean() < 0.002


def test_hits_do_not_depend_on_how_many_rays_are_traced_together(monkeypatch: pytest.MonkeyPatch):
    rng = np.random.default_rng(0)
    scene, (origins, directions) = BoxedTriangles(*soup(rng, 500)), lines(rng, 300)
    together = scene.first_hit(origins, directions)
    monkeypatch.setattr(box_tree, "BLOCK", 40)
    apart = scene.first_hit(origins, directions)
    assert np.array_equal(together.triangle, apart.triangle)
    assert np.array_equal(together.distance, apart.distance)


def test_triangles_on_top_of_each_other_take_no_more_memory_than_others():
    triangle = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32)
    vertices = np.tile(triangle, (5_000, 1))
    scene = BoxedTriangles(vertices, np.arange(15_000).reshape(-1, 3))
    origins = np.tile(np.array([[0, 0, 1]], np.float32), (500, 1))
    directions = np.tile(np.array([[0, 0, -1]], np.float32), (500, 1))
    tracemalloc.start()
    try:
        assert scene.is_blocked(origins, directions, None).all()
        assert np.allclose(scene.first_hit(origins, directions).distance, 1.0)
        assert tracemalloc.get_traced_memory()[1] < 64 << 20
    finally:
        tracemalloc.stop()


def test_the_tracer_does_without_embree(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(rays, "has_embree", lambda: False)
    rng = np.random.default_rng(1)
    (vertices, triangles), (origins, directions) = soup(rng, 20), lines(rng, 50)
    expected = np.isfinite(distances(vertices, triangles, origins, directions)).any(axis=1)
    assert np.array_equal(Tracer(vertices, triangles).is_blocked(origins, directions), expected)
