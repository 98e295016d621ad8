"""Matrices of tiles against the projections of pyproj."""

from __future__ import annotations

import numpy as np
import pytest
from pyproj import Transformer

from grammarlab.export.tiles.earth_placement import UPWARDS, EarthPlacement
from grammarlab.geometry.footprints.frame import Frame

PARIS, EDGE, LAMBERT = ("EPSG:32631", (448e3, 5412e3)), ("EPSG:32632", (750e3, 5500e3)), ("EPSG:2154", (652e3, 6862e3))
EQUAL_AREA, LONDON = ("EPSG:3035", (3760e3, 2890e3)), ("EPSG:27700", (530e3, 180e3))


@pytest.mark.parametrize("place", [PARIS, EDGE, LAMBERT, EQUAL_AREA, LONDON])
def test_a_corner_10_km_off_is_right_to_a_centimetre(place):
    crs, origin = place
    placement = EarthPlacement(Frame(crs, origin), geoid_height=44.0)
    tiles = np.array([[0.0, 0.0, 0.0], [10_048.0, 0.0, -192.0], [-7_104.0, 0.0, 7_104.0]])
    corners = np.array([[64.0, 30.0, -64.0], [-64.0, 0.0, 64.0], [80.0, 120.0, 0.0]])
    root = placement.root_transform()
    assert root is not None
    to_degrees = Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
    to_earth = Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
    for tile, matrix in zip(tiles, placement.tile_matrices(tiles), strict=True):
        # As viewers do it: the tile's matrix, y up to z up, the root's matrix.
        points = (root @ UPWARDS @ matrix @ np.column_stack((corners, np.ones(3))).T).T[:, :3]
        x, y, z = (tile + corners).T
        longitude, latitude = to_degrees.transform(x + origin[0], origin[1] - z)
        target = np.column_stack(to_earth.transform(longitude, latitude, y + 44.0))
        assert np.linalg.norm(points - target, axis=1).max() < 0.01


def test_the_root_is_a_rotation_whose_third_axis_is_up():
    root = EarthPlacement(Frame(*EDGE)).root_transform()
    assert root is not None
    np.testing.assert_allclose(root[:3, :3].T @ root[:3, :3], np.eye(3), atol=1e-12)
    assert np.linalg.det(root[:3, :3]) == pytest.approx(1.0)
    # The normal of the ellipsoid is within 0.2 degrees of the direction from the middle of the earth.
    assert root[:3, 2] @ root[:3, 3] / np.linalg.norm(root[:3, 3]) > np.cos(np.radians(0.2))
    # Grid north: 2.3 degrees from north at the edge of a zone.
    north = np.cross(root[:3, 2], np.cross([0.0, 0.0, 1.0], root[:3, 2]))
    angle = np.degrees(np.arccos(root[:3, 1] @ north / np.linalg.norm(north)))
    assert 2.0 < angle < 3.0


def test_an_unknown_place_has_no_transform():
    placement = EarthPlacement(Frame("", (0.0, 0.0)))
    assert placement.root_transform() is None
    (matrix,) = placement.tile_matrices(np.array([[64.0, 0.0, -64.0]]))
    np.testing.assert_array_equal(matrix @ [1.0, 2.0, 3.0, 1.0], [65.0, 2.0, -61.0, 1.0])
