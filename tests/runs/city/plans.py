"""A small city for tests: 24 parcels in two rows of blocks, on the earth or at an unknown place."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import shapely

RULES = """
attr height = 9
@StartRule
Lot --> extrude(height) comp(f) { street.front : color("#aa3322") Front. | side : Wall. | top : roofHip(30) Roof. }
       report("height", height)
"""
RULES_BY_CHANCE = """
@StartRule
Lot -->
	50% : extrude(rand(4, 8)) Low.
	else : extrude(rand(9, 20)) color("#223344") High.
"""


def boxes() -> dict[str, shapely.Polygon]:
    """Parcels by id, in metres."""
    return {
        f"{row}-{column}": shapely.box(22 * column, 80 * row + side * 30, 22 * column + 22, 80 * row + side * 30 + 30)
        for row in range(3)
        for side in range(2)
        for column in [4 * side + number for number in range(4)]
    }


def write_map(path: Path, parcels: dict[str, shapely.Polygon], order: Sequence[str] | None = None) -> None:
    """Parcels as GeoJSON in metres at an unknown place."""
    features = [
        {
            "type": "Feature",
            "properties": {"id": name, "side": "west" if name.startswith("0") else "east"},
            "geometry": json.loads(shapely.to_geojson(parcels[name])),
        }
        for name in order or parcels
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "crs": None, "features": features}))


def write_plan(folder: Path, parcels: dict[str, shapely.Polygon], order: Sequence[str] | None = None) -> Path:
    """A plan with two zones."""
    folder.mkdir(exist_ok=True)
    write_map(folder / "map.geojson", parcels, order)
    (folder / "rules.cga").write_text(RULES)
    (folder / "chance.cga").write_text(RULES_BY_CHANCE)
    plan = folder / "plan.toml"
    plan.write_text(
        """
parcels = "map.geojson"
crs = "local"
seed = 3

[minimum]
area = 30

[[zones]]
name = "west"
grammar = "rules.cga"
where = "area > 0"
match = { side = "west" }
attributes = { height = 12 }

[[zones]]
name = "rest"
grammar = "chance.cga"
"""
    )
    return plan


def files_of(folder: Path) -> dict[str, bytes]:
    """Files of a city by name, but for those that name the plan's place."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name not in {"city.json", ".grammarlab.json"}
    }
