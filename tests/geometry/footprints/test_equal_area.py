"""Surfaces: their cells have equal areas, and their distances are those on the ground."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.footprints.equal_area import Ellipsoid, Plane
from tests.geometry.footprints.test_ground import E2, A, zone

latitudes = st.floats(-88.0, 88.0)


@given(latitudes, st.floats(0.5, 500.0))
def test_a_cell_of_the_earth_has_the_area_of_its_square(latitude, side):
    """By the formula of the area of zones of the ellipsoid."""
    sides = Ellipsoid().sides(side)
    row = math.floor(Ellipsoid().boxes(np.array([[0.0, latitude, 0.0, latitude]]), 0.0)[0, 0, 1] / sides[1])
    corners = Ellipsoid().coordinates(np.array([[0, row], [1, row + 1]]) * sides)
    (west, south), (east, north) = corners.tolist()
    area = math.radians(east - west) * (zone(north) - zone(south))
    assert area == pytest.approx(side * side, rel=2e-5 / side + 1e-9)
    assert sides[0] * round(2 * math.pi * A / sides[0]) == pytest.approx(2 * math.pi * A)


@given(st.floats(-180.0, 180.0), latitudes, st.floats(0, 2 * math.pi))
def test_distances_of_near_points_are_those_on_the_ellipsoid(longitude, latitude, direction):
    """By the radii of curvature of the meridian and across it."""
    curvature = 1 - E2 * math.sin(math.radians(latitude)) ** 2
    east = math.radians(A / math.sqrt(curvature) * math.cos(math.radians(latitude)))
    north = math.radians(A * (1 - E2) / curvature**1.5)
    step = [10 * math.cos(direction) / east, 10 * math.sin(direction) / north]
    one, other = Ellipsoid().space(np.array([[longitude, latitude], [longitude + step[0], latitude + step[1]]]))
    assert math.dist(one, other) == pytest.approx(10.0, rel=2e-4)


@given(st.floats(-180.0, 180.0), st.floats(-85.0, 85.0), st.floats(0, 2 * math.pi), st.floats(1.0, 5000.0))
@settings(max_examples=50)
def test_a_margin_has_all_points_at_its_distance(longitude, latitude, direction, margin):
    """Points by the formula of a sphere that is larger than the earth, so that they are not farther than the margin."""
    angle, phi = margin / 6.4e6, math.radians(latitude)
    north = math.asin(math.sin(phi) * math.cos(angle) + math.cos(phi) * math.sin(angle) * math.cos(direction))
    turn = math.atan2(
        math.sin(direction) * math.sin(angle) * math.cos(phi), math.cos(angle) - math.sin(phi) * math.sin(north)
    )
    low, high = Ellipsoid().boxes(np.array([[longitude, latitude, longitude, latitude]]), margin)[0]
    height = Ellipsoid().boxes(np.degrees([[0, north, 0, north]]), 0.0)[0, 0, 1]
    point = np.array([A * (math.radians(longitude) + turn), height])
    assert (low <= point).all()
    assert (point <= high).all()


def test_columns_are_numbered_once_around_the_earth():
    number = round(2 * math.pi * A / Ellipsoid().sides(100.0)[0])
    columns = Ellipsoid().columns(np.arange(-2, number + 2), 100.0)
    assert columns[:4].tolist() == [-2, -1, 0, 1]
    assert columns[-4:].tolist() == [-2, -1, 0, 1]
    assert sorted(columns[2:-2].tolist()) == list(range(-(number // 2), number - number // 2))


def test_a_plane_is_its_own_map():
    points = np.array([[3.0, 4.0], [-5.0, 6.0]])
    assert (Plane().space(Plane().coordinates(points)) == points).all()
    assert Plane().boxes(np.array([[0.0, 1.0, 2.0, 3.0]]), 5.0).tolist() == [[[-5, -4], [7, 8]]]
    assert Plane().sides(7.0).tolist() == [7, 7]
