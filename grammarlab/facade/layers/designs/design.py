"""A design: layers of patterns over symbols with preferred sizes, for a canvas of any size (paper 003, section 3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from grammarlab.facade.layers.designs.patterns import LayerPattern, Reflection, Slots
from grammarlab.facade.layers.letters import Letter, Word
from grammarlab.facade.layers.weights import Weights

WILDCARD = "*"
"""Matches any symbol in the table of shapes."""


@dataclass(frozen=True, slots=True)
class Symbol:
    """Properties of all letters of one name."""

    name: str
    size: float | None = None
    """Preferred size, metres, > 0; None: the letter takes the remaining length."""
    opaque: bool = True
    """Whether it hides the layers below it."""
    attached: bool = False
    """Whether its neighbours in a word stay adjacent to it."""
    unoccludable: bool = False
    """Whether no element that covers only a part may lie over it."""
    transparent: bool = False
    """Whether it is never visible."""


@dataclass(frozen=True, slots=True)
class Counter:
    """A number of copies, with one value in all patterns."""

    name: str
    least: int | None = None
    """None: the least number from 0 for which no `X^{k - 1}` has a negative number of copies."""
    most: int | None = None
    """None: limited by the canvas only."""
    reflection: Reflection = "inner"
    """Meaning of a negative number of copies."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A visible shape at a crossing of a horizontal and a vertical symbol."""

    label: str
    """Label, which determines the look (`grammarlab.facade.looks`)."""
    depth: float = 0.0
    """Additional depth beyond that of its label, metres."""
    inset: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    """Distances from the left, bottom, right and top of its cell, metres; smaller in small cells."""
    frame: str = ""
    """Label of its surroundings in the cell; empty: the layers below are visible there."""


Shapes = Mapping[tuple[str, str], Shape]
"""Shapes by horizontal and vertical symbol; each may be `WILDCARD`."""


@dataclass(frozen=True, slots=True)
class Layer:
    """A horizontal pattern by a vertical one. Pairs are in the order x, y."""

    name: str
    patterns: tuple[str, str]
    """Names of patterns of the design."""
    groups: tuple[str, str] = ("", "")
    """Alignment groups: only layers of one group are aligned."""
    masks: tuple[frozenset[str] | None, frozenset[str] | None] = (None, None)
    """Visible symbols; None for all."""
    on: bool = True
    depth: float = 0.0
    """Additional depth of its shapes, metres."""
    shapes: Shapes = field(default_factory=dict)
    """Shapes that take precedence over those of the design."""


@dataclass(frozen=True, slots=True)
class Design:
    """Layers that fit each other on a canvas."""

    title: str
    width: float
    """Width of the canvas, metres."""
    height: float
    """Height of the canvas, metres."""
    symbols: Mapping[str, Symbol]
    counters: Mapping[str, Counter]
    patterns: Mapping[str, LayerPattern]
    layers: tuple[Layer, ...]
    """Layers from the topmost down."""
    shapes: Shapes = field(default_factory=dict)
    weights: Weights = field(default_factory=Weights)
    """Weights of the solver's energy."""
    overhang: bool = False
    """Whether letters that are not opaque keep their sizes, centred in their columns (supplement 002, section 3.4)."""

    @property
    def visible_layers(self) -> tuple[Layer, ...]:
        """The layers that are switched on, from the topmost down."""
        return tuple(layer for layer in self.layers if layer.on)

    def word(self, slots: Slots) -> Word:
        """The letters of a word."""
        return tuple(
            Letter(
                symbol=slot.symbol,
                size=symbol.size,
                opaque=symbol.opaque and not (slot.placeholder or symbol.transparent),
                attached=symbol.attached,
                unoccludable=symbol.unoccludable,
                transparent=slot.placeholder or symbol.transparent,
                mirrored=slot.mirrored,
            )
            for slot in slots
            for symbol in (self.symbols[slot.symbol],)
        )

    def covering(self, layer: Layer, axis: int) -> frozenset[str]:
        """Symbols of a layer that are visible along the whole other axis, and hide what is below them there."""
        if not self._seen(layer, 1 - axis) >= set(self.patterns[layer.patterns[1 - axis]].symbols()):
            return frozenset()
        return self._seen(layer, axis)

    def _seen(self, layer: Layer, axis: int) -> frozenset[str]:
        """Opaque symbols of a layer that its mask and its pattern leave visible."""
        pattern, mask = self.patterns[layer.patterns[axis]], layer.masks[axis]
        return frozenset(
            name
            for name in pattern.symbols()
            if (mask is None or name in mask)
            and self.symbols[name].opaque
            and not (self.symbols[name].transparent or name in pattern.placeholders())
        )

    def shape(self, layer: Layer, across: str, up: str) -> Shape:
        """The shape of a layer at the crossing of two symbols; its default label has both names."""
        for shapes in (layer.shapes, self.shapes):
            for key in ((across, up), (across, WILDCARD), (WILDCARD, up), (WILDCARD, WILDCARD)):
                if key in shapes:
                    return shapes[key]
        return Shape(f"{across} {up}")


def word_text(word: Word) -> str:
    """A word in the notation of patterns.

    >>> word_text((Letter("A", 1.0), Letter("wall", None)))
    'A{wall}'
    """
    return "".join(letter.symbol if len(letter.symbol.rstrip("'")) == 1 else f"{{{letter.symbol}}}" for letter in word)
