import time
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.measure import area_vectors, is_closed
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.triangulate import contains, keyhole, triangulate
from tests.geometry.polygons import simple

QUICK = settings(max_examples=40, deadline=None)


def square(x, y, size, clockwise=False):
    ring = np.array([[x, y], [x + size, y], [x + size, y + size], [x, y + size]], float)
    return ring[::-1] if clockwise else ring


@st.composite
def perforated(draw):
    """A square of size 12 with square holes in some of nine cells."""
    cells = draw(st.lists(st.integers(0, 8), min_size=1, max_size=9, unique=True))
    sizes = draw(st.lists(st.floats(0.5, 3.0), min_size=9, max_size=9))
    holes = [square(4 * (c % 3) + 0.4, 4 * (c // 3) + 0.4, sizes[c], clockwise=True) for c in cells]
    start = draw(st.integers(0, 3))
    return [np.roll(square(0, 0, 12.0), start, axis=0), *holes]


@QUICK
@given(perforated())
def test_a_walk_visits_every_corner_and_crosses_nothing(rings):
    points = np.concatenate(rings)
    walk = keyhole(rings)
    assert set(walk.tolist()) == set(range(len(points)))
    assert len(walk) == len(points) + 2 * (len(rings) - 1)
    face = Meshes.single(np.insert(points, 1, 0.0, axis=1) * [1, 1, -1], [walk.tolist()])
    expected = shapely.Polygon(rings[0], rings[1:]).area
    assert area_vectors(face)[0, 1] == pytest.approx(expected)
    triangles, _ = triangulate(face)
    a, b, c = (face.points[triangles[:, k]] for k in range(3))
    sizes = 0.5 * np.cross(b - a, c - a)[:, 1]
    assert (sizes >= 0.0).all()
    assert sizes.sum() == pytest.approx(expected)


TOUCHING = (
    # A hole at a corner of its outline: the third one from it, the first, the second, and a reflex one.
    "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (4 7, 7 4, 10 10, 4 7))",
    "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (4 2, 2 4, 0 0, 4 2))",
    "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (10 0, 8 4, 5 3, 10 0))",
    "POLYGON ((0 20, 14 20, 14 13, 30 13, 30 0, 0 0, 0 20), (11 17, 11 13, 14 13, 11 17))",
    # Holes at one point: two, and two with the outline.
    "POLYGON ((0 0, 20 0, 20 20, 0 20, 0 0), (10 10, 10 15, 5 15, 5 10, 10 10), (15 10, 15 5, 10 5, 10 10, 15 10))",
    "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (0 0, 1 8, 2 8, 0 0), (0 0, 8 2, 8 1, 0 0), (0 0, 5 6, 6 5, 0 0))",
    # A corner of a hole within an edge of the outline, and the reverse.
    "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (10 5, 6 3, 6 7, 10 5))",
    "POLYGON ((0 0, 10 0, 10 10, 7 5, 0 10, 0 0), (5 5, 5 2, 9 2, 9 5, 5 5))",
)


@pytest.mark.parametrize("text", TOUCHING)
def test_where_rings_touch_every_edge_is_passed_once_and_bridges_lie_within(text):
    polygon = shapely.from_wkt(text).normalize().reverse()
    assert polygon.is_valid
    rings = [np.array(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
    for _ in range(len(rings[0])):
        rings[0] = np.roll(rings[0], 1, axis=0)
        points = np.concatenate(rings)
        walk = keyhole(rings)
        assert set(walk.tolist()) == set(range(len(points)))
        assert points[walk[:2]].tolist() == rings[0][:2].tolist()
        passed = Counter(_arcs(points[walk]))
        passed.subtract(arc for ring in rings for arc in _arcs(ring))
        bridges = [arc for arc, times in passed.items() if times]
        assert all(passed[start, end] == passed[end, start] == 1 for start, end in bridges)
        for line in map(shapely.LineString, bridges):
            assert polygon.covers(line)
            assert polygon.boundary.intersection(line).length == 0.0
        face = Meshes.single(np.insert(points, 1, 0.0, axis=1) * [1, 1, -1], [walk.tolist()])
        solid = extrude(face, np.ones(1))
        assert is_closed(solid).all()
        assert np.linalg.norm(area_vectors(solid), axis=1).sum() == pytest.approx(2 * polygon.area + polygon.length)


def test_hundreds_of_holes_are_joined_in_moments():
    holes = [square(3.0 * i + 2.0, 4.0, 1.0, clockwise=True) for i in range(300)]
    begin = time.process_time()
    walk = keyhole([square(0.0, 0.0, 903.0), *holes])
    assert time.process_time() - begin < 2.0
    assert len(walk) == 4 + 300 * 6


@QUICK
@given(simple)
def test_an_outline_without_holes_is_walked_as_it_is(ring):
    assert keyhole([ring]).tolist() == list(range(len(ring)))


@QUICK
@given(simple, st.tuples(st.floats(-1, 1), st.floats(-1, 1)))
def test_containment_is_that_of_shapely(ring, place):
    center = ring.mean(axis=0) + np.array(place) * np.ptp(ring, axis=0)
    small = center + square(-0.5, -0.5, 1.0) * 1e-6 * np.ptp(ring)
    polygon = shapely.Polygon(ring)
    if polygon.boundary.distance(shapely.Point(center)) > 1e-5 * np.ptp(ring):
        assert contains(ring, small) == polygon.contains(shapely.Point(center))


def _arcs(ring):
    return list(pairwise([*map(tuple, ring.tolist()), tuple(ring[0].tolist())]))
