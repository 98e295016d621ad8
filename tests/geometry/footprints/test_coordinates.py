"""Coordinates of any reference system as true metres."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyproj import Geod, Transformer

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.coordinates import check_sizes, horizontal, metric_system, parsed, transformed

PLACES = {
    "EPSG:4326": (14.4, 50.1),
    "EPSG:4258": (7.2, 50.1),
    "EPSG:4979": (-70.6, -33.4),
    "EPSG:4807": (2.6, 54.2),  # grads east of Paris
    "EPSG:3857": (1_604_000.0, 6_460_000.0),
    "EPSG:3395": (1_604_000.0, 6_430_000.0),
    "EPSG:2263": (1_000_000.0, 200_000.0),
    "EPSG:2222": (700_000.0, 900_000.0),  # international feet
    "EPSG:2048": (53_000.0, 3_750_000.0),  # to the west and south
    "EPSG:5513": (1_050_000.0, 740_000.0),
    "EPSG:25832": (500_000.0, 5_500_000.0),
    "EPSG:27700": (530_000.0, 180_000.0),
    "EPSG:31467": (3_500_000.0, 5_500_000.0),
    "EPSG:7415": (121_000.0, 487_000.0),
    "EPSG:6933": (1_000_000.0, 5_000_000.0),
}


@pytest.mark.parametrize("crs", PLACES)
def test_a_square_has_its_area_on_the_ground_and_stays_where_it_is(crs):
    centre = np.array([PLACES[crs]])
    system = metric_system(crs, centre)
    to_degrees = Transformer.from_crs(system.target, "OGC:CRS84", always_xy=True)
    corner = system.metres(centre)[0]
    square = corner + 100.0 * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    area, _ = Geod(ellps="WGS84").polygon_area_perimeter(*to_degrees.transform(*square.T))
    # National grids keep areas to a thousandth or so, and their datum has another ellipsoid.
    assert area == pytest.approx(10_000, rel=2.5e-3)
    place = transformed(centre, crs, "OGC:CRS84")[0]
    assert to_degrees.transform(*corner) == pytest.approx(place, abs=1e-7)


@pytest.mark.parametrize(("crs", "factor"), [("EPSG:2263", 1200 / 3937), ("EPSG:2222", 0.3048), ("EPSG:25832", 1.0)])
def test_units_are_scaled_to_the_last_bit(crs, factor):
    system = metric_system(crs, np.array([PLACES[crs]]))
    points = np.asarray(np.array([PLACES[crs]]) + np.arange(12).reshape(6, 2) * 1.7, dtype=np.float64)
    assert system.height_unit == pytest.approx(factor, rel=1e-12)
    assert system.metres(points) == pytest.approx(points * factor, rel=1e-12)


def test_national_systems_in_metres_are_found_for_those_in_feet():
    assert metric_system("EPSG:2263", np.array([PLACES["EPSG:2263"]])).target == "EPSG:32118"
    without = metric_system("EPSG:2249", np.array([[770_000.0, 2_950_000.0]]))  # Massachusetts: another false easting
    assert "in metres" in parsed(without.target).name


@settings(max_examples=20)
@given(st.floats(-179.9, 179.9), st.floats(-79.9, 83.9))
def test_degrees_become_the_zone_of_their_middle(longitude, latitude):
    system = metric_system("EPSG:4326", np.array([[longitude, latitude]]))
    zone = int(system.target[-2:])
    assert abs((longitude - (6 * zone - 183) + 180) % 360 - 180) <= 3.0 + 1e-9
    assert system.target.startswith("EPSG:326" if latitude >= 0 else "EPSG:327")


def test_maps_across_the_date_line_have_one_zone():
    centres = np.array([[179.99, -16.5], [-179.99, -16.5], [179.98, -16.5], [180.02, -16.5]])
    points = metric_system("EPSG:4326", centres).metres(centres)
    assert np.ptp(points[:, 0]) < 5_000


@pytest.mark.parametrize(
    ("crs", "point", "message"),
    [
        ("EPSG:4326", (50.0, 120.0), "swapped"),
        ("EPSG:4258", (50.1, 7.2), "swapped"),
        ("EPSG:25832", (5_500_000.0, 500_000.0), "swapped"),
        ("EPSG:4326", (691_000.0, 5_334_000.0), "counts in degrees"),
        ("EPSG:4978", (1.0, 1.0), "not one of places"),
        ("EPSG:5703", (1.0, 1.0), "not one of places"),  # heights only
        ("IAU_2015:49900", (1.0, 1.0), "cannot be turned into"),  # Mars
        ("nonsense", (1.0, 1.0), "nonsense, is not known"),
        ("", (1.0, 1.0), "is not known"),
        ("x" * 100_000, (1.0, 1.0), "is not known"),
        ("\ud800", (1.0, 1.0), "is not known"),
        ("+init=/etc/passwd:section", (1.0, 1.0), "is not known"),
        ("+proj=utm +zone=32 +nadgrids=/etc/passwd", (1.0, 1.0), "is not known"),
        ("+proj=pipeline +step +proj=utm", (1.0, 1.0), "is not known"),
        ("[" * 15_000, (1.0, 1.0), "is not known"),
        ('{"a":' * 4_000, (1.0, 1.0), "is not known"),
    ],
)
def test_systems_that_cannot_be_right_are_refused(crs, point, message):
    with pytest.raises(AssetError, match=message) as error:
        metric_system(crs, np.array([point]))
    assert len(str(error.value)) < 400


@settings(max_examples=4)  # PROJ takes half a second to look for a name
@given(st.text(max_size=30))
def test_any_name_is_known_or_refused(name):
    try:
        system = metric_system(name, np.array([[7.0, 50.0]]))
    except AssetError:
        return
    assert np.isfinite(system.metres(np.array([[7.0, 50.0]]))).all()


def test_places_outside_the_area_of_a_system_are_said():
    assert "not in the area of EPSG:27700" in metric_system("EPSG:27700", np.array([[480_000.0, 4_765_000.0]])).note
    assert metric_system("EPSG:27700", np.array([PLACES["EPSG:27700"]])).note == ""


def test_medians_tell_wrong_units():
    check_sizes(np.array([1.0, 300.0, 1e9]), "EPSG:25832")
    check_sizes(np.array([4e6]), "EPSG:25832")  # the outline of a city
    for areas in (np.array([0.1, 0.2]), np.array([2e6, 3e6]), np.array([1e11])):
        with pytest.raises(AssetError, match="unit"):
            check_sizes(areas, "EPSG:25832")


def test_heights_have_the_unit_of_their_own_axis():
    feet = metric_system("EPSG:2263+6360", np.array([PLACES["EPSG:2263"]]))  # NAVD88 in US survey feet
    metres = metric_system("EPSG:2263+5703", np.array([PLACES["EPSG:2263"]]))
    assert (feet.height_unit, metres.height_unit) == pytest.approx((1200 / 3937, 1.0))
    assert horizontal("EPSG:2263+5703") == "EPSG:2263"
