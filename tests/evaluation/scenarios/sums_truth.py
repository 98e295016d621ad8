"""What the tastes of ``scenarios/tastes/sums/`` like, told once more: plain Python on derivation trees."""

from __future__ import annotations

from collections.abc import Callable

from tests.evaluation.scenarios.taste_truth import branch, sizes
from tests.evaluation.scenarios.truth import Model


def allowance_building(m: Model) -> float:
    height = m.draws["groundHeight"] + (branch(m, "Floors") + 1) * m.draws["floorHeight"]
    wings = sum(gift for symbol, gift in (("MassL", 3), ("MassU", 6)) if m.root.find(symbol))
    return 100 if abs(height - 0.6 * m.draws.get("width", 0) - wings) <= 1.5 else 0


def girth_limits(m: Model) -> float:
    width, depth, height = sizes(m)
    return 100 if 24 <= height + 2 * (width + depth) <= 28 else 0


def legs_furniture(m: Model) -> float:
    apron, top, shelf = (m.draws.get(name, 0) for name in ("apronHeight", "topThickness", "stretcherHeight"))
    return 100 if 0.105 <= apron + 2 * top - shelf / 2 <= 0.12 else 0


def points_quarter(m: Model) -> float:
    floors = (2, 3, 5, 6, 9, 14, 20)[branch(m, "Lot")]
    prices = {"WallsOffice": 5, "GroundFloorOffice": 4, "RoofParis": 2}
    points = 2 + sum(price * len(m.root.find(symbol)) for symbol, price in prices.items())
    return 100 if points - 4 <= floors <= points else 0


def trim_airplane(m: Model) -> float:
    span, length, tail = (m.draws[name] for name in ("spanScale", "lengthScale", "tailScale"))
    return 100 if abs(2 * span - length - tail) <= 0.04 else 0


SUMS_TRUTH: dict[str, Callable[[Model], float]] = {
    taste.__name__: taste for taste in (allowance_building, girth_limits, legs_furniture, points_quarter, trim_airplane)
}
"""What each scenario likes, by its name."""
