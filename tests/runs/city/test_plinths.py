"""Plinths: closed prisms from the ground up to the buildings, in tiles of all levels and in CityJSON."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from grammarlab.city.plan import read_plan
from grammarlab.city.sites import Sites
from grammarlab.export.cityjson import LEVELS
from grammarlab.export.tiles.simplified_models import simplified
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.runs.city.build import build_city
from grammarlab.runs.city.survey import Survey, lot_outlines, surveyed
from grammarlab.runs.city.zone_rules import MadeBuildings, ZoneRules, make_buildings
from grammarlab.scene import Scene, triangles
from grammarlab.scene.instance_bounds import scene_bounds
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
from tests.runs.city.hills import GARDEN_RULES, slope, write_hill_plan
from tests.runs.city.plans import boxes, files_of, write_plan

RING_RULES = "@StartRule\nLot --> extrude(8) House."


def survey_of(plan: Path) -> tuple[Survey, tuple[ZoneRules, ...]]:
    read = read_plan(plan)
    zones = tuple(ZoneRules.of(zone) for zone in read.zones)
    return surveyed(read, zones), zones


def made(plan: Path, zone: int = 1) -> tuple[Sites, MadeBuildings, MadeBuildings]:
    """Sites of a zone, their buildings with their plinths, and without."""
    survey, zones = survey_of(plan)
    sites = survey.sites.take(np.flatnonzero(survey.sites.zone == zone))
    level = replace(sites, plinth=np.zeros(len(sites)))
    return sites, make_buildings(zones[zone], sites), make_buildings(zones[zone], level)


def scene_of(buildings: MadeBuildings) -> Scene:
    assert buildings.scene is not None
    return buildings.scene


def lowest_ground(sites: Sites) -> np.ndarray:
    """[S] lowest terrain along the outlines of footprints: on a plane, at one of their corners."""
    corners = [shapely.get_coordinates(lot) for lot in lot_outlines(sites)]
    return np.array([slope(*points.T).min() for points in corners])


def placed(meshes: Meshes) -> list[list[tuple[float, ...]]]:
    """Faces as lists of points, rounded."""
    rows = meshes.points[meshes.corner_points()].round(6) + 0.0
    return [[tuple(point) for point in rows[start:end].tolist()] for start, end in pairwise(meshes.face_offsets)]


def prism_of(whole: Scene, level: Scene, model: int) -> Meshes:
    """The meshes that a model has because of its plinth."""
    scene, other = scene_of_model(whole, model), scene_of_model(level, model)
    assert len(scene) > len(other)
    return scene.meshes.take(scene.mesh[len(other) :])


def test_a_plinth_is_a_closed_prism_down_to_the_lowest_ground(tmp_path: Path):
    sites, buildings, level = made(write_hill_plan(tmp_path / "plan"))
    assert (sites.plinth > 0.5).all()
    assert sites.corner[:, 1] - sites.plinth == pytest.approx(lowest_ground(sites), abs=2e-3)
    area = shapely.area(lot_outlines(sites))
    for model in range(len(sites)):
        prism = prism_of(scene_of(buildings), scene_of(level), model)
        faces = placed(prism)
        edges = Counter(edge for face in faces for edge in pairwise([*face, face[0]]))
        assert set(edges.values()) == {1}
        assert all((end, start) in edges for start, end in edges)
        size = sum(
            np.dot(a, np.cross(b, c)) / 6
            for face in faces
            for a, b, c in ((face[0], face[index], face[index + 1]) for index in range(1, len(face) - 1))
        )
        assert size == pytest.approx(area[model] * sites.plinth[model], rel=1e-6)


def test_all_levels_of_detail_reach_the_ground(tmp_path: Path):
    for zone in (0, 1):
        sites, buildings, level = made(write_hill_plan(tmp_path / "plan"), zone)
        scene = scene_of(buildings)
        assert scene_bounds(scene)[0][:, 1] == pytest.approx(-sites.plinth)
        assert scene_bounds(scene)[1] == pytest.approx(scene_bounds(scene_of(level))[1])
        for coarse in simplified(scene):
            assert scene_bounds(coarse)[0][:, 1] == pytest.approx(-sites.plinth, abs=0.1)


def test_gardens_are_the_tops_of_their_plinths(tmp_path: Path):
    sites, buildings, level = made(write_hill_plan(tmp_path / "plan", rules=GARDEN_RULES))
    area = shapely.area(lot_outlines(sites))
    for model in range(len(sites)):
        extra = triangles(replace(scene_of_model(scene_of(buildings), model), num_models=1))
        own = triangles(scene_of_model(scene_of(level), model))
        floors = []
        for batch in (extra, own):
            corners = batch.vertices[batch.triangles].astype(np.float64)
            flat = (np.abs(corners[:, :, 1]) < 1e-6).all(axis=1)
            up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[flat, 1] / 2
            floors.append(up[up > 0].sum())
        assert floors[1] == pytest.approx(area[model] / 3, rel=1e-3)
        assert floors[0] == pytest.approx(area[model], rel=1e-3)


def test_courts_stay_open(tmp_path: Path):
    plan = write_plan(tmp_path / "plan", {"a": shapely.box(0, 0, 60, 70), "b": shapely.box(100, 0, 120, 30)})
    hill = write_hill_plan(tmp_path / "hill", rules=RING_RULES)
    hill.write_text(hill.read_text() + 'footprint = "ring"\n')
    (hill.parent / "map.geojson").write_bytes((plan.parent / "map.geojson").read_bytes())
    sites, buildings, level = made(hill)
    (ring,) = (row for row, lot in enumerate(lot_outlines(sites)) if len(lot.interiors))
    prism = prism_of(scene_of(buildings), scene_of(level), ring)
    faces = placed(prism)
    edges = Counter(edge for face in faces for edge in pairwise([*face, face[0]]))
    # The top and the bottom pass the bridge to the court twice, and no wall stands on it.
    assert len(faces) == 2 + 4 + 4
    assert all(edges[end, start] == count for (start, end), count in edges.items())


def test_rules_that_know_the_ground_have_no_plinth(tmp_path: Path):
    rules = "attr groundMin = 0\n@StartRule\nLot --> t(0, groundMin, 0) extrude(world.up, 9 - groundMin) House."
    sites, buildings, level = made(write_hill_plan(tmp_path / "plan", rules=rules))
    assert len(scene_of(buildings)) == len(scene_of(level)) == len(sites)
    assert scene_bounds(scene_of(buildings))[0][:, 1] == pytest.approx(-sites.plinth)


def test_level_ground_changes_nothing_but_heights(tmp_path: Path):
    """The bytes of a shard's models depend on the terrain by plinths and heights alone."""
    flat = write_plan(tmp_path / "flat", boxes())
    level = write_hill_plan(tmp_path / "level", lambda east, _north: 0.0 * east)
    build_city(flat, tmp_path / "one", cityjson=LEVELS)
    build_city(level, tmp_path / "two", cityjson=LEVELS)
    one, two = files_of(tmp_path / "one"), files_of(tmp_path / "two")
    for files in (one, two):  # keys, and fields of parcels that rules might have seen
        for name in [name for name in files if re.search(r"record\.json|/quads/.*\.json$|\.branch$|\.parquet$", name)]:
            del files[name]
    assert one == two


def test_tiles_and_cityjson_reach_the_ground(tmp_path: Path):
    plan = write_hill_plan(tmp_path / "plan")
    result = build_city(plan, tmp_path / "city", cityjson=LEVELS)
    assert result.most_draws <= 10
    survey, _ = survey_of(plan)
    ground = dict(zip(survey.parcels.id[survey.sites.parcel], lowest_ground(survey.sites), strict=True))
    lots = dict(zip(survey.parcels.id[survey.sites.parcel], lot_outlines(survey.sites), strict=True))
    features = features_of(tmp_path / "city" / "city.city.jsonl")
    assert {feature["id"] for feature in features} == set(ground)
    for feature in features:
        assert_well_formed(feature)
        heights = np.array(feature["vertices"])[:, 2] / 1000
        for level in ("1", "2", "3"):
            geometry = geometry_of(feature, level)
            rows = {row for surface in surfaces_of(geometry) for ring in surface for row in ring}
            assert heights[list(rows)].min() == pytest.approx(ground[feature["id"]], abs=5e-3)
            kinds = zip(surfaces_of(geometry), types_of(geometry), strict=True)
            floors = [heights[ring].max() for surface, kind in kinds if kind == "GroundSurface" for ring in surface]
            assert floors == [pytest.approx(ground[feature["id"]], abs=5e-3)]
        block = geometry_of(feature, "1")
        assert_closed_manifold(block)
        assert_closed_manifold(geometry_of(feature, "2"))
        tall = heights.max() - heights.min()
        assert volume(block, feature) == pytest.approx(lots[feature["id"]].area * tall, rel=0.01)
    (shard,) = (tmp_path / "city" / "shards").glob("*/tileset.json")
    boxes_with_content = list(content_boxes(json.loads(shard.read_text())["root"]))
    assert len(boxes_with_content) == result.num_tiles
    bottoms = [box[2] - box[11] for box in boxes_with_content]
    assert min(bottoms) == pytest.approx(min(ground.values()), abs=0.1)
    assert max(bottoms) <= max(ground.values()) + 0.1


def content_boxes(tile: dict[str, Any]) -> Iterator[list[float]]:
    """Boxes of the tiles that have content."""
    if "content" in tile:
        yield tile["boundingVolume"]["box"]
    for child in tile.get("children", []):
        yield from content_boxes(child)
