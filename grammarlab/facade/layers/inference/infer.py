"""From a facade to a design of layers whose layout is that facade."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from grammarlab.errors import FacadeError
from grammarlab.facade.layers.designs.design import WILDCARD, Counter, Design, Layer, Shape, Symbol
from grammarlab.facade.layers.designs.file import LARGEST, MOST_LAYERS
from grammarlab.facade.layers.designs.parsing import parse_pattern
from grammarlab.facade.layers.designs.patterns import LayerPattern, Linear
from grammarlab.facade.layers.inference.covers import Product
from grammarlab.facade.layers.inference.elements import elements_of
from grammarlab.facade.layers.inference.layering import layering
from grammarlab.facade.layers.inference.naming import SymbolNames
from grammarlab.facade.layers.inference.patterns import Item, StripPatterns, patterns_of
from grammarlab.facade.layers.inference.strips import Key, Places, places_of
from grammarlab.facade.tree import Facade, X, Y

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
        counters={name: Counter(name) for name in counters},
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
