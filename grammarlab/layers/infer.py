"""From a facade to a design of layers whose layout is that facade.

Elements as products of columns and rows, from the top down: rare elements lie over common ones.

Names of inferred symbols: single letters, capitals for elements.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count, pairwise
from string import ascii_lowercase, ascii_uppercase

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import Facade, Ints, X, Y
from grammarlab.layers.axis_patterns import Item, StripPatterns, patterns_of
from grammarlab.layers.covers import Interval, LabelledRectangles, Place, Product, elements_of, products
from grammarlab.layers.design import WILDCARD, Design, Layer, Shape, Symbol
from grammarlab.layers.design import Counter as PatternCounter
from grammarlab.layers.file import LARGEST, MOST_LAYERS
from grammarlab.layers.patterns import LayerPattern, Linear, parse_pattern
from grammarlab.layers.strip_words import MOST_CELLS, Key, Places, places_of


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


class SymbolNames:
    """Unused letters; after all of them, letters with primes."""

    def __init__(self) -> None:
        self.used: set[str] = set()

    def new(self, label: str) -> str:
        """A capital for an element, preferably the first letter of its label; a small letter for no label."""
        name = next(each for each in _tried(label) if each not in self.used)
        self.used.add(name)
        return name


def _tried(label: str) -> Iterator[str]:
    initials = [word[0].upper() for word in label.split() if word[0].isalpha() and len(word[0].upper()) == 1]
    letters = [*initials, *ascii_uppercase] if label else ascii_lowercase
    for primes in count():
        yield from (letter + "'" * primes for letter in letters)


_COUNTERS = ("k", "n")
"""Counters of x and y."""
_PATTERNS = ("bays", "floors")
_WHOLE = ("all across", "all up")
"""Patterns of one letter without a size."""
_LONGEST = 200
"""Largest number of characters of a label."""


def infer(facade: Facade, tolerance: float, title: str = "") -> Design:
    """A design whose layout on the canvas of the facade is that facade, as closely as patterns allow.

    Args:
        facade: the facade.
        tolerance: largest difference of sides in line and of equal sizes, metres.
        title: title of the design.

    Raises:
        FacadeError: If the facade is larger than the largest canvas.
    """
    if max(facade.width, facade.height) > LARGEST:
        raise FacadeError(
            f"expected a facade of at most {LARGEST:,.0f} m per side, found {facade.width:g} x {facade.height:g} m."
        )
    elements = elements_of(facade, tolerance)
    shown = layering(elements, MOST_LAYERS - 1)
    weight = [len(each.across) * len(each.up) for each in shown]
    names = SymbolNames()
    axes = []
    for axis, sets in ((X, [each.across for each in shown]), (Y, [each.up for each in shown])):
        places = places_of(sets, weight, elements.lines[axis], tolerance)
        made = _Axis(axis=axis, places=places, made=patterns_of(places, _COUNTERS[axis]), names=names)
        made.name([each.label for each in shown])
        axes.append(made)
    layers = [_layer(number, shown, axes) for number in range(len(shown))]
    if elements.backdrop is not None or not layers:
        layers.append(_everywhere(elements.backdrop or "", axes))
    patterns: dict[str, LayerPattern] = {}
    symbols: dict[str, Symbol] = {}
    used = {name for layer in layers for name in layer.patterns}
    for each in axes:
        patterns |= {name: pattern for name, pattern in each.patterns().items() if name in used}
        symbols |= each.symbols
    there = {name for pattern in patterns.values() for name in pattern.symbols()}
    counters = dict.fromkeys(name for pattern in patterns.values() for name in pattern.counters())
    return Design(
        title=title,
        width=facade.width,
        height=facade.height,
        symbols={name: symbol for name, symbol in symbols.items() if name in there},
        counters={name: PatternCounter(name) for name in counters},
        patterns=patterns,
        layers=tuple(layers),
    )


@dataclass
class _Axis:
    """Patterns and symbols of an axis."""

    axis: int
    places: Places
    made: StripPatterns
    names: SymbolNames
    of: dict[Key, str] = field(default_factory=dict)
    """Symbols by the properties that their letters share."""
    symbols: dict[str, Symbol] = field(default_factory=dict)
    whole: str = ""
    """The symbol of full length."""

    def name(self, labels: Sequence[str]) -> None:
        """Give symbols their names and sizes, in the order of the patterns."""
        for strip in self.made.strips.strips:
            for key in strip.keys:
                if key not in self.of:
                    self.of[key] = self.names.new(labels[min(key[2])] or "element" if key[2] else "")
        for key, name in self.of.items():
            size = None if key in self.made.unsized else float(f"{self.made.strips.sizes[key[1]]:.9g}")
            self.symbols[name] = Symbol(name, size)
        self.whole = self.names.new("ZY"[self.axis])
        self.symbols[self.whole] = Symbol(self.whole)

    def pattern_of(self, product: int) -> str:
        """Name of the pattern of a product."""
        return self.pattern_name(self.places.of[product])

    def pattern_name(self, strip: int) -> str:
        """Name of the pattern of a strip; strip -1 is the pattern of one letter."""
        if strip < 0:
            return _WHOLE[self.axis]
        return _PATTERNS[self.axis] + (f" {strip + 1}" if strip else "")

    def mask(self, product: int) -> frozenset[str] | None:
        """Visible symbols of a product."""
        strip = self.places.of[product]
        if strip < 0:
            return None
        there = self.made.strips.strips[strip].keys
        shown = {self.of[key] for key in there if product in key[2]}
        return None if shown == {self.of[key] for key in there} else frozenset(shown)

    def patterns(self) -> Mapping[str, LayerPattern]:
        """All patterns by name."""
        texts = {
            self.pattern_name(at): "".join(self._item(item) for item in items)
            for at, items in enumerate(self.made.items)
        }
        texts[self.pattern_name(-1)] = self.whole
        return {name: parse_pattern(text) for name, text in texts.items()}

    def _item(self, item: Item) -> str:
        text = "".join(self.of[key] for key in item.keys)
        if not item.count.terms:
            return text
        return (text if len(item.keys) == 1 else f"({text})") + _exponent(item.count)


def _exponent(count: Linear) -> str:
    ((name, factor),) = count.terms
    text = (str(factor) if factor > 1 else "") + name + (f" + {count.constant}" if count.constant else "")
    return f"^{text}" if len(text) == 1 else f"^{{{text}}}"


def _layer(number: int, shown: Sequence[Product], axes: Sequence[_Axis]) -> Layer:
    """The layer of a product; each strip is its own group, since its symbols and counters keep it in step."""
    label = shown[number].label
    before = sum(each.label == label for each in shown[:number])
    name = (label or "element") + (f" {before + 1}" if before else "")
    x, y = axes
    patterns = (x.pattern_of(number), y.pattern_of(number))
    return Layer(
        name=_printable(name),
        patterns=patterns,
        groups=patterns,
        masks=(x.mask(number), y.mask(number)),
        shapes={(WILDCARD, WILDCARD): Shape(_printable(label))},
    )


def _everywhere(label: str, axes: Sequence[_Axis]) -> Layer:
    """A layer that is one shape over the whole canvas."""
    patterns = (axes[X].pattern_name(-1), axes[Y].pattern_name(-1))
    shapes = {(WILDCARD, WILDCARD): Shape(_printable(label))}
    return Layer(name=_printable(label) or "wall", patterns=patterns, groups=patterns, shapes=shapes)


def _printable(text: str) -> str:
    """A label with characters that a design allows."""
    return "".join(each if each.isprintable() else " " for each in text)[:_LONGEST]
