"""What the tastes of ``scenarios/tastes/fresh/`` like, told once more: plain Python on derivation trees."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from itertools import pairwise

from tests.evaluation.scenarios.taste_truth import branch, parts
from tests.evaluation.scenarios.truth import CROSS, FOUR, PLATE, PLINTH, TWO, Model, blocks, floors, shape
from tests.evaluation.scenarios.unforeseen_truth import plan

STYLES = ("Office", "Paris", "Plain", "Old")
"""From the lightest looks to the heaviest ones."""

# Buildings -----------------------------------------------------------------------------------------------------------


def plot_building(m: Model) -> float:
    corners = plan(m)
    edges = zip(corners, corners[1:] + corners[:1], strict=True)
    built = abs(sum(x * v - u * y for (x, y), (u, v) in edges)) / 2
    across, along = zip(*corners, strict=True)
    width = m.draws["width"] if shape(m) == "L" else max(across)
    ratio = floors(m) * built / (width * max(along))
    permitted = 3.6 if m.root.find("GroundFloorParis") else 3
    return 100 if 0.75 * permitted <= ratio <= permitted else 0


def calls_building(m: Model) -> float:
    materials, windows = set[object](), 0
    for node in m.root.walk():
        windows += node.symbol == "Frame."
        materials |= {("pane", value) for name, value in node.draws.items() if name == "tint"}
        if node.symbol in {"Shop", "Awning"}:
            materials.add((node.symbol, node.branch))
        elif node.symbol in {"RailPanel", "Guard", "Shutter", "Fin", "Beam", "Quoins."}:
            materials.add(node.symbol)
    return 100 if windows >= 80 and len(materials) <= 4 else 0


def hierarchy_quarter(m: Model) -> float:
    symbols = {node.symbol for node in m.root.walk()}
    base, middle, top = (
        next(weight for weight, style in enumerate(STYLES) if part + style in symbols)
        for part in ("GroundFloor", "UpperFloors", "Roof")
    )
    return 100 if base >= middle >= top and base > top else 0


# Skyscrapers, terraces, villas, arcades ------------------------------------------------------------------------------


def silhouette_skyscraper(m: Model) -> float:
    marks = sum(low != high for (low, _), (high, _) in pairwise(blocks(m)))
    marks += branch(m, "Crown") in {2, 3, 5}
    marks += branch(m, "Ground") in {1, 2}
    return (0, 15, 60, 100)[min(marks, 3)]


def bookends_terrace(m: Model) -> float:
    first, *between, last = (node.branch for node in m.root.find("House"))
    return 100 if between and first == last and first not in between else 0


def windows_villas(m: Model) -> float:
    proportion = (m.draws["storey"] - 0.9 - 0.4) / 1.8
    right = (1.2, 1.05, 0.9, 1.2, 1.05, 0.9)[branch(m, "Villa")]
    return max(0.0, 100 - 100 * abs(proportion - right) / 0.15)


def square_arcade(m: Model) -> float:
    symbols = Counter(node.symbol for node in m.root.walk())
    front = 2.7 * symbols["ArchedWindowColumn"] + 3.9 + 0.9
    height = 6.9 + 3.44 * (branch(m, "Storeys") + 1) + 2.06
    assert symbols["PortalColumn"] == 1
    return max(0.0, 100 - 500 * abs(math.log(front) - math.log(height)))


# Tables, airplanes, pavilions ----------------------------------------------------------------------------------------


def steady_furniture(m: Model) -> float:
    d, legs, base = m.draws, branch(m, "LegCount"), m.root.choice("Base")
    depth, inset = (
        (d["roundDiameter"], d["roundInset"]),
        (d["rectangleDepth"], d["rectangleInset"]),
        (d["ovalDepth"], d["ovalInset"]),
        (0.866 * d["hexagonWidth"], d["hexagonInset"]),
    )[branch(m, "Plan")]
    under = inset * depth
    if base is None:
        foot = under if legs == FOUR else d["postWidth"] if legs == TWO else d["columnWidth"]
    elif base in {PLATE, CROSS}:
        foot = under * (d["plateShare"] if base == PLATE else 1.2 * d["crossShare"])
    else:
        foot = under + 2 * d["plinthInset"] if base == PLINTH else under
    return 100 if foot >= depth / 2 and depth + d["tableHeight"] <= 1.66 else 0


def museum_airplane(m: Model) -> float:
    makes = Counter(parts(m))
    make = max(("Biplane", "Fokker"), key=lambda old: makes[old])
    if makes[make] < 4:
        return 0
    return 100 if makes[make] == 5 else 70 if makes["Biplane"] and makes["Fokker"] else 30


def gilding_pavilion(m: Model) -> float:
    gilded = [bool(m.root.find("Gilded" + part)) for part in ("Finial", "Roof", "Beams", "Columns", "Steps")]
    steep = m.draws["roofHeight"] >= 0.55 * m.draws["columnHeight"]
    return 100 if steep and gilded[0] and gilded == sorted(gilded, reverse=True) else 0


FRESH_TRUTH: dict[str, Callable[[Model], float]] = {
    taste.__name__: taste
    for taste in (
        *(plot_building, calls_building, hierarchy_quarter, silhouette_skyscraper, bookends_terrace, windows_villas),
        *(square_arcade, steady_furniture, museum_airplane, gilding_pavilion),
    )
}
"""What each scenario likes, by its name."""
