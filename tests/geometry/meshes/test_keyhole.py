import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes.measure import area_vectors
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
