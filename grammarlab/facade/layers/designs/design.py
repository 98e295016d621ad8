"""A design: layers of patterns over symbols with preferred sizes, for a canvas of any size (paper 003, section 3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from grammarlab.facade.layers.designs.patterns import LayerPattern, Reflection, Slots
from grammarlab.facade.layers.letters import Letter, Word
from grammarlab.facade.layers.weights import Weights

WILDCARD = "*"
"""Any symbol, in the table of shapes."""


@dataclass(frozen=True, slots=True)
class Symbol:
    """What letters of one name have in common."""

    name: str
    size: float | None = None
    """Metres that are preferred, > 0; None: as much as is left for it."""
    opaque: bool = True
    """Whether it hides what lies below it."""
    attached: bool = False
    """Whether its neighbours in a word stay beside it."""
    unoccludable: bool = False
    """Whether nothing that hides only in part may lie over it."""
    transparent: bool = False
    """Whether nothing of it is ever seen."""


@dataclass(frozen=True, slots=True)
class Counter:
    """How often parts of patterns are repeated, in all patterns alike."""

    name: str
    least: int | None = None
    """None: the least number from 0 for which no `X^{k - 1}` is repeated a negative number of times."""
    most: int | None = None
    """None: as often as the canvas has room for."""
    reflection: Reflection = "inner"
    """What a negative number of copies means."""


@dataclass(frozen=True, slots=True)
class Shape:
    """What is seen where a horizontal and a vertical symbol meet."""

    label: str
    """What it is called, and so what it looks like (`grammarlab.facade.looks`)."""
    depth: float = 0.0
    """Metres that it stands out more than its label says."""
    inset: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    """Metres from the left, bottom, right and top of its place to itself; less where the place is small."""
    frame: str = ""
    """What is around it in its place; empty where what is below is seen there."""


Shapes = Mapping[tuple[str, str], Shape]
"""Shapes by horizontal and vertical symbol, each of which may be `WILDCARD`."""


@dataclass(frozen=True, slots=True)
class Layer:
    """A horizontal pattern by a vertical one. Pairs are of x and y."""

    name: str
    patterns: tuple[str, str]
    """Names of patterns of the design."""
    groups: tuple[str, str] = ("", "")
    """Only layers of one group are aligned."""
    masks: tuple[frozenset[str] | None, frozenset[str] | None] = (None, None)
    """Symbols that are seen; None for all."""
    on: bool = True
    depth: float = 0.0
    """Metres that its shapes stand out more."""
    shapes: Shapes = field(default_factory=dict)
    """Before those of the design."""


@dataclass(frozen=True, slots=True)
class Design:
    """Layers that fit each other on a canvas."""

    title: str
    width: float
    """Metres, of the canvas."""
    height: float
    """Metres, of the canvas."""
    symbols: Mapping[str, Symbol]
    counters: Mapping[str, Counter]
    patterns: Mapping[str, LayerPattern]
    layers: tuple[Layer, ...]
    """From the topmost down."""
    shapes: Shapes = field(default_factory=dict)
    weights: Weights = field(default_factory=Weights)
    """What the solver minimizes."""
    overhang: bool = False
    """Whether letters that are not opaque keep their sizes, centred in their columns (supplement 002, section 3.4)."""

    @property
    def visible_layers(self) -> tuple[Layer, ...]:
        """Those that are switched on, from the topmost down."""
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
        """Symbols of a layer that are seen all along the other axis, and hide what is below them there."""
        if not self._seen(layer, 1 - axis) >= set(self.patterns[layer.patterns[1 - axis]].symbols()):
            return frozenset()
        return self._seen(layer, axis)

    def _seen(self, layer: Layer, axis: int) -> frozenset[str]:
        """Opaque symbols of a layer that neither its mask nor its pattern hides."""
        pattern, mask = self.patterns[layer.patterns[axis]], layer.masks[axis]
        return frozenset(
            name
            for name in pattern.symbols()
            if (mask is None or name in mask)
            and self.symbols[name].opaque
            and not (self.symbols[name].transparent or name in pattern.placeholders())
        )

    def shape(self, layer: Layer, across: str, up: str) -> Shape:
        """What is seen of a layer where two symbols meet; by default it is called after both."""
        for shapes in (layer.shapes, self.shapes):
            for key in ((across, up), (across, WILDCARD), (WILDCARD, up), (WILDCARD, WILDCARD)):
                if key in shapes:
                    return shapes[key]
        return Shape(f"{across} {up}")


def word_text(word: Word) -> str:
    """A word as a pattern writes it.

    >>> word_text((Letter("A", 1.0), Letter("wall", None)))
    'A{wall}'
    """
    return "".join(letter.symbol if len(letter.symbol.rstrip("'")) == 1 else f"{{{letter.symbol}}}" for letter in word)
