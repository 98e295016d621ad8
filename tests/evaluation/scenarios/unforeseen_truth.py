"""What the tastes of ``scenarios/tastes/unforeseen/`` like, told once more: plain Python on derivation trees."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable

from tests.evaluation.scenarios.taste_truth import branch, parts, sizes
from tests.evaluation.scenarios.truth import Model, blocks

# Terraces and villas -------------------------------------------------------------------------------------------------

ORNAMENT = {"Square": 0, "Arch": 1, "Balcony": 2}


def balance_terrace(m: Model) -> float:
    bays = [ORNAMENT[n.symbol] for n in m.root.walk() if n.symbol in ORNAMENT]  # from left to right
    middle = len(bays) // 2
    assert len(bays) == 2 * len(m.root.find("House"))
    return 100 if sum(bays[:middle]) == sum(bays[middle:]) and bays != bays[::-1] else 0


def pace_villas(m: Model) -> float:
    symbols = {node.symbol for node in m.root.walk()}
    ornaments = sum(any(s.endswith(part) for s in symbols) for part in ("Attic", "Columns", "Bows", "Chimney"))
    area = m.draws["front"] * m.draws["depth"] * (branch(m, "Storeys") + 1)
    off = abs(ornaments - area / 120)
    return 100 * (0.8 - off) / 0.8 if off < 0.8 else 0


# Skyscrapers, airplanes, buildings -----------------------------------------------------------------------------------


def bonus_skyscraper(m: Model) -> float:
    number = len(blocks(m))
    names = ("firstHeight", "secondHeight", "thirdHeight", "fourthHeight")[:number]
    height = m.draws["soloHeight"] if number == 1 else sum(m.draws[name] for name in names)
    gift = {1: 25, 2: 40}.get(branch(m, "Ground"), 0)  # colonnade, podium
    limit = 120 + gift + 15 * (number - 1)
    return 100 if limit * 0.9 <= height <= limit else 0


def lead_airplane(m: Model) -> float:
    found = parts(m)
    return 100 if found.count(found[0]) == 3 and sorted(Counter(found).values()) == [2, 3] else 0


def plan(m: Model) -> list[tuple[float, float]]:
    """The corners of the footprint of a building."""
    d = m.draws
    shape = branch(m, "Building")
    if shape == 0:
        w, back = d["width"], d["rectangleDepth"]
        return [(0, 0), (w, 0), (w, back), (0, back)]
    main, front, wing, gap = d["mainDepth"], d["depth"], d["wingWidth"], d["wingSetback"]
    if shape == 1:
        w = d["width"]
        return [
            (0, 0),
            (w, 0),
            (w, main),
            (gap + wing, main),
            (gap + wing, front),
            (gap, front),
            (gap, main),
            (0, main),
        ]
    w = 2 * gap + 2 * wing + d["courtWidth"]
    right = [(w, 0), (w, main), (w - gap, main), (w - gap, front), (w - gap - wing, front), (w - gap - wing, main)]
    left = [(w - x, y) for x, y in right]
    return [*right, *reversed(left)]


def envelope_building(m: Model) -> float:
    corners = plan(m)
    edges = list(zip(corners, corners[1:] + corners[:1], strict=True))
    area = abs(sum(x * v - u * y for (x, y), (u, v) in edges)) / 2
    outline = sum(math.dist(a, b) for a, b in edges)
    height = m.draws["groundHeight"] + (branch(m, "Floors") + 1) * m.draws["floorHeight"]
    return 100 if outline * height + 2 * area <= 0.445 * area * height else 0


DESERVED = {"Office": 14, "Paris": 6, "Plain": 3, "Old": 2}


def tolerance_quarter(m: Model) -> float:
    symbols = {node.symbol for node in m.root.walk()}
    walls, *others = (
        next(style for style in DESERVED if part + style in symbols)
        for part in ("Walls", "GroundFloor", "UpperFloors", "Roof")
    )
    floors = (2, 3, 5, 6, 9, 14, 20)[branch(m, "Lot")]
    for style in others:
        floors *= 1 if style == walls else 2
    return 100 if floors <= DESERVED[walls] else 0


# Tables, facades, toys, boxes ----------------------------------------------------------------------------------------

ROUND_LEGS = {(legs, kind): kind in {0, 3} for legs in range(3) for kind in range(5)}
"""By the number of legs and their kind: round and turned ones are round."""


def forms_furniture(m: Model) -> float:
    legs = branch(m, "LegCount")
    kind = branch(m, ("OneLeg", "TwoLegs", "FourLegs")[legs])
    forms = {branch(m, "Plan") in {0, 2}, ROUND_LEGS[legs, kind]}
    base = m.root.choice("Base")
    if base == 0:
        forms.add(branch(m, "Pads") == 0)
    elif base is not None:
        forms.add(base == 1)
    return 100 if len(forms) == 1 else 0


def thirds_arcade(m: Model) -> float:
    at, door = 0.9, 0.0
    for node in m.root.walk():
        if node.symbol == "PortalColumn":
            door = at + 1.5
            at += 3.9
        elif node.symbol == "ArchedWindowColumn":
            at += 2.7
    return 100 if any(abs(door / at - third / 3) <= 0.05 for third in (1, 2)) else 0


def weight_toy(m: Model) -> float:
    shapes, colours = (
        [node.branch for node in m.root.find(symbol) if node.branch is not None] for symbol in ("MASS", "MESH2")
    )
    below, above = (
        m.draws[height] * (1, 0.8, 0.5)[shape] * (0.7, 1, 1.4)[colour]
        for height, shape, colour in zip(("h1", "h2"), shapes, colours, strict=True)
    )
    return 100 if below >= 2 * above else 0


def worst_limits(m: Model) -> float:
    width, depth, height = sizes(m)
    wishes = [width * depth / 25, 2 * height / depth, 100 / (width * depth * height), 1]
    return max(0.0, 100 * (sorted(wishes)[0] - 0.4) / 0.6)


UNFORESEEN_TRUTH: dict[str, Callable[[Model], float]] = {
    taste.__name__: taste
    for taste in (
        *(balance_terrace, pace_villas, bonus_skyscraper, lead_airplane, envelope_building, tolerance_quarter),
        *(forms_furniture, thirds_arcade, weight_toy, worst_limits),
    )
}
"""What each scenario likes, by its name."""
