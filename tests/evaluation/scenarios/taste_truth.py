"""What the tastes like, told once more: plain Python that walks one derivation tree.

Written from the grammars' comments, apart from the expressions in ``scenarios/tastes/``.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable

from tests.evaluation.scenarios.truth import (
    BLACK,
    DARK,
    FOUR,
    LIGHT,
    ONE,
    PAINT,
    RECTANGLE,
    ROUND,
    STEEL,
    TWO,
    Model,
    Node,
    blocks,
    floors,
    shape,
    steps,
    style,
)

OVAL, HEXAGON = 2, 3
BRONZE = 3


def near(*differences: float, width: float) -> float:
    """100 at no difference, less by the square of the distance over the width."""
    return 100 * math.exp(-(math.hypot(*differences) ** 2) / width)


def branch(m: Model, symbol: str) -> int:
    """What the only node with a symbol drew."""
    found = m.root.choice(symbol)
    assert found is not None, symbol
    return found


# Furniture -----------------------------------------------------------------------------------------------------------


def multiplicative_furniture(m: Model) -> float:
    finish = {STEEL: 1, DARK: 0.5, LIGHT: 0.25, PAINT: 0.1}[branch(m, "Finish")]
    legs = {ONE: 1, TWO: 0.4, FOUR: 0.15}[branch(m, "LegCount")]
    plan = {ROUND: 1, RECTANGLE: 0.3, OVAL: 0.6, HEXAGON: 0.6}[branch(m, "Plan")]
    return 100 * finish * legs * plan


def xor_furniture(m: Model) -> float:
    return 100 if (branch(m, "Plan") == ROUND) ^ (branch(m, "Finish") == STEEL) else 0


def partial_furniture(m: Model) -> float:
    if branch(m, "Under") == 0:
        return 8
    return 100 if m.root.find("Slat") else 30


def factors_furniture(m: Model) -> float:
    return xor_furniture(m) * partial_furniture(m) * multiplicative_furniture(m) / 10_000


def levels_furniture(m: Model) -> float:
    grades = {
        LIGHT: {ROUND: 80, OVAL: 25, HEXAGON: 25},
        DARK: {ROUND: 5, RECTANGLE: 100, OVAL: 50},
        STEEL: {ROUND: 35, HEXAGON: 90},
        PAINT: {ROUND: 65, RECTANGLE: 15, OVAL: 65},
    }
    return grades[branch(m, "Finish")].get(branch(m, "Plan"), 0)


def rare_furniture(m: Model) -> float:
    marble, legs = branch(m, "TopFinish") == 4, branch(m, "LegFinish")
    return 0 if not marble or legs == 0 else 100 if legs == 4 else 50


def conjunction_furniture(m: Model) -> float:
    return 100 if [branch(m, s) for s in ("Plan", "Finish", "LegCount")] == [ROUND, DARK, FOUR] else 0


def majority_furniture(m: Model) -> float:
    wanted = {"Plan": RECTANGLE, "Finish": STEEL, "LegCount": ONE}
    return 100 if sum(branch(m, symbol) == liked for symbol, liked in wanted.items()) >= 2 else 0


def additive_furniture(m: Model) -> float:
    points = {
        "Finish": (LIGHT, 30),
        "Plan": (RECTANGLE, 25),
        "Under": (1, 20),
        "LegCount": (TWO, 15),
        "Support": (0, 10),
    }
    return sum(worth for symbol, (liked, worth) in points.items() if branch(m, symbol) == liked)


def smooth_furniture(m: Model) -> float:
    return near(m.draws["tableHeight"] - 0.745, width=2 * 0.006**2)


# Buildings -----------------------------------------------------------------------------------------------------------


def count_building(m: Model) -> float:
    kinds = ("Balcony", "Balconette", "LongBalcony")
    return 100 if sum(len(m.root.find(symbol)) for symbol in kinds) >= 9 else 0


def levels_building(m: Model) -> float:
    grades = {
        "rectangle": {2: 90, 3: 60, 4: 20, 5: 20},
        "L": {2: 5, 3: 30, 4: 75, 5: 100, 6: 75},
        "U": {2: 10, 3: 10, 4: 45},
    }
    return grades[shape(m)].get(floors(m), 0)


def conjunction_building(m: Model) -> float:
    return 100 if shape(m) == "L" and floors(m) >= 5 and m.root.find("WallColorPlain") else 0


def multiplicative_building(m: Model) -> float:
    roof = 1 if m.root.find("RoofOffice") else 0.6 if m.root.find("RoofParis") else 0.3
    mass = {"L": 1, "U": 0.5, "rectangle": 0.2}[shape(m)]
    return 100 * mass * {2: 0.1, 3: 0.3, 4: 0.5, 5: 0.8, 6: 1}[floors(m)] * roof


def partial_building(m: Model) -> float:
    dormers = [node.branch == 0 for node in m.root.find("Dormer")]
    return 20 + 80 * sum(dormers) / len(dormers) if dormers else 8


def equal_building(m: Model) -> float:
    return 100 if style(m) else 0


def band_building(m: Model) -> float:
    height = m.draws["groundHeight"] + (floors(m) - 1) * m.draws["floorHeight"]
    return 100 if 10.1 <= height < 13.3 else 0


def court(m: Model) -> bool:
    return shape(m) == "U"


def additive_building(m: Model) -> float:
    shops, brick, solar = (bool(m.root.find(symbol)) for symbol in ("GroundFloorParis", "WallColorOld", "SolarPanels"))
    return 30 * court(m) + 25 * shops + 20 * (floors(m) == 6) + 15 * brick + 10 * solar


def xor_building(m: Model) -> float:
    return 100 if court(m) ^ bool(m.root.find("GroundFloorOffice")) else 0


def comparison_building(m: Model) -> float:
    return 100 if m.draws["groundHeight"] / m.draws["floorHeight"] > 1.25 else 0


def factors_building(m: Model) -> float:
    return xor_building(m) * comparison_building(m) * additive_building(m) / 10_000


# Skyscrapers ---------------------------------------------------------------------------------------------------------


def mast(m: Model) -> bool:
    return bool(m.root.find("Mast"))


def additive_skyscraper(m: Model) -> float:
    podium, light = bool(m.root.find("Podium")), branch(m, "Cladding") == 0
    bronze = any(glass == BRONZE for _, glass in blocks(m))
    return 30 * podium + 25 * light + 20 * mast(m) + 15 * (len(blocks(m)) == 4) + 10 * bronze


def ratio_skyscraper(m: Model) -> float:
    return 100 * sum(glass == BLACK for _, glass in blocks(m)) / len(blocks(m))


def equal_skyscraper(m: Model) -> float:
    if len(blocks(m)) == 1:
        return 20
    return 100 if len({glass for _, glass in blocks(m)}) == 1 else 0


def band_skyscraper(m: Model) -> float:
    names = ["firstHeight", "secondHeight", "thirdHeight", "fourthHeight"][: len(blocks(m))]
    height = sum(m.draws[name] for name in names) if len(names) > 1 else m.draws["soloHeight"]
    return 100 if 140 <= height < 170 else 0


def xor_skyscraper(m: Model) -> float:
    return 100 if mast(m) ^ bool(m.root.find("Colonnade") or m.root.find("StonePlinth")) else 0


def partial_skyscraper(m: Model) -> float:
    return 20 + 80 * (m.draws["mastHeight"] - 24) / 24 if mast(m) else 6


def symmetric_skyscraper(m: Model) -> float:
    lowest = [shape for shape, _ in blocks(m)][:2]
    return 100 if len(lowest) == 2 and lowest[0] == lowest[1] else 0


def frame(block: Node) -> frozenset[str]:
    """What the frame of a block is made of: bands, fins, both, or tiers with fins."""
    (found,) = [node for shape in ("Box", "Cylinder", "V") for node in block.find(f"{shape}Frame")]
    return frozenset(child.symbol.removeprefix(found.symbol.removesuffix("Frame")) for child in found.children)


def equal_skyscraper_frames(m: Model) -> float:
    frames = [frame(block) for block in m.root.find("Block")]
    return 100 if len(frames) >= 2 and len(set(frames)) == 1 else 0


PODIUM, PLINTH = 2, 3


def multiplicative_skyscraper(m: Model) -> float:
    ground = 1 if m.root.find("Podium") else 0.5 if m.root.find("GlassLobby") else 0.2
    return 100 * ground * {0: 1, 3: 0.6}.get(branch(m, "Cladding"), 0.25) * {3: 1, 2: 0.5}.get(len(blocks(m)), 0.3)


def parity_skyscraper(m: Model) -> float:
    return 100 if len(m.root.find("VBlock")) in {1, 3} else 0


def comparison_skyscraper(m: Model) -> float:
    return 100 if len(blocks(m)) > 1 and m.draws["secondHeight"] / m.draws["firstHeight"] > 0.8 else 0


def factors_skyscraper(m: Model) -> float:
    return multiplicative_skyscraper(m) * comparison_skyscraper(m) * parity_skyscraper(m) / 10_000


def levels_skyscraper(m: Model) -> float:
    grades = {4: {PODIUM: 100, PLINTH: 90}, 3: {PODIUM: 60, 0: 50}, 2: {1: 20}, 1: {}}
    number = len(blocks(m))
    return grades[number].get(branch(m, "Ground"), {4: 70, 3: 40, 2: 8, 1: 2}[number])


def rare_skyscraper(m: Model) -> float:
    if len(m.root.find("CylinderBlock")) < 3:
        return 0
    return 100 if m.root.find("Colonnade") else 50


# Airplanes -----------------------------------------------------------------------------------------------------------


def part(m: Model, *endings: str) -> str:
    """The style of the one part whose symbol ends so."""
    styles = ("Biplane", "Fokker", "Airliner", "Transport", "Jet")
    (found,) = [s for s in styles for ending in endings if m.root.find(s + ending)]
    return found


def parts(m: Model) -> list[str]:
    """The styles of body, wings, tail, engines and gear."""
    return [part(m, *endings) for endings in (("Body",), ("Wings",), ("Tail",), ("Engine", "Engines"), ("Gear",))]


def majority_airplane(m: Model) -> float:
    return 100 if sum(found in {"Biplane", "Fokker"} for found in parts(m)[:3]) >= 2 else 0


def additive_airplane(m: Model) -> float:
    return sum(points for points, found in zip((30, 25, 20, 15, 10), parts(m), strict=True) if found == "Jet")


def parity_airplane(m: Model) -> float:
    return 100 if parts(m).count("Jet") in {1, 3, 5} else 0


def symmetric_airplane(m: Model) -> float:
    return 100 if part(m, "Wings") == part(m, "Tail") else 0


def factors_airplane(m: Model) -> float:
    return additive_airplane(m) * parity_airplane(m) * symmetric_airplane(m) / 10_000


def multiplicative_airplane(m: Model) -> float:
    body, wings, _, engines, _ = parts(m)
    worth = {"Transport": 1, "Airliner": 0.5}.get(body, 0.15)
    worth *= {"Transport": 1, "Airliner": 0.4}.get(wings, 0.1)
    return 100 * worth * {"Transport": 1, "Biplane": 0.6, "Fokker": 0.6}.get(engines, 0.25)


def rare_airplane(m: Model) -> float:
    body, _, tail, engines, _ = parts(m)
    return {"Biplane": 100, "Fokker": 60}.get(body, 0) if tail == engines == "Jet" else 0


# Toys, boxes and pavilions -------------------------------------------------------------------------------------------


def symmetric_toy(m: Model) -> float:
    shapes, colours = ([node.branch for node in m.root.find(symbol)] for symbol in ("MASS", "MESH2"))
    return 100 if shapes[0] == shapes[1] else 40 if colours[0] == colours[1] else 0


def sum_toy(m: Model) -> float:
    height = m.draws["h1"] + m.draws["h2"]
    return 100 if height < 4.5 else 40 if height < 5.5 else 0


def sizes(m: Model) -> list[float]:
    return [m.draws[name] for name in ("width", "depth", "height")]


def ratio_limits(m: Model) -> float:
    width, depth, height = sizes(m)
    slenderness = min(height / width, height / depth)
    return 100 if slenderness >= 2 else 50 if slenderness >= 1.4 else 0


def smooth_three_limits(m: Model) -> float:
    width, depth, height = sizes(m)
    return near(width - 3, depth - 5, height - 8, width=10)


def sum_limits(m: Model) -> float:
    return 100 if sum(sizes(m)) >= 20 else 30 if sum(sizes(m)) >= 17 else 0


def gilded(m: Model) -> Counter[str]:
    return Counter(node.symbol for node in m.root.walk() if node.symbol.startswith("Gilded"))


def rare_pavilion(m: Model) -> float:
    found = set(gilded(m))
    if len(found - {"GildedFinial"}) < 4:
        return 0
    return 40 if "GildedFinial" in found else 100


CUBE, TUBE, STAR = range(3)


def levels_toy(m: Model) -> float:
    grades = {
        CUBE: {CUBE: 85, TUBE: 20, STAR: 45},
        TUBE: {CUBE: 0, TUBE: 30, STAR: 100},
        STAR: {CUBE: 10, TUBE: 60, STAR: 5},
    }
    lower, upper = (node.branch for node in m.root.find("MASS"))
    assert lower is not None
    assert upper is not None
    return grades[lower][upper]


def smooth_two_pavilion(m: Model) -> float:
    return near(m.draws["width"] / m.draws["columnHeight"] - 1.618, width=2 * 0.1**2)


def equal_discrete(m: Model) -> float:
    width, depth = steps(m, "width", "depth")
    return 100 if abs(width - depth) < 0.501 else 0


def sum_discrete(m: Model) -> float:
    walk = 2 * sum(steps(m, "width", "depth"))
    return min(max(100 * (20 - walk) / 12, 0), 100)


# Facades -------------------------------------------------------------------------------------------------------------


def count_townhouse(m: Model) -> float:
    curtains = sum(pane.draws["tint"] >= 2 for pane in m.root.find("Glass"))
    return min(max(12.5 * (curtains - 12), 0), 100)


def ratio_arcade(m: Model) -> float:
    columns = m.root.find("ArchedWindowColumn")
    upper_rows = len(columns[0].find("ArchedWindowColumnFloor2"))
    breadth = len(columns) / upper_rows
    return 100 if breadth >= 3 else 40 if breadth >= 2 else 0


def sides_of_door(m: Model) -> tuple[int, int]:
    """Numbers of columns of windows on the left and on the right of the door."""
    columns = [node.symbol for node in m.root.walk() if node.symbol in {"ArchedWindowColumn", "PortalColumn"}]
    door = columns.index("PortalColumn")
    return door, len(columns) - door - 1


def xor_arcade(m: Model) -> float:
    tall = len(m.root.find("ArchedWindowColumn")[0].find("ArchedWindowColumnFloor2")) >= 3
    return 100 if tall ^ (sides_of_door(m)[0] <= 2) else 0


def count_arcade(m: Model) -> float:
    return 100 if len(m.root.find("ArchedWindow")) + len(m.root.find("ArchedWindow2")) >= 12 else 0


def symmetric_arcade(m: Model) -> float:
    left, right = sides_of_door(m)
    return 100 if left == right else 0


def parity_arcade(m: Model) -> float:
    return 100 if len(m.root.find("ArchedWindowColumn")) in {1, 3, 5, 7, 9} else 0


TASTE_TRUTH: dict[str, Callable[[Model], float]] = {
    "additive_airplane": additive_airplane,
    "additive_building": additive_building,
    "additive_furniture": additive_furniture,
    "additive_skyscraper": additive_skyscraper,
    "band_building": band_building,
    "band_skyscraper": band_skyscraper,
    "comparison_building": comparison_building,
    "comparison_limits": lambda m: 100 if sizes(m) == sorted(sizes(m)) else 0,
    "comparison_skyscraper": comparison_skyscraper,
    "comparison_toy": lambda m: 100 if m.draws["h2"] > m.draws["h1"] else 0,
    "conjunction_building": conjunction_building,
    "conjunction_furniture": conjunction_furniture,
    "count_arcade": count_arcade,
    "count_building": count_building,
    "count_skyscraper": lambda m: 100 if len(m.root.find("Fin")) >= 90 else 0,
    "count_townhouse": count_townhouse,
    "equal_building": equal_building,
    "equal_discrete": equal_discrete,
    "equal_skyscraper": equal_skyscraper,
    "equal_skyscraper_frames": equal_skyscraper_frames,
    "factors_airplane": factors_airplane,
    "factors_building": factors_building,
    "factors_furniture": factors_furniture,
    "factors_skyscraper": factors_skyscraper,
    "levels_building": levels_building,
    "levels_furniture": levels_furniture,
    "levels_skyscraper": levels_skyscraper,
    "levels_toy": levels_toy,
    "majority_airplane": majority_airplane,
    "majority_furniture": majority_furniture,
    "multiplicative_airplane": multiplicative_airplane,
    "multiplicative_building": multiplicative_building,
    "multiplicative_furniture": multiplicative_furniture,
    "multiplicative_skyscraper": multiplicative_skyscraper,
    "parity_airplane": parity_airplane,
    "parity_arcade": parity_arcade,
    "parity_pavilion": lambda m: 100 if gilded(m).total() in {1, 3, 5} else 0,
    "parity_skyscraper": parity_skyscraper,
    "partial_building": partial_building,
    "partial_furniture": partial_furniture,
    "partial_skyscraper": partial_skyscraper,
    "rare_airplane": rare_airplane,
    "rare_furniture": rare_furniture,
    "rare_pavilion": rare_pavilion,
    "rare_skyscraper": rare_skyscraper,
    "ratio_arcade": ratio_arcade,
    "ratio_limits": ratio_limits,
    "ratio_skyscraper": ratio_skyscraper,
    "smooth_airplane": lambda m: near(m.draws["lengthScale"] - 1.03, width=0.03**2),
    "smooth_furniture": smooth_furniture,
    "smooth_limits": lambda m: near(m.draws["height"] - 6, width=2 * 1.2**2),
    "smooth_skyscraper": lambda m: near(m.draws["width"] - 44, width=2 * 2.5**2),
    "smooth_three_limits": smooth_three_limits,
    "smooth_two_pavilion": smooth_two_pavilion,
    "smooth_two_toy": lambda m: near(m.draws["h1"] - 2, m.draws["h2"] - 4, width=1.5),
    "sum_discrete": sum_discrete,
    "sum_limits": sum_limits,
    "sum_toy": sum_toy,
    "symmetric_airplane": symmetric_airplane,
    "symmetric_arcade": symmetric_arcade,
    "symmetric_skyscraper": symmetric_skyscraper,
    "symmetric_toy": symmetric_toy,
    "xor_arcade": xor_arcade,
    "xor_building": xor_building,
    "xor_furniture": xor_furniture,
    "xor_skyscraper": xor_skyscraper,
}
