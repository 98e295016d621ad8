"""A design: layers of patterns over symbols with preferred sizes, for any canvas (paper 003, section 3).

Letters are occurrences of symbols in words. `design_text` writes the TOML that `parse_design` reads.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

from grammarlab.errors import FacadeError
from grammarlab.layers.patterns import LayerPattern, Reflection, Slots

MIN_WEIGHT, MAX_WEIGHT = 1e-9, 1e6
"""Smallest and largest weight above 0: ratios of weights are finite numbers."""
WILDCARD = "*"
"""Matches any symbol in the table of shapes."""
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True, slots=True)
class Weights:
    """The energy of a layout is omega * errors of columns + merge * merged letters + sizing * error of sizes."""

    omega: float = 1.0
    """Energy per metre of error of columns (Equation 9)."""
    merge: float = 0.05
    """Energy per letter of an element beyond its first: without it, one column for all would often be best."""
    sizing: float = 1.0
    """Energy per square metre of the sum of squared deviations from preferred sizes."""

    def __post_init__(self) -> None:
        for weight in fields(self):
            value = getattr(self, weight.name)
            if not is_weight(value):
                raise FacadeError(
                    f"Weight {weight.name}: expected 0, or a number from {MIN_WEIGHT:g} to {MAX_WEIGHT:,.0f}, "
                    f"found {value}."
                )


@dataclass(frozen=True, slots=True)
class Letter:
    """An occurrence of a symbol in a word."""

    symbol: str
    size: float | None
    """Preferred size, metres, > 0; None: the letter takes the remaining length."""
    opaque: bool = True
    """Whether it hides the layers below it."""
    attached: bool = False
    """Whether its neighbours in the word stay adjacent to it."""
    unoccludable: bool = False
    """Whether no element that covers only a part may lie over it."""
    transparent: bool = False
    """Whether it is invisible: a letter of a control pattern without content."""
    mirrored: bool = False
    """Whether a reflection made it."""
    covers: bool = True
    """Whether it is visible along the whole other axis, so that it can hide an empty place below it."""

    def __hash__(self) -> int:
        """Hash of the symbol only: words are looked up often, and letters of a symbol are mostly equal."""
        return hash(self.symbol)

    @property
    def hides(self) -> bool:
        """Whether layers below may leave gaps for it."""
        return self.opaque and self.covers and not self.transparent


Word = tuple[Letter, ...]
"""One layer along one axis, from the left or from the bottom."""


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
        if not self._visible_symbols(layer, 1 - axis) >= set(self.patterns[layer.patterns[1 - axis]].symbols()):
            return frozenset()
        return self._visible_symbols(layer, axis)

    def _visible_symbols(self, layer: Layer, axis: int) -> frozenset[str]:
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


def design_text(design: Design) -> str:
    r"""A design as TOML; default values are left out.

    >>> from grammarlab.layers.file import parse_design
    >>> text = 'canvas = { width = 3.0, height = 2.0 }\n[symbols]\nA = {}\n[[layers]]\nx = "A"\ny = "A"\n'
    >>> parse_design(design_text(parse_design(text))) == parse_design(text)
    True
    """
    lines = [f"title = {_text(design.title)}"] if design.title else []
    lines.append(f"canvas = {{ width = {design.width!r}, height = {design.height!r} }}")
    tables = {
        "symbols": {name: _symbol(symbol) for name, symbol in design.symbols.items()},
        "counters": {name: text for name, counter in design.counters.items() if (text := _counter(counter))},
        "patterns": {name: _text(pattern.text) for name, pattern in design.patterns.items()},
        "solver": _solver(design),
    }
    for name, table in tables.items():
        if table:
            lines += ["", f"[{name}]", *(f"{_key(key)} = {value}" for key, value in table.items())]
    if design.shapes:
        lines += ["", "[shapes]", *_shapes(design.shapes)]
    lines += ["", "# Layers from the top down."]
    for number, layer in enumerate(design.layers):
        lines += ([""] if number else []) + _layer(layer)
    return "\n".join(lines) + "\n"


def is_weight(value: float) -> bool:
    """Whether a number can be a weight."""
    return value == 0.0 or MIN_WEIGHT <= value <= MAX_WEIGHT


def _text(text: str) -> str:
    """A basic string; JSON's escapes are those of TOML, except for one character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _symbol(symbol: Symbol) -> str:
    flags = {"opaque": True, "attached": False, "unoccludable": False, "transparent": False}
    parts = {} if symbol.size is None else {"size": repr(symbol.size)}
    parts |= {
        name: str(not default).lower() for name, default in flags.items() if bool(getattr(symbol, name)) is not default
    }
    return parts["size"] if set(parts) == {"size"} else _inline(parts)


def _inline(parts: Mapping[str, str]) -> str:
    return f"{{ {', '.join(f'{key} = {value}' for key, value in parts.items())} }}" if parts else "{}"


def _counter(counter: Counter) -> str:
    """The entry of a counter; empty if it has default values only."""
    parts = {name: str(value) for name in ("least", "most") if (value := getattr(counter, name)) is not None}
    parts |= {} if counter.reflection == "inner" else {"reflection": _text(counter.reflection)}
    return _inline(parts) if parts else ""


def _solver(design: Design) -> dict[str, str]:
    default = Weights()
    changed = {
        weight.name: repr(getattr(design.weights, weight.name))
        for weight in fields(Weights)
        if getattr(design.weights, weight.name) != getattr(default, weight.name)
    }
    return changed | ({"overhang": "true"} if design.overhang else {})


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _text(name)


def _shapes(shapes: Shapes) -> list[str]:
    lines = []
    for (across, up), shape in shapes.items():
        label = _text(shape.label)
        value = f"{{ label = {label}, depth = {shape.depth!r} }}" if shape.depth else label
        lines.append(f"{_key(across)}.{_key(up)} = {value}")
    return lines


def _layer(layer: Layer) -> list[str]:
    lines = ["[[layers]]", f"name = {_text(layer.name)}"]
    lines += [f"{axis} = {_text(name)}" for axis, name in zip("xy", layer.patterns, strict=True)]
    groups = [f"{axis} = {_text(name)}" for axis, name in zip("xy", layer.groups, strict=True) if name]
    masks = [
        f"{axis} = [{', '.join(map(_text, sorted(mask)))}]"
        for axis, mask in zip("xy", layer.masks, strict=True)
        if mask is not None
    ]
    lines += [f"{key} = {{ {', '.join(entries)} }}" for key, entries in (("group", groups), ("mask", masks)) if entries]
    lines += [] if layer.on else ["on = false"]
    lines += [f"depth = {layer.depth!r}"] if layer.depth else []
    return lines + ([f"shapes = {{ {', '.join(_shapes(layer.shapes))} }}"] if layer.shapes else [])
