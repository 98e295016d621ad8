"""Elements as products of columns and rows, from the top down: rare elements lie over common ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from grammarlab.facade.layers.inference.covers import Place, Product, products
from grammarlab.facade.layers.inference.elements import Interval, LabelledRectangles
from grammarlab.facade.layers.inference.strips import MOST_CELLS
from grammarlab.facade.tree import Ints, X, Y


def layering(elements: LabelledRectangles, most: int) -> list[Product]:
    """Products that show each element, from the top down.

    Cells of a product without an element of its own are hidden by the products before it. So the two halves of a band
    beside a portal are one band behind it.

    Args:
        elements: elements of a facade.
        most: largest number of products; of more, those of the largest elements are kept.
    """
    often, area = Counter(elements.labels), dict[str, float]()
    for label, box in zip(elements.labels, elements.boxes.tolist(), strict=True):
        area[label] = area.get(label, 0.0) + _area(elements, box)
    found: list[Product] = []
    above = np.zeros((0, 4), dtype=np.int64)
    for label in sorted(often, key=lambda name: (often[name], area[name], name)):
        own = elements.boxes[[each == label for each in elements.labels]]
        places = _bounded(_joined(elements, own, above))
        found += products(label, places, _Hidden(above), most)
        above = np.concatenate([above, own])
    if len(found) <= most:
        return found
    kept = sorted(found, key=lambda each: -_shown(elements, each))[:most]
    return [each for each in found if each in kept]


class _Hidden:
    """Tests whether a place is hidden by boxes that do not overlap."""

    def __init__(self, boxes: Ints) -> None:
        self.boxes = boxes

    def __call__(self, across: Interval, up: Interval) -> bool:
        low = np.maximum(self.boxes[:, :2], (across[0], up[0]))
        high = np.minimum(self.boxes[:, 2:], (across[1], up[1]))
        covered = np.maximum(high - low, 0).prod(axis=1).sum()
        return bool(covered == (across[1] - across[0]) * (up[1] - up[0]))


def _area(elements: LabelledRectangles, box: Sequence[int]) -> float:
    left, bottom, right, top = box
    return float(
        (elements.lines[X][right] - elements.lines[X][left]) * (elements.lines[Y][top] - elements.lines[Y][bottom])
    )


def _shown(elements: LabelledRectangles, product: Product) -> float:
    return sum(_area(elements, (across[0], up[0], across[1], up[1])) for across in product.across for up in product.up)


def _joined(elements: LabelledRectangles, own: Ints, above: Ints) -> list[Place]:
    """Places of boxes; neighbours in a lane with boxes above between them are joined, if others are as long."""
    places = [((left, right), (bottom, top)) for left, bottom, right, top in own.tolist()]
    for axis in (X, Y):
        known = {(0, len(elements.lines[axis]) - 1)} | {
            (int(low), int(high)) for low, high in elements.boxes[:, axis::2].tolist()
        }
        lanes: dict[Interval, list[Interval]] = {}
        for place in places:
            lanes.setdefault(place[1 - axis], []).append(place[axis])
        places = []
        for lane, intervals in lanes.items():
            for each in _chained(sorted(intervals), lane, above, axis, known):
                places.append((each, lane) if axis == X else (lane, each))
    return places


def _chained(intervals: list[Interval], lane: Interval, above: Ints, axis: int, known: set[Interval]) -> list[Interval]:
    """Intervals of a lane; chains that end at the same lines as other intervals are joined."""
    chains: list[list[Interval]] = [[intervals[0]]]
    across = above[(above[:, 1 - axis] <= lane[0]) & (above[:, 3 - axis] >= lane[1])]
    for before, after in pairwise(intervals):
        between = (across[:, axis] <= before[1]) & (across[:, axis + 2] >= after[0]) & (before[1] < after[0])
        if between.any():
            chains[-1].append(after)
        else:
            chains.append([after])
    found: list[Interval] = []
    for chain in chains:
        whole = chain[0][0], chain[-1][1]
        found += [whole] if whole in known else chain
    return found


def _bounded(places: list[Place]) -> list[Place]:
    """The places in the columns and rows with the most elements, if there are too many."""
    for axis in (X, Y):
        often = Counter(place[axis] for place in places)
        if len(often) > MOST_CELLS:
            kept = {interval for interval, _ in often.most_common(MOST_CELLS)}
            places = [place for place in places if place[axis] in kept]
    return places
