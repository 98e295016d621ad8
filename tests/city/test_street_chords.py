import numpy as np
import pytest
import shapely

from grammarlab.city.direction_field import DirectionField, directions_on
from grammarlab.city.street_chords import (
    Ring,
    bent,
    contains,
    divided,
    nearest_edge,
    ring_area,
    traced_both_ways,
    traced_inwards,
)

CONCAVE = np.array([(0, 0), (800, -100), (1000, 500), (600, 300), (200, 600)], dtype=float)
SHAPE = shapely.Polygon(CONCAVE)
POINTS = np.random.default_rng(1).uniform((0, -100), (1000, 600), (200, 2))


def test_areas_and_inner_points_equal_those_of_shapely():
    assert ring_area(CONCAVE) == pytest.approx(SHAPE.area)
    assert ring_area(CONCAVE[::-1]) == pytest.approx(-SHAPE.area)
    assert [contains(CONCAVE, point) for point in POINTS] == shapely.contains_xy(SHAPE, POINTS).tolist()


def test_nearest_points_of_a_ring_equal_those_of_shapely():
    _, distance, nearest = nearest_edge(CONCAVE, POINTS)
    assert np.allclose(distance, shapely.distance(SHAPE.exterior, shapely.points(POINTS)))
    assert shapely.distance(SHAPE.exterior, shapely.points(nearest)).max() < 1e-9


@pytest.mark.parametrize("kind", ["grid", "radial", "mixed"])
@pytest.mark.parametrize("heading", [0.0, 1.6])
def test_both_parts_of_a_ring_fill_it(kind: str, heading: float):
    directions = directions_on(DirectionField(kind, centre=(900.0, 1200.0)), SHAPE)  # type: ignore[arg-type, ty:invalid-argument-type]
    for point in POINTS[shapely.contains_xy(SHAPE, POINTS)][:20]:
        chord = traced_both_ways(CONCAVE, directions, point, heading)
        assert chord is not None
        parts = divided(Ring(CONCAVE, np.full(5, 8.0)), chord, 3.0)
        shapes = [shapely.Polygon(part.corners) for part in parts]
        # The ends of the chord are rounded to millimetres, beside the edges they are on.
        assert sum(part.area for part in parts) == pytest.approx(SHAPE.area, rel=1e-6)
        assert all(shape.is_valid for shape in shapes)
        assert shapes[0].intersection(shapes[1]).area < 1e-6
        assert [(part.width == 3.0).sum() for part in parts] == [len(chord.points) - 1] * 2


def test_a_line_around_a_centre_is_a_circle():
    half = shapely.Polygon([(-600, 0), (600, 0), (600, 600), (-600, 600)])
    corners = np.array(half.exterior.coords[:-1])
    directions = directions_on(DirectionField("radial", centre=(0.0, 0.0)), half)
    chord = traced_inwards(corners, directions, np.array([250.0, 0.0]), 0, np.pi / 2)
    assert chord is not None
    assert np.abs(np.hypot(*chord.points.T) - 250).max() < 0.3
    assert chord.points[-1] == pytest.approx((-250, 0), abs=0.3)


def test_a_bent_chord_ends_at_its_target_and_keeps_the_other_end():
    directions = directions_on(DirectionField(angle=0.0), SHAPE)
    chord = traced_both_ways(CONCAVE, directions, np.array([300.0, 200.0]), 0.0)
    assert chord is not None
    for end in (0, 1):
        moved = bent(chord, end, CONCAVE[4], 4)
        assert (moved.points[-end] == CONCAVE[4]).all()
        assert (moved.points[end - 1] == chord.points[end - 1]).all()
