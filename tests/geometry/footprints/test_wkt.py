"""Well-known text: kinds, dimensions, SRIDs, and what has no straight edges."""

import re
import time

import pytest

from grammarlab.errors import AssetError, UsageError
from grammarlab.geometry.footprints import footprint_text
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
            return type(error)
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
    assert [remark.reason for remark in plan.remarks] == [remark.reason for remark in whole.remarks]
    assert [footprint.name for footprint in plan.footprints] == [f"lots.wkt, line {line}" for line in (2, 3, 3)]
    assert [remark.source for remark in plan.remarks] == ["lots.wkt, line 5"]


def test_the_texts_of_a_file_have_one_coordinate_system(tmp_path):
    (tmp_path / "lots.wkt").write_text(f"SRID=25832;POLYGON ({RING})\nSRID=25833;POLYGON ({RING})")
    with pytest.raises(AssetError, match="all texts, found EPSG:25832 in line 1, EPSG:25833 in line 2"):
        read_footprint_map(str(tmp_path / "lots.wkt"))
    (tmp_path / "lots.wkt").write_text(f"hello\nPOLYGON ({RING})\nSRID=25832;POLYGON ({RING})")
    with pytest.raises(AssetError, match=r"found none \(metres\) in line 2, EPSG:25832 in line 3"):
        read_footprint_map(str(tmp_path / "lots.wkt"))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("hello", "not well-formed WKT.*without columns, quotes or ';'"),
        ("# lots (2026,", "not well-formed"),
        ("1;POLYGON ((0 0, 9 0, 9 9, 0 0))", "not well-formed"),
        ('"POLYGON ((0 0, 9 0, 9 9, 0 0))"', "not well-formed"),
        ("POLYGON ((0 0, 9 0", "not well-formed"),
        ("POLYGON ((0 0,", "not well-formed"),
        ("POLYGON (0 0, 9 0, 9 9, 0 0)))", "not well-formed"),
        ("CIRCULARSTRING (0 0, 1 1, 2 0)", "has arcs"),
        ("SRID=25832;POLYGON EMPTY", "empty"),
        ("SRID=25832;POLYGON ((0 0, 9 9, 9 0, 0 9, 0 0))", "self-intersection"),
        ("GEOMETRYCOLLECTION (" * 70 + "POINT (0 0)" + ")" * 70, "at most 64 parentheses"),
    ],
)
def test_a_bad_text_of_a_file_is_a_remark_about_its_line(tmp_path, text, reason):
    whole = f"SRID=25832;POLYGON ({RING})"
    (tmp_path / "lots.wkt").write_text(f"{text}\n{whole}\n{text}\n\n{whole}\n{text}")
    plan = read_footprint_map(str(tmp_path / "lots.wkt"))
    assert [footprint.name for footprint in plan.footprints] == ["lots.wkt, line 2", "lots.wkt, line 5"]
    assert [remark.source for remark in plan.remarks] == [f"lots.wkt, line {line}" for line in (1, 3, 6)]
    assert all(re.search(reason, remark.reason) for remark in plan.remarks)


@pytest.mark.parametrize(
    ("name", "text", "encoding"),
    [
        ("lots.wkt", "-- lots of 2026\n", "utf-8"),
        ("lots.wkt", "id;geom\n", "utf-16"),
        ("lots.wkt", "\n" * 5000, "utf-8"),
        ("lots.txt", "\n" * 300, "utf-8"),
        ("lots.txt", "", "utf-16"),
    ],
)
def test_a_file_is_wkt_by_its_name_or_its_first_words(tmp_path, name, text, encoding):
    (tmp_path / name).write_text(f"{text}POLYGON ({RING})\n", encoding=encoding)
    plan = read_footprint_map(str(tmp_path / name))
    assert [area(footprint) for footprint in plan.footprints] == [80]
    assert len(plan.remarks) == bool(text.strip())


def test_a_file_without_a_good_text_says_why(tmp_path):
    path = tmp_path / "lots.wkt"
    for text, message in [("\n \n", "found an empty file"), ("a;b\n1;2", r"no .*Polygon[^?]*line 2: this is not well")]:
        path.write_text(text)
        with pytest.raises(AssetError, match=message):
            read_footprint_map(str(path))


def test_texts_and_polygons_of_a_file_are_counted(tmp_path, monkeypatch):
    (tmp_path / "lots.wkt").write_text(f"POLYGON ({RING})\n" * 4)
    monkeypatch.setattr(footprint_text, "MAX_FOOTPRINTS", 3)
    with pytest.raises(AssetError, match="at most 3 polygons"):
        read_footprint_map(str(tmp_path / "lots.wkt"))
    monkeypatch.setattr(footprint_text, "MAX_FEATURES", 2)
    with pytest.raises(AssetError, match="at most 2 texts"):
        read_footprint_map(str(tmp_path / "lots.wkt"))


def test_many_texts_take_little_time(tmp_path):
    (tmp_path / "points.wkt").write_text("POINT (1 2)\n" * 10_000 + f"POLYGON ({RING})")
    begin = time.process_time()
    assert len(read_footprint_map(str(tmp_path / "points.wkt")).remarks) == 10_000
    assert time.process_time() - begin < 0.5
