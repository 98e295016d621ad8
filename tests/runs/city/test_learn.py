"""Zones of a plan are learned from a table of answers, and the plan then builds with them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grammarlab.city.plan import read_plan
from grammarlab.city.zone_file import read_zones
from grammarlab.errors import AssetError, UsageError
from grammarlab.runs.city.learn import learn_zones, plan_fields, questions

NUM = 12


def _square(east: float, north: float) -> list[list[float]]:
    return [[east, north], [east + 25, north], [east + 25, north + 30], [east, north + 30], [east, north]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan of 144 parcels, and answers of a person who wants towers in the west."""
    folder = tmp_path_factory.mktemp("city")
    features: list[dict[str, Any]] = [
        {
            "type": "Feature",
            "properties": {
                "id": f"{column:02d}-{row:02d}",
                "floors": (7 * row + column) % 5,
                "row": 100 * column + row,
            },
            "geometry": {"type": "Polygon", "coordinates": [_square(30.0 * column, 34.0 * row)]},
        }
        for column in range(NUM)
        for row in range(NUM)
    ]
    (folder / "parcels.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    (folder / "plan.toml").write_text(
        'parcels = "parcels.geojson"\ncrs = "local"\nid = "id"\n'
        '[[zones]]\nname = "towers"\ngrammar = "building"\ndensity = "two.zones.json"\n'
        '[[zones]]\nname = "houses"\ngrammar = "building"\ndensity = "two.zones.json"\n'
    )
    ids = [feature["properties"]["id"] for feature in features[::3]]
    rows = [f"{name},{'towers' if int(name[:2]) < 5 else 'houses'}" for name in ids]
    (folder / "answers.csv").write_text("id,zone\n" + "\n".join(rows) + "\n99-99,towers\n00-01,\n")
    return folder


def test_zones_of_a_plan_are_learned_and_written(folder: Path):
    result = learn_zones(folder / "plan.toml", folder / "answers.csv")
    assert result.file == folder / "two.zones.json"
    density = read_zones(result.file)
    assert density.zones == ("towers", "houses")
    assert "row" not in {feature.name for feature in density.features}  # its numbers are all different: an id
    fields = plan_fields(read_plan(folder / "plan.toml"))
    chance = density.probabilities(fields)[:, 0]
    column = np.array([int(name[:2]) for name in fields.id])
    assert chance[column < 4].min() > 0.7
    assert chance[column > 6].max() < 0.3
    assert (result.num_answers, result.num_blank, result.unknown) == (49, 1, ("99-99",))
    assert result.held_out is not None
    assert result.held_out.log_loss < 0.5 * result.held_out.log_loss_of_shares
    assert result.held_out.accuracy > 0.9


def test_the_report_is_json(folder: Path):
    report = learn_zones(
        folder / "plan.toml", folder / "answers.csv", folder / "b.zones.json", num_questions=3
    ).as_json()
    assert json.loads(json.dumps(report)) == report
    assert report["zones"] == {"houses": 28, "towers": 21}
    assert sum(report["decides"].values()) == pytest.approx(1.0, abs=1e-3)
    answered = {line.split(",")[0] for line in (folder / "answers.csv").read_text().splitlines()[1:-1]}
    assert len(set(report["questions"])) == 3
    assert not set(report["questions"]) & answered


def test_the_order_of_answers_changes_no_byte(folder: Path):
    lines = (folder / "answers.csv").read_text().splitlines()
    (folder / "shuffled.csv").write_text("\n".join([lines[0], *lines[:0:-1]]))
    learn_zones(folder / "plan.toml", folder / "answers.csv", folder / "b.zones.json")
    learn_zones(folder / "plan.toml", folder / "shuffled.csv", folder / "c.zones.json")
    assert (folder / "b.zones.json").read_bytes() == (folder / "c.zones.json").read_bytes()


def test_zones_are_learned_from_scores(folder: Path):
    rows = [
        f"{column:02d}-{row:02d},{zone},{90 if (zone == 'towers') == (column < 6) else 10}"
        for column in range(0, NUM, 2)
        for row in range(0, NUM, 4)
        for zone in ("towers", "houses")
    ]
    (folder / "scores.csv").write_text("id,zone,score\n" + "\n".join(rows))
    result = learn_zones(folder / "plan.toml", folder / "scores.csv", folder / "s.zones.json")
    fields = plan_fields(read_plan(folder / "plan.toml"))
    chance = result.learned.density.probabilities(fields)[:, 0]
    column = np.array([int(name[:2]) for name in fields.id])
    assert chance[column < 4].mean() > 0.75
    assert chance[column > 7].mean() < 0.25
    assert result.held_out is None


def test_first_questions_are_different_parcels(folder: Path):
    asked = questions(folder / "plan.toml", 20)
    assert len(set(asked)) == 20
    assert asked == questions(folder / "plan.toml", 20)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("id,zone\n00-00,castles\n", r"line 2: expected a zone of the plan, one of towers, houses; found 'castles'"),
        ("id,zone\n1,towers\n2,houses\n", r"line 2: no parcel '1' can be built on, nor any other of the 2 ids"),
        ("id\n1\n", "expected the columns id and zone"),
    ],
)
def test_answers_that_do_not_fit_the_plan_are_refused(folder: Path, table: str, message: str):
    (folder / "bad.csv").write_text(table)
    with pytest.raises(AssetError, match=message):
        learn_zones(folder / "plan.toml", folder / "bad.csv", folder / "bad.zones.json")
    assert not (folder / "bad.zones.json").exists()


def test_a_file_that_is_read_is_not_overwritten(folder: Path):
    with pytest.raises(UsageError):
        learn_zones(folder / "plan.toml", folder / "answers.csv", folder / "answers.csv")
