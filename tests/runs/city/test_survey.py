"""Surveys: the ground of maps with and without a terrain."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from grammarlab.city.plan import read_plan
from grammarlab.runs.city.survey import Survey, surveyed
from grammarlab.runs.city.zone_rules import ZoneRules
from tests.runs.city.hills import slope, write_hill_plan, write_terrain
from tests.runs.city.plans import boxes, write_plan


def survey_of(plan: Path) -> Survey:
    read = read_plan(plan)
    return surveyed(read, [ZoneRules.of(zone) for zone in read.zones])


def test_a_terrain_without_a_system_lies_under_a_layout(tmp_path: Path):
    write_terrain(tmp_path / "ground.tif")
    plan = tmp_path / "plan.toml"
    plan.write_text('terrain = "ground.tif"\n[layout]\nsize = "90x60"\n[[zones]]\nname = "all"\ngrammar = "building"\n')
    survey = survey_of(plan)
    places = np.array([[0.0, 0.0], [13.0, -7.0]])
    assert survey.heights(places) == pytest.approx(slope(*places.T))
    assert survey.ground.remarks == ()
    base = survey.sites.corner[:, 1]
    assert np.ptp(base) > 1.0
    assert (survey.sites.plinth > 0).any()


def test_rules_that_ask_about_other_buildings_are_said_to_see_none(tmp_path: Path):
    plan = write_plan(tmp_path / "plan", boxes())
    assert survey_of(plan).remarks == ()
    rules = "attr height = 3\nLot --> case inside(inter) || overlaps || inside(intra) : NIL else : extrude(height) A"
    (plan.parent / "rules.cga").write_text(rules)
    texts = [str(remark) for remark in survey_of(plan).remarks]
    assert [text.partition(" sees")[0] for text in texts] == [
        "zone 'west', rules: inside(inter)",
        "zone 'west', rules: overlaps",
    ]


def test_parcels_beyond_the_terrain_are_said(tmp_path: Path):
    plan = write_hill_plan(tmp_path / "plan", lambda east, north: np.where(north > 75.0, np.nan, slope(east, north)))
    (remark,) = survey_of(plan).ground.remarks
    assert str(remark).endswith("it has no height for 16 of 24 parcels: their ground is at 0 m")


def test_without_a_terrain_the_ground_is_that_of_the_nearest_parcel(tmp_path: Path):
    plan = write_plan(tmp_path / "plan", boxes())
    path = plan.parent / "map.geojson"
    text = json.loads(path.read_text())
    for feature in text["features"]:
        height = 10.0 + 5.0 * int(feature["properties"]["id"][0])
        (ring,) = feature["geometry"]["coordinates"]
        feature["geometry"]["coordinates"] = [[[*point, height] for point in ring]]
    path.write_text(json.dumps(text))
    survey = survey_of(plan)
    assert survey.heights(np.array([[100.0, 61.0], [20.0, 78.0], [20.0, 500.0]])).tolist() == [10.0, 15.0, 20.0]
    assert set(survey.sites.corner[:, 1]) == {10.0, 15.0, 20.0}
