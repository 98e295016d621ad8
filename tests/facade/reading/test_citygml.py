"""Walls of CityGML, each in its own plane."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError, UsageError
from grammarlab.facade.reading import citygml
from grammarlab.facade.reading.assembling import assemble
from grammarlab.facade.reading.formats import read_annotation
from grammarlab.facade.reading.markup import parse_xml
from grammarlab.facade.reading.source import Source
from tests.facade.reading.city import ARCH, DOOR, WALL, City, usual


def read_citygml(content, wall=""):
    return citygml.read_citygml(parse_xml(content), Source(Path("city.gml"), wall))


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0, -1.5])
def test_a_wall_is_read_in_its_own_plane_as_seen_from_outside(version, angle):
    found = read_citygml(usual(version, angle=angle).content())
    assert (found.names, found.unit, found.notes) == (("window", "door"), "metres", ())
    boxes = np.hstack([found.low, found.high]) - np.tile(found.frame[0], 2)
    np.testing.assert_allclose(boxes, [[2, 1, 4, 5], [6, 0, 7, 2.5]], atol=1e-6)
    np.testing.assert_allclose(found.frame[1] - found.frame[0], [9, 6], atol=1e-6)
    outline = found.outlines[0] - found.frame[0]
    assert sorted(np.round(outline, 6).tolist()) == sorted(ARCH.tolist())
    assert len(found.outlines[1]) == len(found.wall) == 0
    facade = assemble(found).facade
    names = [facade.name_of(node) for node in facade.leaves]
    assert (names.count("window"), names.count("door"), set(names)) == (1, 1, {"window", "door", "wall"})


def test_a_hole_that_nothing_fills_is_an_opening_and_a_gable_an_outline():
    city = City()
    gable = np.array([[0, 0], [8, 0], [8, 4], [4, 8], [0, 4]], dtype=np.float64)
    city.wall(city.surface(city.polygon(gable, ARCH / 2 + 1, DOOR)), city.hole("Door", DOOR))
    found = read_citygml(city.content())
    assert found.names == ("door", "opening")
    assert len(found.wall) == 5


def test_a_wall_of_several_polygons_is_joined():
    city = City()
    halves = [WALL * [0.5, 1.0], WALL * [0.5, 1.0] + [4.5, 0.0]]
    city.wall(city.surface(*(city.polygon(half) for half in halves)), city.hole("Window", ARCH))
    found = read_citygml(city.content())
    np.testing.assert_allclose(found.frame[1] - found.frame[0], [9, 6], atol=1e-6)
    assert len(found.wall) == 0


def test_polygons_may_stand_elsewhere_in_the_file():
    city = City()
    city.wall('<lod3MultiSurface><g:surfaceMember xlink:href="#p"/></lod3MultiSurface>', city.hole("Window", ARCH))
    city.parts.append(f"<lod3Solid>{city.polygon(WALL, name='p')}</lod3Solid>")
    assert read_citygml(city.content()).names == ("window",)


def test_patches_and_separated_coordinates_are_read_like_polygons():
    text = usual().content().decode()
    patches = text.replace("g:Polygon", "g:PolygonPatch")
    lists = re.findall("<g:posList>(.*?)</g:posList>", text)
    separated = text
    for each in lists:
        points = np.array(each.split()).reshape(-1, 3)
        joined = " ".join(map(",".join, points.tolist()))
        separated = separated.replace(f"<g:posList>{each}</g:posList>", f"<g:coordinates>{joined}</g:coordinates>")
    first = read_citygml(text.encode())
    for other in (patches, separated):
        found = read_citygml(other.encode())
        assert found.names == first.names
        np.testing.assert_array_equal(found.low, first.low)
        np.testing.assert_array_equal(found.high, first.high)


def test_openings_of_walls_without_polygons_go_to_the_wall_that_they_lie_on():
    city = City()
    city.wall(city.surface(city.polygon(WALL, depth=-4.0)), name="behind")
    city.wall(city.surface(city.polygon(WALL)), name="front")
    city.wall(city.hole("Window", ARCH))
    city.wall(city.hole("Window", ARCH + 20.0))
    assert read_citygml(city.content(), "front").names == ("window",)
    assert read_citygml(city.content(), "behind").names == ()


def test_walls_without_a_name_are_called_by_what_they_bound_and_all_are_listed():
    city = usual()
    city.wall(city.surface(city.polygon(WALL[:, ::-1])))
    with pytest.raises(UsageError) as told:
        read_citygml(city.content())
    assert "this file has 2 walls; choose one with `wall=`:" in str(told.value)
    assert "front  (9.0 x 6.0 m, 2 openings)\n  B/2  (6.0 x 9.0 m, 0 openings)" in str(told.value)
    plain_wall = read_citygml(city.content(), "B/2")
    assert plain_wall.names == ()
    assert len(assemble(plain_wall).facade) == 1
    with pytest.raises(UsageError, match="unknown wall 'back'"):
        read_citygml(city.content(), "back")


def test_an_opening_beside_its_wall_is_left_out_and_told():
    city = City()
    city.wall(city.surface(city.polygon(WALL)), city.hole("Window", ARCH), city.hole("Window", ARCH + 50.0))
    found = read_citygml(city.content())
    assert found.names == ("window",)
    assert found.notes == ("1 openings outside the wall are left out",)


def flat() -> bytes:
    points = "0 0 0 1 0 0 1 1 0 0 1 0 0 0 0"
    ring = (
        f"<g:Polygon><g:exterior><g:LinearRing><g:posList>{points}</g:posList></g:LinearRing></g:exterior></g:Polygon>"
    )
    city = City()
    city.wall(city.surface(ring))
    return city.content()


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (City().content(), "no WallSurface"),
        (flat(), "The wall B/1 has no area, or is horizontal"),
        (usual().content().replace(b"<g:posList>", b"<g:posList>1 "), "points of three coordinates"),
        (usual().content().replace(b"<g:posList>", b"<g:posList>1 2 nan "), "finite points"),
        (usual().content().replace(b"<g:posList>", b"<g:posList>1 2 x "), "expected numbers in a ring"),
    ],
)
def test_what_is_no_wall_is_explained(tmp_path, content, says):
    (tmp_path / "a.gml").write_bytes(content)
    with pytest.raises(FacadeError, match=says):
        read_annotation(tmp_path / "a.gml")


def test_a_polygon_that_is_referred_to_without_end_is_refused(monkeypatch):
    monkeypatch.setattr(citygml, "MOST_POINTS", 1_000)
    city = City()
    city.wall("<lod3MultiSurface>" + '<m xlink:href="#p"/>' * 1_000 + "</lod3MultiSurface>")
    city.parts.append(f"<lod3Solid>{city.polygon(WALL, name='p')}</lod3Solid>")
    with pytest.raises(FacadeError, match="more than 1,000 corners"):
        read_citygml(city.content())


VALID = usual().content()


@given(st.data())
def test_damaged_models_are_read_or_refused_in_words(data):
    content = VALID
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(200, len(content)))
        other = data.draw(
            st.binary(max_size=6) | st.sampled_from([b"0 ", b"1e999 ", b"1e8", b"-", b"<x>", b"</g:posList>"])
        )
        content = content[:start] + other + content[start + data.draw(st.integers(0, 30)) :]
    try:
        assemble(read_citygml(content), split=True)
    except (FacadeError, UsageError):
        return
