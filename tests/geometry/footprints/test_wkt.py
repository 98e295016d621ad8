"""Well-known text: kinds, dimensions, SRIDs, and what has no straight edges."""

import pytest

from grammarlab.errors import AssetError, UsageError
from grammarlab.geometry.footprints.footprint import Georeference
from grammarlab.geometry.footprints.footprint_text import read_footprint_map
from tests.geometry.footprints.maps import area

RING = "(0 0, 10 0, 10 8, 0 8, 0 0)"


@pytest.mark.parametrize(
    "text",
    [
        f"POLYGON ({RING})",
        f"  polygon({RING})",
        "POLYGON Z ((0 0 5, 10 0 5, 10 8 6, 0 8 5, 0 0 5))",
        "POLYGONZ((0 0 5, 10 0 5, 10 8 6, 0 8 5, 0 0 5))",
        "POLYGON M ((0 0 5, 10 0 5, 10 8 6, 0 8 5, 0 0 5))",
        "POLYGON ZM ((0 0 5 1, 10 0 5 1, 10 8 6 1, 0 8 5 1, 0 0 5 1))",
        f"CURVEPOLYGON ({RING})",
        f"MULTISURFACE (({RING}))",
        f"MULTISURFACE (POLYGON ({RING}))",
        f"MULTISURFACE (CURVEPOLYGON ({RING}))",
        "MULTISURFACE Z (((0 0 5, 10 0 5, 10 8 6, 0 8 5, 0 0 5)))",
        f"GEOMETRYCOLLECTION (GEOMETRYCOLLECTION (POLYGON ({RING})))",
        f"GEOMETRYCOLLECTION (MULTISURFACE (CURVEPOLYGON ({RING})))",
        f"SRID=0;POLYGON ({RING})",
        f"srid = 25832 ; MULTIPOLYGON (({RING}))",
    ],
)
def test_polygons_in_all_their_forms_are_read(text):
    plan = read_footprint_map(text)
    assert [area(footprint) for footprint in plan.footprints] == [80]
    assert plan.georeference == (Georeference("EPSG:25832") if "25832" in text else None)
    assert plan.remarks == ()


def test_an_srid_in_degrees_is_converted():
    plan = read_footprint_map("SRID=4326;POLYGON ((7 50, 7.0001 50, 7.0001 50.0001, 7 50.0001, 7 50))")
    assert area(plan.footprints[0]) == pytest.approx(79.75, rel=1e-3)
    assert plan.georeference is not None
    assert plan.georeference.latitude == pytest.approx(50.00005)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("CURVEPOLYGON (CIRCULARSTRING (0 0, 4 0, 4 4, 0 4, 0 0))", "CIRCULARSTRING has arcs.*ST_CurveToLine.*ogr2ogr"),
        ("CURVEPOLYGON (COMPOUNDCURVE ((0 0, 1 1), CIRCULARSTRING (1 1, 2 2, 0 0)))", "COMPOUNDCURVE has arcs"),
        (f"MULTISURFACE (({RING}), CURVEPOLYGON (CIRCULARSTRING (0 0, 4 0, 0 0)))", "has arcs"),
        ("CIRCULARSTRING (0 0, 1 1, 2 0)", "has arcs"),
        ("MULTICURVE ((0 0, 5 5))", "has arcs"),
        ("TIN (((0 0 0, 1 0 0, 1 1 0, 0 0 0)))", "faces in space"),
        ("POLYHEDRALSURFACE Z (((0 0 0, 1 0 0, 1 1 0, 0 0 0)))", "faces in space"),
        ("TRIANGLE ((0 0, 1 0, 1 1, 0 0))", "faces in space"),
        (f"SRID=54004;POLYGON ({RING})", "EPSG:54004.*ST_Transform"),
        (f"SRID=4326;POLYGON ({RING})", "20000 at most"),
        (
            "SRID=4326;POLYGON ((691000 5334000, 691010 5334000, 691010 5334010, 691000 5334000))",
            "longitude and latitude",
        ),
        ("POLYGON ((7.1 50.9, 7.1001 50.9, 7.1001 50.9001, 7.1 50.9))", "write SRID=4326;"),
        ("SRID=25832", "not well-formed"),
        ("MULTIPOLYGON EMPTY", "empty"),
        ("POINT (1 2)", "found a Point"),
        ("GEOMETRYCOLLECTION (" * 5000 + "POINT (0 0)" + ")" * 5000, "at most 64 parentheses"),
        ("POLYGON ((" + "9" * 5000 + " 0, 1 0, 1 1, " + "9" * 5000 + " 0))", "finite"),
        (f"MULTIPOLYGON (({RING}), ((0 0, 9 9, 9 0, 0 9, 0 0)))", "self-intersection"),
    ],
)
def test_all_else_is_refused_in_words(text, message):
    with pytest.raises(AssetError, match=message):
        read_footprint_map(text)


def test_lines_in_a_collection_are_listed():
    plan = read_footprint_map(f"GEOMETRYCOLLECTION (POLYGON ({RING}), LINESTRING (0 0, 1 1), POINT EMPTY)")
    assert len(plan.footprints) == 1
    assert [remark.reason for remark in plan.remarks] == [
        "expected a polygon, found a LineString",
        "expected a polygon, found an empty Point",
    ]


@pytest.mark.parametrize(
    "text",
    [
        f"POLYGON ({RING})",
        f"\ufeffSRID=25832;POLYGON\n({RING})\n",
        f"GEOMETRYCOLLECTION (\nPOLYGON ({RING}),\nPOLYGON ({RING}))",
        "POINT (1 2)",
        "POLYGON ((0 0, 10 0",
    ],
)
def test_a_file_of_wkt_is_read_as_the_text_in_it(tmp_path, text):
    def outcome(source):
        try:
            plan = read_footprint_map(source)
        except AssetError as error:
            return str(error).replace(source, "footprint")
        return [footprint.polygon.tolist() for footprint in plan.footprints], plan.georeference, plan.remarks

    (tmp_path / "lot.wkt").write_text(text)
    assert outcome(str(tmp_path / "lot.wkt")) == outcome(text.removeprefix("\ufeff"))


def test_a_file_of_wkt_has_no_layers(tmp_path):
    (tmp_path / "lot.txt").write_text(f"POLYGON ({RING})")
    with pytest.raises(UsageError, match="WKT has no layers; leave out ':parcels'"):
        read_footprint_map(f"{tmp_path / 'lot.txt'}:parcels")


def test_a_file_may_have_a_text_in_each_line(tmp_path):
    texts = [
        f"POLYGON ({RING})",
        "MULTIPOLYGON (((20 0, 30 0, 30 4, 20 0)),\n((40 0, 50 0, 50 4, 40 0)))",
        "POINT (1 2)",
    ]
    (tmp_path / "lots.wkt").write_text("\n" + "\n".join(texts) + "\n")
    plan = read_footprint_map(str(tmp_path / "lots.wkt"))
    whole = read_footprint_map(f"GEOMETRYCOLLECTION ({', '.join(texts)})")
    assert [one.polygon.tolist() for one in plan.footprints] == [one.polygon.tolist() for one in whole.footprints]
    assert [str(remark) for remark in plan.remarks] == [str(remark) for remark in whole.remarks]


def test_the_texts_of_a_file_have_one_coordinate_system(tmp_path):
    (tmp_path / "lots.wkt").write_text(f"SRID=25832;POLYGON ({RING})\nSRID=25833;POLYGON ({RING})")
    with pytest.raises(AssetError, match="one coordinate system for all texts, found EPSG:25832, EPSG:25833"):
        read_footprint_map(str(tmp_path / "lots.wkt"))
