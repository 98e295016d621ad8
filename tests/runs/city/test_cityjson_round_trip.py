"""Buildings written as CityJSON are parcels of a map again, where they were."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from grammarlab.city.parcel_map import read_parcels
from grammarlab.derivation import derive
from grammarlab.export.cityjson import CityBuilding, CityJsonWriter
from grammarlab.geometry.footprints.frame import Frame
from grammarlab.language.grammar import Grammar
from grammarlab.runs.city.semantics import surface_labels
from grammarlab.scene import realize

RULES = "Lot --> extrude(6) comp(f) { side : Wall. | top : roofHip(30, 0.4) Roof. }"
PLANS = [
    shapely.box(100, 200, 118, 211),
    shapely.Polygon([(300, 400), (324, 404), (321, 421), (309, 419), (310, 411), (298.5, 409)]),
    shapely.Polygon([(-200, 30), (-180, 22), (-174, 37), (-194, 45)]),
]


def building(name: str, plan: shapely.Polygon) -> CityBuilding:
    corner = np.floor(plan.bounds[:2])
    east, north = (shapely.get_coordinates(plan)[:-1] - corner).T
    forest = derive(Grammar.parse(RULES), 1, 5, footprint=np.column_stack([east, np.zeros(len(east)), -north]))
    return CityBuilding(
        id=name,
        footprint=plan,
        ground=31.5,
        scene=realize(forest),
        corner=np.array([corner[0], 31.5, -corner[1]]),
        labels=surface_labels(forest),
        attributes={"zone": "centre"},
    )


def test_the_reader_of_maps_finds_the_footprints(tmp_path):
    frame = Frame("EPSG:28992", (85000.0, 447000.0))
    plans = [orient(plan) for plan in PLANS]
    with CityJsonWriter(tmp_path / "city.city.jsonl", frame) as writer:
        for index, plan in enumerate(plans):
            writer.add(building(f"plot {index}", plan))
    parcels = read_parcels(tmp_path / "city.city.jsonl", frame=frame).parcels
    assert parcels.id.tolist() == ["plot 0", "plot 1", "plot 2"]
    assert (shapely.hausdorff_distance(parcels.outline, np.array(plans)) < 0.002).all()
    assert parcels.attributes["zone"].to_pylist() == ["centre"] * 3
