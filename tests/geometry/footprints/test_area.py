"""Areas: the outlines of a map taken together."""

import numpy as np
import pytest
import shapely

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.area import read_area
from tests.geometry.footprints.maps import SQUARE, collection, feature, moved, named, polygon, written
from tests.geometry.footprints.test_ground import area_on_the_ellipsoid, box

HOLE = [[4, 2], [6, 2], [6, 6], [4, 6], [4, 2]]


def test_holes_are_outside_and_the_size_is_that_of_the_union(tmp_path):
    """A square with a hole, one that overlaps it, and one apart."""
    features = [
        feature(polygon(SQUARE, HOLE)),
        feature(polygon(moved(SQUARE, 8, 0))),
        feature(polygon(moved(SQUARE, 50, 0))),
    ]
    area = read_area(written(tmp_path, collection(*features, crs=None)))
    assert area.size == pytest.approx(80 - 8 + 80 - 16 + 80)
    points = np.array([[1.0, 1.0], [5.0, 4.0], [9.0, 4.0], [17.0, 4.0], [30.0, 4.0], [55.0, 4.0], [-1.0, 4.0]])
    assert area.contains(points).tolist() == [True, False, True, True, False, True, False]
    assert area.is_near(points, 1.5).tolist() == [True, True, True, True, False, True, True]
    assert area.is_near(points, 0.5).tolist() == [True, False, True, True, False, True, False]
    assert area.bounds.tolist() == [[0, 0, 10, 8], [8, 0, 18, 8], [50, 0, 60, 8]]


def test_the_size_of_an_area_in_degrees_is_that_on_the_ground(tmp_path):
    area = read_area(written(tmp_path, collection(feature(polygon(box(7.1, 50.1, 2e-3, 1e-3))))))
    assert area.size == pytest.approx(area_on_the_ellipsoid(50.1, 2e-3, 1e-3), rel=1e-6)
    assert area.contains(np.array([[7.1, 50.1], [7.2, 50.1]])).tolist() == [True, False]
    assert area.east_north(np.array([[7.1, 50.1]])) == pytest.approx(0.0, abs=1e-6)


def test_outlines_on_the_ground_have_the_places_of_footprints(tmp_path):
    """Small outlines, whose own scale and that of the map of the ground agree to millimetres."""
    rings = [box(7.1, 50.1, 2e-3, 1e-3), box(7.12, 50.11, 1e-3, 1e-3)]
    area = read_area(written(tmp_path, collection(*(feature(polygon(ring)) for ring in rings))))
    assert area.ground is not None
    for outline, other in zip(area.outlines, area.ground.metres(area.polygons), strict=True):
        assert shapely.hausdorff_distance(outline, other) < 0.01


def test_what_footprints_refuse_is_refused(tmp_path):
    with pytest.raises(AssetError, match="self-intersection"):
        read_area("POLYGON ((40 0, 50 8, 50 0, 40 8, 40 0))")
    with pytest.raises(AssetError, match="too small"):
        read_area("POLYGON ((0 0, 50 0, 100 0, 0 0))".replace("100 0, 0 0", "100 0.0000001, 0 0"))
    with pytest.raises(AssetError, match="in degrees"):
        read_area(written(tmp_path, collection(feature(polygon(moved(SQUARE, 5e5, 5e6))))))
    mercator = collection(feature(polygon(moved(SQUARE, 5e5, 5e6))), crs=named("EPSG:4978"))
    with pytest.raises(AssetError, match="not one of places on a map"):
        read_area(written(tmp_path, mercator))
