"""Files of CityJSON have closed solids in place, at every level, whatever the order of buildings."""

from __future__ import annotations

import gc
import json
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import shapely
import shapely.affinity
from shapely.geometry.polygon import orient

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import derive
from grammarlab.errors import UsageError
from grammarlab.export.cityjson import CityBuilding, CityJsonWriter, Level, building_line, head_line
from grammarlab.export.surface_labels import SurfaceLabels
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.triangulate import keyhole
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.scene import realize
from grammarlab.scene.instances import scene_of_model
from tests.export.cityjson_checks import (
    assert_closed_manifold,
    assert_well_formed,
    features_of,
    geometry_of,
    surfaces_of,
    types_of,
    volume,
)

GRAMMARS = Path(__file__).parents[2] / "grammars"
FRAME = Frame("EPSG:32631", (448000.0, 5412000.0))
TOWER = "Lot --> extrude(6) comp(f) { bottom : Floor | top : Top | side : Side }"
SQUARE = shapely.box(0, -20, 20, 0)
COURT = shapely.Polygon(SQUARE.exterior, [shapely.box(5, -15, 15, -5).exterior])
ELL = shapely.Polygon([(0, -20), (20, -20), (20, -12), (9, -12), (9, 0), (0, 0)])


def corners_of(polygon: shapely.Polygon, east: float) -> np.ndarray:
    """[n, 3] corners of a footprint counted from its corner, holes joined by doubled edges."""
    plan = orient(shapely.transform(polygon, lambda points: points - np.array([east, 0])))
    rings = [shapely.get_coordinates(ring)[:-1] for ring in (plan.exterior, *plan.interiors)]
    east_north = np.concatenate(rings)[keyhole(rings)]
    return np.column_stack([east_north[:, 0], np.zeros(len(east_north)), -east_north[:, 1]])


@cache
def building(text: str = TOWER, name: str = "a", east: float = 0.0, footprint: shapely.Polygon = SQUARE):
    """A building of a shipped grammar or of a text."""
    grammar = load(GRAMMARS / f"{text}.cga") if text.isidentifier() else Grammar.parse(text)
    lot = shapely.transform(footprint, lambda points: points + np.array([east, 0]))
    forest = derive(grammar, 1, 5, assets=AssetFolder(GRAMMARS / "assets"), footprint=corners_of(lot, east))
    scene = realize(forest)
    return CityBuilding(
        id=name,
        footprint=lot,
        ground=2.0,
        scene=scene,
        corner=np.array([east, 2.0, 0.0]),
        labels=SurfaceLabels.none(len(scene)),
        attributes={"seed": 2**63, "zone": "centre", "height": 6.0, "reason": None},
    )


def level_of(building: CityBuilding, level: Level):
    feature = json.loads(building_line(building, [level]))
    return feature, geometry_of(feature, level)


@pytest.mark.parametrize("level", ["1", "2"])
@pytest.mark.parametrize("footprint", [SQUARE, COURT, ELL], ids=["square", "courtyard", "ell"])
def test_a_prism_is_a_closed_solid_with_its_courtyard(footprint, level):
    feature, geometry = level_of(building(footprint=footprint), level)
    assert_closed_manifold(geometry)
    assert volume(geometry, feature) == pytest.approx(footprint.area * 6)
    num_edges = len(shapely.get_coordinates(footprint)) - len(footprint.interiors) - 1
    assert types_of(geometry) == ["GroundSurface", *["WallSurface"] * num_edges, "RoofSurface"]


ROOFS = {
    "gable": ("extrude(6) comp(f) { side : W. | top : roofGable(45) comp(f) { side : W. | top : R. } }", 10 * 200),
    "hip": ("extrude(6) comp(f) { side : W. | top : roofHip(45) R. }", 10 * 400 / 3),
    "shed": ("extrude(6) comp(f) { side : W. | top : roofShed(45) R. }", 10 * 400),
    "terrace": ("split(x) { 5 : extrude(9) W. | ~1 : extrude(6) W. }", 3 * 100),
    "plant room": ("extrude(6) comp(f) { side : W. | top : [ R. ] offset(-5, inside) extrude(3) W. }", 3 * 100),
    "parapet": (
        "extrude(6) comp(f) { side : [ W. ] s('1, '1 + 1, 0.3) t(0, 0, -0.3) primitiveCube() W. | top : R. }",
        0,
    ),
    "eaves": ("extrude(6) comp(f) { side : W. | top : roofHip(45, 0.8) R. }", 10 * 400 / 3),
    "crossing sheds": ("[ s('1, '1, '1) extrude(1) roofShed(45) W. ] extrude(6) comp(f) { all : W. }", None),
}


@pytest.mark.parametrize("name", ROOFS)
def test_walls_and_roofs_enclose_the_volume_of_the_model(name):
    rules, above = ROOFS[name]
    feature, geometry = level_of(building(f"Lot --> {rules}"), "2")
    assert_closed_manifold(geometry)
    assert_well_formed(feature)
    if above is not None:
        assert volume(geometry, feature) == pytest.approx(400 * 6 + above, rel=1e-3)


@pytest.mark.parametrize("name", ["building", "skyscraper"])
def test_solids_of_shipped_grammars_are_closed(name):
    block, walls_and_roof = (level_of(building(name), level) for level in ("1", "2"))
    assert_closed_manifold(block[1])
    assert_closed_manifold(walls_and_roof[1])
    assert volume(*block[::-1]) >= volume(*walls_and_roof[::-1]) > 0
    assert len(walls_and_roof[1]["boundaries"][0]) > len(block[1]["boundaries"][0])


@pytest.mark.parametrize("name", ["building", "skyscraper"])
def test_features_of_shipped_grammars_are_well_formed(name):
    assert_well_formed(json.loads(building_line(building(name))))


@pytest.mark.parametrize(
    ("rules", "levels"), [("NIL", []), ("W.", ["3"]), ("extrude(6) comp(f) { side : W. }", ["1", "2", "3"])]
)
def test_models_without_walls_or_roofs_have_the_levels_that_they_can_have(rules, levels):
    feature = json.loads(building_line(building(f"Lot --> {rules}")))
    assert [part["lod"] for part in feature["CityObjects"]["a"]["geometry"]] == levels


def test_the_surfaces_of_a_model_are_those_of_the_scene_in_place():
    feature = json.loads(building_line(building(east=40.0), ["3"]))
    geometry = geometry_of(feature, "3")
    assert sorted(types_of(geometry)) == ["GroundSurface", "RoofSurface", *["WallSurface"] * 4]
    assert np.min(feature["vertices"], axis=0).tolist() == [40000, -20000, 2000]
    assert np.max(feature["vertices"], axis=0).tolist() == [60000, 0, 8000]
    assert_closed_manifold(geometry)


@pytest.mark.parametrize("degrees", [0, 3, 17, 45])
def test_walls_of_boxes_and_windows_enclose_the_building_in_any_direction(degrees):
    rules = """
        Lot --> extrude(6) comp(f) { side : Storeys | top : Roof. }
        Storeys --> split(y) { { 3 : split(x) { { 1.5 : Box | 1.1 : Window }* | ~1 : Box } }* }
        Box --> t(0, 0, -0.35) s('1, '1, 0.35) primitiveCube() Box.
        Window --> t(0, 0, -0.2) s('1, '1, 0.06) primitiveCube() Glass.
    """
    lot = shapely.affinity.rotate(ELL, degrees, origin=(7.3, 3.1))
    whole = building(rules, footprint=lot)
    far = CityBuilding(**{**vars(whole), "footprint": shapely.box(-90, -90, 90, 90)})
    feature, geometry = level_of(far, "1")
    rings = np.array(feature["vertices"])[surfaces_of(geometry)[0][0]][:, :2] / 1000
    outline = shapely.Polygon(rings)
    assert shapely.symmetric_difference(outline, lot).area <= 0.03 * lot.area
    assert shapely.hausdorff_distance(outline, lot) <= 0.5


def test_open_walls_have_the_footprint_as_their_outline():
    _, geometry = level_of(building("Lot --> extrude(6) comp(f) { front : W. | back : W. | top : R. }"), "1")
    assert types_of(geometry) == ["GroundSurface", *["WallSurface"] * 4, "RoofSurface"]


def test_a_model_without_a_floor_stands_on_its_outline():
    rules = "Lot --> extrude(6) comp(f) { side : t(0, 0, -0.3) s('1, '1, 0.3) primitiveCube() Wall. | top : Roof. }"
    feature, geometry = level_of(building(rules, footprint=COURT), "3")
    assert_well_formed(feature)
    # The outer walls are trimmed where two of them meet, so that they have no ends.
    assert Counter(types_of(geometry)) == {"GroundSurface": 1, "WallSurface": 32, "RoofSurface": 16}
    (ground,) = (part for part, kind in zip(surfaces_of(geometry), types_of(geometry), strict=True) if "Ground" in kind)
    vertices = np.array(feature["vertices"])
    outer, court = (vertices[ring][:, :2] for ring in ground)
    assert shapely.Polygon(outer, [court]).area == 300e6
    assert set(vertices[ground[0]][:, 2]) == {2000}


def test_faces_that_cross_themselves_are_triangles():
    pentagram = [[np.sin(k * 0.8 * np.pi), 0.0, np.cos(k * 0.8 * np.pi)] for k in range(5)]
    scene = realize(derive(Grammar.parse("Lot --> W."), 1, 5))
    scene = replace(scene, meshes=Meshes.single(np.array(pentagram), [range(5)]), mesh=np.zeros(1, np.int32))
    feature = json.loads(building_line(replace(building("Lot --> W."), scene=scene), ["3"]))
    surfaces = surfaces_of(geometry_of(feature, "3"))
    assert all(len(outer) == 3 for outer, *_ in surfaces[:-1])


def test_a_file_is_its_lines_whoever_made_them(tmp_path):
    path = tmp_path / "city.city.jsonl"
    with CityJsonWriter(path, FRAME) as writer:
        writer.add(building()).add_lines(building_line(building(name="b", east=40.0)))
    parts = [head_line(FRAME), building_line(building()), building_line(building(name="b", east=40.0))]
    assert path.read_bytes() == b"".join(parts)
    assert [feature["id"] for feature in features_of(path)] == ["a", "b"]


def test_a_line_is_the_same_alone_and_in_a_batch():
    grammar = load(GRAMMARS / "toy.cga")
    batch = realize(derive(grammar, 3, 5))
    for model in range(3):
        alone = realize(derive(grammar, 1, 5, first_model=model))
        lines = [
            building_line(replace(building(), scene=scene, labels=SurfaceLabels.none(len(scene))))
            for scene in (alone, scene_of_model(batch, model))
        ]
        assert lines[0] == lines[1]


def test_a_file_that_fails_is_not_there(tmp_path):
    path = tmp_path / "city.city.jsonl"
    with pytest.raises(ZeroDivisionError), CityJsonWriter(path, FRAME) as writer:
        writer.add(building()).add_lines(b" " * (1 // 0))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("is_enabled", [True, False])
def test_lines_leave_the_collection_of_garbage_as_it_was(is_enabled):
    whole = building()
    wrong = replace(whole, labels=whole.labels.take(slice(0, 0)))
    (gc.enable if is_enabled else gc.disable)()
    try:
        building_line(whole)
        with pytest.raises(UsageError):
            building_line(wrong)
        assert gc.isenabled() == is_enabled
    finally:
        gc.enable()


def test_large_integers_are_texts_and_the_others_numbers():
    feature = json.loads(building_line(building(), ["1"]))
    expected = {"seed": str(2**63), "zone": "centre", "height": 6.0, "reason": None}
    assert feature["CityObjects"]["a"]["attributes"] == expected


def test_labels_belong_to_instances():
    whole = building()
    fewer = replace(whole, labels=SurfaceLabels.none(1))
    with pytest.raises(UsageError, match="label for each of its 6"):
        building_line(fewer)


@pytest.mark.parametrize(
    ("crs", "code"),
    [("EPSG:28992", "7415"), ("EPSG:2154", "5698"), ("EPSG:32631", "32631"), ("", None)],
    ids=["only system with heights", "the one in use there", "no system with heights", "no place"],
)
def test_the_reference_system_has_heights_where_epsg_has_one(crs, code):
    origin = {"EPSG:28992": (85000.0, 447000.0), "EPSG:2154": (652000.0, 6862000.0)}.get(crs, FRAME.origin)
    head = json.loads(head_line(Frame(crs, origin)))
    assert head["transform"]["translate"] == [*origin, 0.0]
    url = None if code is None else f"https://www.opengis.net/def/crs/EPSG/0/{code}"
    assert head.get("metadata", {}).get("referenceSystem") == url
