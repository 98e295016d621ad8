"""What the tastes of ``scenarios/tastes/professions/`` like, told once more: plain Python on derivation trees."""

from __future__ import annotations

import math
from collections.abc import Callable

from tests.evaluation.scenarios.taste_truth import branch
from tests.evaluation.scenarios.truth import ONE, Model, Node

# Rows of houses ------------------------------------------------------------------------------------------------------


def looks(house: Node) -> set[object]:
    """The paint of a house and the kinds of its two bays."""
    return {house.branch, *(node.symbol for node in house.walk() if node.symbol in {"Square", "Arch", "Balcony"})}


def eyes_terrace(m: Model) -> float:
    has = ["Balcony" in looks(house) for house in m.root.find("House")]
    return 100 if all(any(has[max(at - 1, 0) : at + 2]) for at in range(len(has))) else 0


def reveal_terrace(m: Model) -> float:
    seen = set[object]()
    for house in m.root.find("House"):
        if looks(house) <= seen:
            return 0
        seen |= looks(house)
    return (0, 50, 80, 100)[len(m.root.find("House")) - 2]


# Buildings -----------------------------------------------------------------------------------------------------------


def listed_building(m: Model) -> float:
    walls, ground = branch(m, "WallColor"), branch(m, "GroundFloor")
    spoiled = ground in {0, 1}
    as_built = walls == ground == 1 and m.root.choice("RoofOnParis") == 1
    return 100 if walls >= 1 and m.root.find("Chimney") and (not spoiled or as_built) else 0


def product_quarter(m: Model) -> float:
    symbols = {node.symbol for node in m.root.walk()}
    size = branch(m, "Lot")
    if size >= 4:
        return 100 if {"GroundFloorOffice", "UpperFloorsOffice"} <= symbols else 0
    if size >= 2:
        flats = bool(symbols & {"UpperFloorsParis", "UpperFloorsPlain", "UpperFloorsOld"})
        return (80 if "GroundFloorParis" in symbols else 40) if flats else 0
    if symbols & {"WallsOffice", "GroundFloorOffice", "UpperFloorsOffice"}:
        return 0
    return 20 if "RoofOffice" in symbols else 60


def climb_skyscraper(m: Model) -> float:
    (tower,) = m.root.find("Tower")
    blocks = [child for child in tower.children if child.symbol == "Block"]
    heights = ("firstHeight", "secondHeight", "thirdHeight", "fourthHeight") if len(blocks) > 1 else ("soloHeight",)
    climbed = 0.0
    for block, height in zip(blocks, heights, strict=False):
        if any(node.branch == 1 for node in block.walk() if node.symbol in {"BoxFrame", "CylinderFrame", "VFrame"}):
            break
        climbed += m.draws[height]
    return min(max(100 * (climbed - 120) / 90, 0.0), 100.0)


def abutment_arcade(m: Model) -> float:
    bays = [node.symbol for node in m.root.walk() if node.symbol in {"ArchedWindowColumn", "PortalColumn"}]
    left = bays.index("PortalColumn")
    weaker, rows = min(left, len(bays) - 1 - left), branch(m, "Storeys") + 1
    return 100 if weaker > rows else 33 if weaker == rows else 0


# Tables, airplanes, pavilions ----------------------------------------------------------------------------------------


def seats_furniture(m: Model) -> float:
    d = m.draws
    plan = branch(m, "Plan")
    if plan == 0:
        size, edge = (d["roundDiameter"],) * 2, 3.14159 * d["roundDiameter"]
    elif plan == 1:
        size = d["rectangleWidth"], d["rectangleDepth"]
        edge = 2 * sum(size)
    elif plan == 2:
        size = d["ovalWidth"], d["ovalDepth"]
        a, b = size[0] / 2, size[1] / 2
        edge = 3.14159 * (3 * (a + b) - math.sqrt((3 * a + b) * (a + 3 * b)))  # Ramanujan
    else:
        size, edge = (d["hexagonWidth"], 0.866 * d["hexagonWidth"]), 3 * d["hexagonWidth"]
    guests = math.floor(edge / 0.6) - (branch(m, "LegCount") != ONE)
    return min(max(100 * (guests / ((size[0] + 1.2) * (size[1] + 1.2)) - 1) / 0.3, 0.0), 100.0)


def stands_airplane(m: Model) -> float:
    length = m.draws["lengthScale"] * (10.5, 9, 33, 26, 17)[branch(m, "Airplane")]
    span = length * m.draws["spanScale"] * (1.28, 1.24, 0.94, 1.3, 0.69)[branch(m, "Wings")]
    return max(0.0, 100 * (1 - min(abs(span - limit) for limit in (15, 24, 36)) / 1.5))


def mirrors_pavilion(m: Model) -> float:
    parts = ("Steps", "Columns", "Beams", "Roof", "Finial")
    gilded = [at for at, part in enumerate(parts) if m.root.find("Gilded" + part)]
    return (0, 60, 80, 100)[gilded[1] - gilded[0] - 1] if len(gilded) == 2 else 0


PROFESSIONS_TRUTH: dict[str, Callable[[Model], float]] = {
    taste.__name__: taste
    for taste in (
        *(eyes_terrace, reveal_terrace, listed_building, product_quarter, climb_skyscraper, abutment_arcade),
        *(seats_furniture, stands_airplane, mirrors_pavilion),
    )
}
"""What each scenario likes, by its name."""
