"""Coordinate reference systems by their many names."""

import sys

import pytest

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.crs import crs_of_member, crs_of_name, degree_codes, metre_codes
from grammarlab.geometry.footprints.footprint import Georeference
from grammarlab.geometry.footprints.footprint_text import read_footprint_map
from tests.geometry.footprints.maps import SQUARE, area, collection, feature, moved, named, polygon, written

IN_METRES = moved(SQUARE, 691000, 5334000)
IN_DEGREES = moved(SQUARE, 7, 50, 1e-5)


@pytest.mark.parametrize(
    "name",
    [
        "urn:ogc:def:crs:EPSG::25832",
        "urn:ogc:def:crs:EPSG:6.9:25832",
        "urn:x-ogc:def:crs:EPSG:25832",
        "urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::7837",
        "EPSG:25832",
        "epsg:25832",
        "EPSG:25832+7837",
        "http://www.opengis.net/def/crs/EPSG/0/25832",
        "https://www.opengis.net/def/crs/EPSG/0/25832",
        "http://www.opengis.net/gml/srs/epsg.xml#25832",
        "http://spatialreference.org/ref/epsg/25832/",
        "https://epsg.io/25832",
        'PROJCS["ETRS89 / UTM zone 32N",GEOGCS["ETRS89",AUTHORITY["EPSG","4258"]],AUTHORITY["EPSG","25832"]]',
        "25832",
        25832,
    ],
)
def test_all_spellings_of_a_code_are_the_same_crs(name):
    crs = crs_of_member(named(name))
    assert (crs.name, crs.unit) == ("EPSG:25832", "metres")
    assert crs_of_member({"type": "EPSG", "properties": {"code": 25832}}) == crs_of_member("EPSG:25832") == crs


@pytest.mark.parametrize(
    "name",
    [
        "urn:ogc:def:crs:OGC:1.3:CRS84",
        "OGC:CRS84",
        "CRS84",
        "urn:ogc:def:crs:OGC::CRS84h",
        "EPSG:4326",
        "EPSG:4258",
        "EPSG:4269",
        "EPSG:4979",
        "urn:ogc:def:crs:EPSG::4326",
        "WGS 84",
        "GCS_WGS_1984",
        "ETRS89",
        "EPSG:4937",
    ],
)
def test_geographic_systems_count_in_degrees(name):
    assert crs_of_name(name).unit == "degrees"


@pytest.mark.parametrize(
    "name",
    # Germany, France, Netherlands, Switzerland, Great Britain, Austria, Belgium, Poland, Sweden, Finland, Czechia,
    # Spain, Portugal, New Zealand, Australia, Japan, British Columbia, New York in metres, Europe
    [
        "EPSG:25832",
        "EPSG:31467",
        "EPSG:2154",
        "EPSG:28992",
        "EPSG:2056",
        "EPSG:21781",
        "EPSG:27700",
        "EPSG:31256",
        "EPSG:31370",
        "EPSG:2180",
        "EPSG:3006",
        "EPSG:3067",
        "EPSG:5514",
        "EPSG:25830",
        "EPSG:3763",
        "EPSG:2193",
        "EPSG:7855",
        "EPSG:6677",
        "EPSG:3005",
        "EPSG:32118",
        "EPSG:3035",
        "EPSG:7415",
        "WGS 84 / UTM zone 33S",
        "WGS_1984_UTM_Zone_32N",
    ],
)
def test_national_grids_count_in_metres(name):
    assert crs_of_name(name).unit == "metres"


@pytest.mark.parametrize(
    "name",
    [
        "EPSG:3857",
        "urn:ogc:def:crs:EPSG::3857",
        "EPSG:900913",
        "EPSG:3785",
        "ESRI:102100",
        "102113",
        "3857",
        "WGS 84 / Pseudo-Mercator",
        "WGS_1984_Web_Mercator_Auxiliary_Sphere",
    ],
)
def test_web_mercator_is_refused_by_its_name_and_with_a_command(tmp_path, monkeypatch, name):
    monkeypatch.setitem(sys.modules, "pyproj", None)
    path = written(tmp_path, collection(feature(polygon(IN_METRES)), crs=named(name)))
    digits = "".join(c for c in name if c.isdigit())[-6:]
    message = rf"{digits}.*Web Mercator.*ogr2ogr -t_srs EPSG:4326 lots-degrees\.geojson.*grammarlab\[city\]"
    with pytest.raises(AssetError, match=message):
        read_footprint_map(path)


@pytest.mark.parametrize(
    "crs",
    # feet, grads, geocentric, axes to the west and south, world maps, and names that say nothing
    [
        *(named(f"EPSG:{code}") for code in (2263, 2225, 4807, 4978, 5513, 2048, 3395, 6933, 54004, 999999)),
        named("nonsense"),
        named("NAD83 / New York Long Island (ftUS)"),
        named("+proj=utm +zone=32"),
        named(None),
        named("\x1b[31mEPSG"),
        named(""),
        {"type": "link", "properties": {"href": "http://a/b"}},
        {},
        [],
        True,
        "x" * 10**6,
    ],
)
def test_all_other_systems_are_refused_with_a_command(tmp_path, monkeypatch, crs):
    monkeypatch.setitem(sys.modules, "pyproj", None)
    path = written(tmp_path, collection(feature(polygon(IN_METRES)), crs=crs))
    with pytest.raises(AssetError, match=r"lots\.geojson: .*CRS.*ogr2ogr") as error:
        read_footprint_map(path)
    assert str(error.value).isprintable()
    assert len(str(error.value)) < 500


def test_a_crs_belongs_to_the_geometry_or_feature_that_has_it(tmp_path):
    """PostGIS writes it into each geometry."""
    inner = {**polygon(IN_METRES), "crs": named("EPSG:25832")}
    for document in (inner, feature(inner), collection(feature(inner), crs=named("EPSG:3857"))):
        assert read_footprint_map(written(tmp_path, document)).georeference == Georeference("EPSG:25832")
    two = collection(feature(inner), feature(polygon(IN_DEGREES)))
    with pytest.raises(AssetError, match=r"expected one CRS, found EPSG:25832 and OGC:CRS84 .*feature 1"):
        read_footprint_map(written(tmp_path, two))


def test_coordinates_that_contradict_their_crs_are_said(tmp_path):
    cases = [
        (
            collection(feature(polygon(IN_METRES))),
            "longitude and latitude in degrees, found x from 691000.*name its CRS",
        ),
        (collection(feature(polygon(IN_DEGREES)), crs=named("EPSG:25832")), "EPSG:25832 counts in metres.*degrees"),
        (collection(feature(polygon(IN_DEGREES)), crs=None), "counts in metres.*degrees"),
    ]
    for document, message in cases:
        with pytest.raises(AssetError, match=f"(?s){message}"):
            read_footprint_map(written(tmp_path, document))


def test_a_metre_is_a_metre_in_every_accepted_grid(tmp_path):
    for crs in (None, named("EPSG:2056"), named("EPSG:27700")):
        plan = read_footprint_map(written(tmp_path, collection(feature(polygon(IN_METRES)), crs=crs)))
        assert area(plan.footprints[0]) == pytest.approx(80, rel=1e-9)
        assert plan.footprints[0].polygon[0].tolist() == [691000, 0, -5334000]


def test_no_code_is_both():
    assert not metre_codes() & degree_codes()
    assert min(metre_codes() | degree_codes()) >= 2000
