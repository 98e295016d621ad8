"""What the tastes of ``scenarios/tastes/kinds/`` like, told once more: plain Python that walks one derivation tree."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, pairwise

from tests.evaluation.scenarios.taste_truth import branch, parts
from tests.evaluation.scenarios.truth import BLACK, BLUE, LIGHT, Model, blocks, floors, shape

STYLES = ("Georgian", "Tudor", "Chalet", "Palladian", "Gothic", "Modern")

# Terraces ------------------------------------------------------------------------------------------------------------


def paints(m: Model) -> list[int | None]:
    """The paint of each house, from left to right."""
    return [node.branch for node in m.root.find("House")]


def bays(m: Model) -> list[tuple[int | None, int | None]]:
    """The left and the right bay of each house, from left to right."""
    return [(house.choice("LeftBay"), house.choice("RightBay")) for house in m.root.find("House")]


def neighbours_terrace(m: Model) -> float:
    return 0 if any(left == right for left, right in pairwise(paints(m))) else 100


def alternation_terrace(m: Model) -> float:
    found = paints(m)
    return 100 if len(found) >= 3 and len(set(found[::2])) == len(set(found[1::2])) == 1 < len(set(found)) else 0


def mirror_terrace(m: Model) -> float:
    along = [bay for house in bays(m) for bay in house]
    return 100 if along == along[::-1] else 0


def each_terrace(m: Model) -> float:
    return 100 if all(left == right for left, right in bays(m)) else 0


def share_terrace(m: Model) -> float:
    found = paints(m)
    return 100 if 2 * found.count(1) >= len(found) else 0


def length_terrace(m: Model) -> float:
    return 100 if 18 <= len(paints(m)) * m.draws["front"] < 24 else 0


def bands_terrace(m: Model) -> float:
    return 100 if len(m.root.find("Keystone") + m.root.find("BalconyDoor")) in range(4, 9) else 0


# Villas --------------------------------------------------------------------------------------------------------------


def has(m: Model, part: str) -> bool:
    """Whether a villa has a part, whatever its style."""
    return any(m.root.find(style + part) for style in STYLES)


def slender_villas(m: Model) -> float:
    eaves = (branch(m, "Storeys") + 1) * m.draws["storey"] + m.draws["plinth"]
    return 100 if 0.55 <= eaves / m.draws["front"] < 0.8 else 0


def role_villas(m: Model) -> float:
    return 100 * has(m, "Attic")


def sum_villas(m: Model) -> float:
    points = {"Attic": 30, "Columns": 25, "Bows": 20, "Chimney": 15}
    return 10 * (branch(m, "Storeys") == 2) + sum(worth for part, worth in points.items() if has(m, part))


# Skyscrapers, airplanes, buildings, tables ---------------------------------------------------------------------------


def changes_skyscraper(m: Model) -> float:
    shapes = [block for block, _ in blocks(m)]
    return 100 if len(shapes) > 1 and all(low != high for low, high in pairwise(shapes)) else 0


def order_skyscraper(m: Model) -> float:
    return 100 if (BLACK, BLUE) in combinations((glass for _, glass in blocks(m)), 2) else 0


def odd_airplane(m: Model) -> float:
    return 100 if max(map(parts(m).count, parts(m))) == 4 else 0


def xor_airplane(m: Model) -> float:
    _, wings, tail, *_ = (style in {"Biplane", "Fokker"} for style in parts(m))
    return 100 if wings ^ tail else 0


def mixture_airplane(m: Model) -> float:
    return sum(44 / worth * (parts(m).count(style) / 5) ** 2 for style, worth in (("Jet", 1), ("Transport", 2)))


def context_building(m: Model) -> float:
    if floors(m) >= 5:
        return 100 * bool(m.root.find("UpperFloorsOffice"))
    return 100 if floors(m) <= 3 and m.root.find("WallColorOld") else 0


def several_building(m: Model) -> float:
    ground = bool(m.root.find("GroundFloorParis") or m.root.find("GroundFloorPlain"))
    house_walls, house_roof = (not m.root.find(symbol) for symbol in ("WallColorOffice", "RoofOffice"))
    return 100 if (shape(m) == "U") + ground + (floors(m) >= 5) + house_walls + house_roof >= 3 else 0


def vetoes_furniture(m: Model) -> float:
    return 0 if branch(m, "Finish") == LIGHT or m.root.choice("Base") == 2 or m.root.find("Slat") else 60


KINDS_TRUTH: dict[str, Callable[[Model], float]] = {
    taste.__name__: taste
    for taste in (
        *(neighbours_terrace, alternation_terrace, mirror_terrace, each_terrace, share_terrace, length_terrace),
        *(bands_terrace, slender_villas, role_villas, sum_villas, changes_skyscraper, order_skyscraper, odd_airplane),
        *(xor_airplane, mixture_airplane, context_building, several_building, vetoes_furniture),
    )
}
"""What each scenario likes, by its name."""
