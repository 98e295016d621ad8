"""Vertices that rays need only once."""

from __future__ import annotations

import numpy as np

from grammarlab.rendering.light.rays import Tracer, welded

AROUND = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]], dtype=np.float32)


def test_welded_vertices_are_the_same_vertices_each_once():
    points, place = welded(AROUND)
    assert np.array_equal(points[place], AROUND)
    assert len(points) == len(np.unique(AROUND, axis=0)) == 4


def test_vertices_that_differ_in_one_bit_stay_apart():
    close = np.array([[1, 2, 3], [np.nextafter(np.float32(1), np.float32(2)), 2, 3], [1, 2, 3]], dtype=np.float32)
    points, place = welded(close)
    assert np.array_equal(points[place], close)
    assert len(points) == 2


def test_no_vertices_are_no_points():
    points, place = welded(np.zeros((0, 3), np.float32))
    assert points.shape == (0, 3)
    assert place.shape == (0,)


def test_rays_hit_the_same_triangles_through_welded_vertices():
    rng = np.random.default_rng(0)
    vertices = rng.integers(-2, 3, (300, 3)).astype(np.float32)
    triangles = np.arange(300).reshape(-1, 3)
    points, place = welded(vertices)
    origins, directions = rng.normal(0, 1, (500, 3)), rng.normal(0, 1, (500, 3))
    apart = Tracer(vertices, triangles).first_hit(origins, directions)
    together = Tracer(points, place[triangles]).first_hit(origins, directions)
    assert np.array_equal(apart.distance, together.distance)
