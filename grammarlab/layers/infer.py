"""From a facade to a design of layers whose layout is that facade, and the similarity of both.

Elements are products of columns and rows, from the top down: rare elements lie over common ones. Symbols get single
letters, capitals for elements. Facades are similar by the area with equal labels, and by matched elements.
"""

from __future__ import annotations

import collections
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count, pairwise
from string import ascii_lowercase, ascii_uppercase

import numpy as np
import shapely

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.layers.axis_patterns import Item, StripPatterns, patterns_of
from grammarlab.layers.covers import GridCell, Interval, LabelledRectangles, Product, backdrop_of, elements_of, products
from grammarlab.layers.design import WILDCARD, Counter, Design, Layer, Shape, Symbol
from grammarlab.layers.file import MAX_SIZE_M, MOST_LAYERS
from grammarlab.layers.patterns import LayerPattern, Linear, parse_pattern
from grammarlab.layers.strip_words import MOST_CELLS, Key, StripAssignment, assign_strips

_MATCH_IOU = 0.5
"""Rectangles whose IoU is above this value match; among rectangles without overlaps, at most one does."""


@dataclass(frozen=True, slots=True)
class Reconstruction:
    """Similarity of a facade and an original of the same size."""

    area: float
    """0 to 1, share of the original's area with equal labels."""
    iou: float
    """0 to 1, intersection over union, mean over elements: each with the element of its label with the largest IoU."""
    quality: float
    """0 to 1, panoptic quality: sum of the IoU of matched elements, over the mean number of elements of both."""
    elements: int
    """Number of elements of the original: leaves that are not its wall."""
    other_elements: int
    """Number of elements of the other facade."""


def compare(original: Facade, other: Facade) -> Reconstruction:
    """Similarity of a facade and an original."""
    boxes, others = _boxes(original), _boxes(other)
    pairs = shapely.STRtree(shapely.box(*others.T)).query(shapely.box(*boxes.T))
    first, second = boxes[pairs[0]], others[pairs[1]]
    low, high = np.maximum(first[:, :2], second[:, :2]), np.minimum(first[:, 2:], second[:, 2:])
    shared = np.maximum(high - low, 0.0).prod(axis=1)
    names = [
        np.array([facade.name_of(leaf) for leaf in facade.leaves.tolist()], dtype=object)
        for facade in (original, other)
    ]
    same = names[0][pairs[0]] == names[1][pairs[1]]
    backdrop = backdrop_of(original)
    element, other_element = (labels != backdrop for labels in names)
    union = (first[:, 2:] - first[:, :2]).prod(axis=1) + (second[:, 2:] - second[:, :2]).prod(axis=1) - shared
    iou = np.where(same, shared / union, 0.0)
    best = np.zeros(len(boxes))
    np.maximum.at(best, pairs[0], iou)
    best = best[element]
    matched = float(best[best > _MATCH_IOU].sum())
    total = 0.5 * float(element.sum() + other_element.sum())
    return Reconstruction(
        area=min(float(shared[same].sum()) / (original.width * original.height), 1.0),
        iou=float(best.mean()) if len(best) else 1.0,
        quality=matched / total if total else 1.0,
        elements=int(element.sum()),
        other_elements=int(other_element.sum()),
    )


def _boxes(facade: Facade) -> Floats:
    """[L, 4] left, bottom, right, top of leaves."""
    low = facade.position[facade.leaves]
    return np.concatenate([low, low + facade.size[facade.leaves]], axis=1)[:, [X, Y, 2, 3]]


_COUNTERS = ("k", "n")
"""Counters of x and y."""
_PATTERNS = ("bays", "floors")
"""Names of patterns along x and y."""
_WHOLE_PATTERNS = ("all across", "all up")
"""Names of patterns of one letter without a size, along x and y."""
_MAX_LABEL_LENGTH = 200
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
    if max(facade.width, facade.height) > MAX_SIZE_M:
        raise FacadeError(
            f"expected a facade of at most {MAX_SIZE_M:,.0f} m per side, found {facade.width:g} x {facade.height:g} m."
        )
    elements = elements_of(facade, tolerance)
    products = _layering(elements, MOST_LAYERS - 1)
    weight = [len(product.across) * len(product.up) for product in products]
    names = _SymbolNames()
    axes = []
    for axis, sets in ((X, [product.across for product in products]), (Y, [product.up for product in products])):
        assignment = assign_strips(sets, weight, elements.lines[axis], tolerance)
        axis_model = _Axis(
            axis=axis, assignment=assignment, strip_patterns=patterns_of(assignment, _COUNTERS[axis]), names=names
        )
        axis_model.name([product.label for product in products])
        axes.append(axis_model)
    layers = [_layer(number, products, axes) for number in range(len(products))]
    if elements.backdrop is not None or not layers:
        layers.append(_everywhere(elements.backdrop or "", axes))
    patterns: dict[str, LayerPattern] = {}
    symbols: dict[str, Symbol] = {}
    used = {name for layer in layers for name in layer.patterns}
    for axis_model in axes:
        patterns |= {name: pattern for name, pattern in axis_model.patterns().items() if name in used}
        symbols |= axis_model.symbols
    used_symbols = {name for pattern in patterns.values() for name in pattern.symbols()}
    counters = dict.fromkeys(name for pattern in patterns.values() for name in pattern.counters())
    return Design(
        title=title,
        width=facade.width,
        height=facade.height,
        symbols={name: symbol for name, symbol in symbols.items() if name in used_symbols},
        counters={name: Counter(name) for name in counters},
        patterns=patterns,
        layers=tuple(layers),
    )


def _layering(elements: LabelledRectangles, most: int) -> list[Product]:
    """Products that show each element, from the top down.

    Cells of a product without an element of its own are hidden by the products before it. So the two halves of a band
    beside a portal are one band behind it.

    Args:
        elements: elements of a facade.
        most: largest number of products; of more, those of the largest elements are kept.
    """
    counts, area = collections.Counter(elements.labels), dict[str, float]()
    for label, box in zip(elements.labels, elements.boxes.tolist(), strict=True):
        area[label] = area.get(label, 0.0) + _area(elements, box)
    result: list[Product] = []
    above = np.zeros((0, 4), dtype=np.int64)
    for label in sorted(counts, key=lambda name: (counts[name], area[name], name)):
        label_boxes = elements.boxes[[name == label for name in elements.labels]]
        cells = _bounded(_joined(elements, label_boxes, above))
        result += products(label, cells, _Hidden(above), most)
        above = np.concatenate([above, label_boxes])
    if len(result) <= most:
        return result
    largest = sorted(result, key=lambda product: -_visible_area(elements, product))[:most]
    return [product for product in result if product in largest]


def _area(elements: LabelledRectangles, box: Sequence[int]) -> float:
    x_low, y_low, x_high, y_high = box
    x_lines, y_lines = elements.lines
    return float((x_lines[x_high] - x_lines[x_low]) * (y_lines[y_high] - y_lines[y_low]))


def _bounded(cells: list[GridCell]) -> list[GridCell]:
    """The cells in the columns and rows with the most elements, if there are too many."""
    for axis in (X, Y):
        counts = collections.Counter(cell[axis] for cell in cells)
        if len(counts) > MOST_CELLS:
            frequent = {interval for interval, _ in counts.most_common(MOST_CELLS)}
            cells = [cell for cell in cells if cell[axis] in frequent]
    return cells


def _joined(elements: LabelledRectangles, boxes: Ints, above: Ints) -> list[GridCell]:
    """Cells of boxes; neighbours in a lane with boxes above between them are joined, if others are as long."""
    cells = [((x_low, x_high), (y_low, y_high)) for x_low, y_low, x_high, y_high in boxes.tolist()]
    for axis in (X, Y):
        used_intervals = {(0, len(elements.lines[axis]) - 1)} | {
            (int(low), int(high)) for low, high in elements.boxes[:, axis::2].tolist()
        }
        lanes: dict[Interval, list[Interval]] = {}
        for cell in cells:
            lanes.setdefault(cell[1 - axis], []).append(cell[axis])
        cells = []
        for lane, intervals in lanes.items():
            for interval in _chained(sorted(intervals), lane, above, axis, used_intervals):
                cells.append((interval, lane) if axis == X else (lane, interval))
    return cells


def _chained(
    intervals: list[Interval], lane: Interval, above: Ints, axis: int, used_intervals: set[Interval]
) -> list[Interval]:
    """Intervals of a lane; chains that end at the same lines as other intervals are joined."""
    chains: list[list[Interval]] = [[intervals[0]]]
    across = above[(above[:, 1 - axis] <= lane[0]) & (above[:, 3 - axis] >= lane[1])]
    for before, after in pairwise(intervals):
        between = (across[:, axis] <= before[1]) & (across[:, axis + 2] >= after[0]) & (before[1] < after[0])
        if between.any():
            chains[-1].append(after)
        else:
            chains.append([after])
    joined: list[Interval] = []
    for chain in chains:
        whole = chain[0][0], chain[-1][1]
        joined += [whole] if whole in used_intervals else chain
    return joined


class _Hidden:
    """Tests whether a cell is hidden by boxes that do not overlap."""

    def __init__(self, boxes: Ints) -> None:
        self.boxes = boxes

    def __call__(self, across: Interval, up: Interval) -> bool:
        low = np.maximum(self.boxes[:, :2], (across[0], up[0]))
        high = np.minimum(self.boxes[:, 2:], (across[1], up[1]))
        covered = np.maximum(high - low, 0).prod(axis=1).sum()
        return bool(covered == (across[1] - across[0]) * (up[1] - up[0]))


def _visible_area(elements: LabelledRectangles, product: Product) -> float:
    return sum(_area(elements, (across[0], up[0], across[1], up[1])) for across in product.across for up in product.up)


class _SymbolNames:
    """Unused letters; after all of them, letters with primes."""

    def __init__(self) -> None:
        self.used: set[str] = set()

    def new(self, label: str) -> str:
        """A capital for an element, preferably the first letter of its label; a small letter for no label."""
        name = next(candidate for candidate in _candidates(label) if candidate not in self.used)
        self.used.add(name)
        return name


def _candidates(label: str) -> Iterator[str]:
    initials = [word[0].upper() for word in label.split() if word[0].isalpha() and len(word[0].upper()) == 1]
    letters = [*initials, *ascii_uppercase] if label else ascii_lowercase
    for primes in count():
        yield from (letter + "'" * primes for letter in letters)


@dataclass
class _Axis:
    """Patterns and symbols of an axis."""

    axis: int
    assignment: StripAssignment
    strip_patterns: StripPatterns
    names: _SymbolNames
    symbol_of: dict[Key, str] = field(default_factory=dict)
    """Symbols by the properties that their letters share."""
    symbols: dict[str, Symbol] = field(default_factory=dict)
    whole: str = ""
    """The symbol of full length."""

    def name(self, labels: Sequence[str]) -> None:
        """Give symbols their names and sizes, in the order of the patterns."""
        for strip in self.strip_patterns.strips.strips:
            for key in strip.keys:
                if key not in self.symbol_of:
                    self.symbol_of[key] = self.names.new(labels[min(key[2])] or "element" if key[2] else "")
        for key, name in self.symbol_of.items():
            size = (
                None if key in self.strip_patterns.unsized else float(f"{self.strip_patterns.strips.sizes[key[1]]:.9g}")
            )
            self.symbols[name] = Symbol(name, size)
        self.whole = self.names.new("ZY"[self.axis])
        self.symbols[self.whole] = Symbol(self.whole)

    def pattern_of(self, product: int) -> str:
        """Name of the pattern of a product."""
        return self.pattern_name(self.assignment.strip[product])

    def pattern_name(self, strip: int) -> str:
        """Name of the pattern of a strip; strip -1 is the pattern of one letter."""
        if strip < 0:
            return _WHOLE_PATTERNS[self.axis]
        return _PATTERNS[self.axis] + (f" {strip + 1}" if strip else "")

    def mask(self, product: int) -> frozenset[str] | None:
        """Visible symbols of a product."""
        strip = self.assignment.strip[product]
        if strip < 0:
            return None
        keys = self.strip_patterns.strips.strips[strip].keys
        visible = {self.symbol_of[key] for key in keys if product in key[2]}
        return None if visible == {self.symbol_of[key] for key in keys} else frozenset(visible)

    def patterns(self) -> Mapping[str, LayerPattern]:
        """All patterns by name."""
        texts = {
            self.pattern_name(strip): "".join(self._item(item) for item in items)
            for strip, items in enumerate(self.strip_patterns.items)
        }
        texts[self.pattern_name(-1)] = self.whole
        return {name: parse_pattern(text) for name, text in texts.items()}

    def _item(self, item: Item) -> str:
        text = "".join(self.symbol_of[key] for key in item.keys)
        if not item.count.terms:
            return text
        return (text if len(item.keys) == 1 else f"({text})") + _exponent(item.count)


def _exponent(count: Linear) -> str:
    ((name, factor),) = count.terms
    text = (str(factor) if factor > 1 else "") + name + (f" + {count.constant}" if count.constant else "")
    return f"^{text}" if len(text) == 1 else f"^{{{text}}}"


def _layer(number: int, products: Sequence[Product], axes: Sequence[_Axis]) -> Layer:
    """The layer of a product; each strip is its own group, since its symbols and counters keep it in step."""
    label = products[number].label
    before = sum(other.label == label for other in products[:number])
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


def _printable(text: str) -> str:
    """A label with characters that a design allows."""
    return "".join(character if character.isprintable() else " " for character in text)[:_MAX_LABEL_LENGTH]


def _everywhere(label: str, axes: Sequence[_Axis]) -> Layer:
    """A layer that is one shape over the whole canvas."""
    patterns = (axes[X].pattern_name(-1), axes[Y].pattern_name(-1))
    shapes = {(WILDCARD, WILDCARD): Shape(_printable(label))}
    return Layer(name=_printable(label) or "wall", patterns=patterns, groups=patterns, shapes=shapes)
