"""What the tastes of ``scenarios/tastes/invented/`` like, told once more: plain Python on derivation trees."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby

from tests.evaluation.scenarios.kinds_truth import has, paints
from tests.evaluation.scenarios.taste_truth import branch, mast, parts, sizes
from tests.evaluation.scenarios.truth import Model, blocks

# Terraces and villas -------------------------------------------------------------------------------------------------


def run_terrace(m: Model) -> float:
    return 100 if max(len(list(run)) for _, run in groupby(paints(m))) >= 3 else 0


def budget_villas(m: Model) -> float:
    area = m.draws["front"] * m.draws["depth"] * (branch(m, "Storeys") + 1)
    price = (1.9, 2.2, 1.7, 2.9, 2.5, 1.5)[branch(m, "Villa")]
    extras = 60 * has(m, "Attic") + 35 * has(m, "Columns") + 20 * has(m, "Chimney")
    return 100 if area >= 200 and price * area + extras <= 650 else 0


# Skyscrapers ---------------------------------------------------------------------------------------------------------


def mast_skyscraper(m: Model) -> float:
    names = ["firstHeight", "secondHeight", "thirdHeight", "fourthHeight"][: len(blocks(m))]
    height = sum(m.draws[name] for name in names) if len(names) > 1 else m.draws["soloHeight"]
    return 100 if mast(m) and 0.167 <= m.draws["mastHeight"] / height <= 0.25 else 0


DARK_TO_LIGHT = (0, 3, 1, 2, 4, 5)
"""Black, bronze, blue, green, coated and clear glass."""


def gradation_skyscraper(m: Model) -> float:
    tones = [DARK_TO_LIGHT.index(glass) for _, glass in blocks(m)]
    return 100 if tones == sorted(tones) and len(set(tones)) >= 2 else 0


# Airplanes and buildings ---------------------------------------------------------------------------------------------


def diversity_airplane(m: Model) -> float:
    return 100 if len(set(parts(m))) >= 4 else 0


def styles(m: Model, *named: str) -> list[str]:
    """The styles of some parts of a building."""
    there = {node.symbol for node in m.root.walk()}
    found = [[style for style in ("Office", "Paris", "Plain", "Old") if part + style in there] for part in named]
    return [style for (style,) in found]


def contrast_quarter(m: Model) -> float:
    ground, *above = styles(m, "GroundFloor", "Walls", "UpperFloors", "Roof")
    return 100 if len(set(above)) == 1 and ground not in above else 0


GREEN, BLUE, GREY = range(3)
CHART = {
    "Office": {1: {GREY}},
    "Paris": {0: {BLUE, GREY}, 1: {BLUE, GREY}, 2: {BLUE, GREY}},
    "Plain": {1: {GREY}, 2: {GREEN}, 3: {BLUE}},
    "Old": {0: {GREEN}, 1: {GREEN}, 2: {GREY}},
}
"""Colours of joinery that go with a colour of the walls, by the style of the walls."""


def pairs_building(m: Model) -> float:
    (style,) = styles(m, "WallColor")
    colour = int(m.draws[f"{style.lower()}Color"])
    return 100 if m.draws["joineryColor"] in CHART[style].get(colour, set()) else 0


# Boxes, pavilions, tables --------------------------------------------------------------------------------------------


def compact_limits(m: Model) -> float:
    return 100 if all(large <= 1.8 * small for small in sizes(m) for large in sizes(m)) else 0


def extremes_pavilion(m: Model) -> float:
    slenderness = (m.draws["columnHeight"] + m.draws["roofHeight"]) / m.draws["width"]
    return 0 if 0.78 <= slenderness <= 1.06 else 100


HIGH_APRON = 3
"""Branch of Top whose edge hangs below it by the height of the apron."""


def clearance_furniture(m: Model) -> float:
    below_top = m.draws["tableHeight"] - m.draws["topThickness"]
    knees = below_top - m.draws["apronHeight"] * (branch(m, "Top") == HIGH_APRON)
    high_shelf = branch(m, "Under") == 1 and m.draws["shelfLevel"] * below_top > 0.22
    return 100 if knees >= 0.70 and not high_shelf else 0


INVENTED_TRUTH: dict[str, Callable[[Model], float]] = {
    taste.__name__: taste
    for taste in (
        *(run_terrace, budget_villas, mast_skyscraper, gradation_skyscraper, diversity_airplane, contrast_quarter),
        *(pairs_building, compact_limits, extremes_pavilion, clearance_furniture),
    )
}
"""What each scenario likes, by its name."""
