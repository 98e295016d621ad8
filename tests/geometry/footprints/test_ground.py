"""Degrees as metres on the ground, checked by formulas that the code does not use."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.footprint_text import read_footprint_map
from tests.geometry.footprints.maps import area, collection, feature, polygon, written

A, E2 = 6378137.0, 0.0066943799901413165
"""Equatorial radius in metres and squared eccentricity of WGS 84."""


def box(longitude, latitude, width=1e-4, depth=1e-4):
    """Ring of a box of degrees around a place."""
    w, d = width / 2, depth / 2
    return [[longitude + u * w, latitude + v * d] for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))]


def zone(latitude):
    """Area of the ellipsoid from the equator to a latitude, for each radian of longitude."""
    e, sine = math.sqrt(E2), math.sin(math.radians(latitude))
    return A * A * (1 - E2) / 2 * (sine / (1 - E2 * sine * sine) + math.atanh(e * sine) / e)


def area_on_the_ellipsoid(latitude, width, depth):
    return math.radians(width) * (zone(latitude + depth / 2) - zone(latitude - depth / 2))


def read(folder, *rings):
    return read_footprint_map(written(folder, collection(*(feature(polygon(ring)) for ring in rings))))


@given(st.lists(st.tuples(st.floats(-180, 180), st.floats(-80, 80)), min_size=1, max_size=5))
def test_each_outline_has_its_area_on_the_ground_wherever_the_others_are(tmp_path_factory, places):
    plan = read(tmp_path_factory.mktemp("map"), *(box(*place) for place in places))
    expected = [area_on_the_ellipsoid(latitude, 1e-4, 1e-4) for _, latitude in places]
    if len(plan.footprints) == len(places):  # none is on the other side of the earth
        assert [area(footprint) for footprint in plan.footprints] == pytest.approx(expected, rel=1e-6)


def test_equal_outlines_20_degrees_apart_are_equal(tmp_path):
    """Boxes of 20 x 12 m at several latitudes."""
    rings = []
    for longitude, latitude in ((7.1, 30.0), (7.1, 50.0), (27.1, 70.0)):
        curvature = 1 - E2 * math.sin(math.radians(latitude)) ** 2
        east = math.radians(A / math.sqrt(curvature) * math.cos(math.radians(latitude)))
        north = math.radians(A * (1 - E2) / curvature**1.5)
        rings.append(box(longitude, latitude, 20 / east, 12 / north))
    areas = [area(footprint) for footprint in read(tmp_path, *rings).footprints]
    assert areas == pytest.approx([240, 240, 240], rel=1e-6)


def test_neighbours_share_their_wall_10_km_from_the_middle(tmp_path):
    """Two houses that touch, with two others that make a middle 10 km to the south west."""
    west, east = box(7.1, 50.1), box(7.1001, 50.1)
    others = [box(6.9, 49.9), box(6.9002, 49.9), box(6.9004, 49.9)]
    first, second, *_ = read(tmp_path, west, east, *others).footprints
    assert np.linalg.norm(first.polygon[1] - second.polygon[0]) < 0.001
    assert np.linalg.norm(first.polygon[2] - second.polygon[3]) < 0.001


def test_places_keep_their_distances(tmp_path):
    """Along a meridian by its arc, in 10,000 steps; along a parallel by the arc of its circle."""
    south, north = read(tmp_path, box(7, 50.0), box(7, 50.4)).footprints
    latitudes = np.radians(50 + 0.4 * (np.arange(10_000) + 0.5) / 10_000)
    arc = np.sum(A * (1 - E2) / (1 - E2 * np.sin(latitudes) ** 2) ** 1.5) * math.radians(0.4) / 10_000
    rise = (south.polygon - north.polygon).mean(axis=0)
    assert rise == pytest.approx([0, 0, arc], rel=5e-6, abs=0.01)
    near = read(tmp_path, box(7, 50), box(7.01, 50)).footprints
    along = math.radians(0.01) * A / math.sqrt(1 - E2 * math.sin(math.radians(50)) ** 2) * math.cos(math.radians(50))
    assert np.linalg.norm((near[1].polygon - near[0].polygon).mean(axis=0)) == pytest.approx(along, rel=1e-6)


def test_the_place_is_the_middle(tmp_path):
    plan = read(tmp_path, box(7, 50), box(7.002, 50.001), box(7.001, 50.0004))
    assert plan.georeference is not None
    assert (plan.georeference.longitude, plan.georeference.latitude) == pytest.approx((7.001, 50.0004))
    assert np.abs(plan.footprints[2].polygon.mean(axis=0)).max() < 0.001


def test_a_stray_outline_does_not_move_the_town(tmp_path):
    town = [box(7 + k * 1e-3, 50) for k in range(5)]
    alone, astray = read(tmp_path, *town), read(tmp_path, *town, box(0, 0))
    for before, after in zip(alone.footprints, astray.footprints[:5], strict=True):
        assert np.ptp(after.polygon, axis=0) == pytest.approx(np.ptp(before.polygon, axis=0), abs=0.001)


@pytest.mark.parametrize("offset", [0.0, 360.0])
def test_the_date_line_is_no_seam(tmp_path, offset):
    """In one ring, in two features, and in longitudes from 0 to 360."""
    across = [
        [179.9999, 10],
        [-179.9999 + offset, 10],
        [-179.9999 + offset, 10.0002],
        [179.9999, 10.0002],
        [179.9999, 10],
    ]
    (one,) = read(tmp_path, across).footprints
    assert area(one) == pytest.approx(area_on_the_ellipsoid(10.0001, 2e-4, 2e-4), rel=1e-6)
    west, east = read(tmp_path, box(179.99995, 10), box(-179.99995 + offset, 10)).footprints
    assert np.linalg.norm(west.polygon[1] - east.polygon[0]) < 0.001


@pytest.mark.parametrize(
    ("ring", "reason"),
    [
        (box(7, 89.5), "too near to a pole"),
        ([[0, 88], [90, 88], [180, 88], [-90, 88], [0, 88]], "around a pole"),
        (box(7, 95), "expected longitude and latitude"),
        (box(400, 50), "expected longitude and latitude"),
    ],
)
def test_poles_and_impossible_places_are_refused_in_words(tmp_path, ring, reason):
    with pytest.raises(AssetError, match=reason):
        read(tmp_path, ring)
    assert [remark.kind for remark in read(tmp_path, ring, box(7, 50)).remarks] == ["outline"]


def test_the_house_of_the_public_report_has_its_geodesic_area(tmp_path):
    ring = [[7.1489466, 50.9653194, 61.5], [7.1489765, 50.9652408, 61.5], [7.1491593, 50.9652698, 61.5]]
    ring += [[7.1491291, 50.9653486, 61.5], ring[0]]
    plan = read(tmp_path, ring)
    assert area(plan.footprints[0]) == pytest.approx(119.173, abs=0.001)
    assert plan.georeference is not None
    assert (plan.georeference.longitude, plan.georeference.latitude) == pytest.approx((7.14905, 50.96529), abs=1e-5)
