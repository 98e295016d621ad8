"""Symbols without a size that several layers share, which is rarely meant: as one symbol they are aligned.

In `gdg; d := D` and `cgc; c := C` of two layers the placeholder `g` is one symbol: its letters can only be in the same
columns. Where a design has no layout, a layout with such a symbol told apart shows that this is the reason.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from grammarlab.layers.design import Design, Layer
from grammarlab.layers.patterns import Alternatives, LayerPattern, Node, Power, Row, Sign

_AXES = ("x", "y")


@dataclass(frozen=True, slots=True)
class SharedWildcard:
    """A symbol without a size in different patterns of layers that are aligned with each other."""

    symbol: str
    axis: int
    """0 for x, 1 for y."""
    patterns: tuple[str, ...]
    """Names of the patterns, at least two, from the top layer down."""
    layers: tuple[str, ...]
    """Names of the first layers with these patterns."""

    def as_hint(self) -> str:
        """What a person may try."""
        return f"{self._fact}. If that is not meant, use different symbols without a size."

    def as_reason(self) -> str:
        """The same, for a design that is known to have a layout with different symbols."""
        return f"{self._fact}; a layout exists if they use different symbols without a size."

    @property
    def _fact(self) -> str:
        named = f"{', '.join(map(repr, self.layers[:-1]))} and {self.layers[-1]!r}"
        return f"{self.symbol} is one symbol along {_AXES[self.axis]} in the layers {named}, so its places agree"


def shared_wildcards(design: Design) -> tuple[SharedWildcard, ...]:
    """The symbols without a size that different patterns of one alignment group share, in order of occurrence."""
    found: dict[tuple[int, str, str], dict[str, str]] = {}
    for layer in design.visible_layers:
        for axis, name in enumerate(layer.patterns):
            for symbol in design.patterns[name].symbols():
                if design.symbols[symbol].size is None:
                    found.setdefault((axis, layer.groups[axis], symbol), {}).setdefault(name, layer.name)
    return tuple(
        SharedWildcard(symbol, axis, tuple(places), tuple(places.values()))
        for (axis, _, symbol), places in found.items()
        if len(places) > 1
    )


def told_apart(design: Design, shared: Sequence[SharedWildcard]) -> Design:
    """A design in which each pattern has its own symbol instead of a shared one; shapes are left out."""
    new: dict[tuple[int, str], dict[str, str]] = {}
    for each in shared:
        for name in each.patterns[1:]:
            new.setdefault((each.axis, name), {})[each.symbol] = f"{each.symbol} of {name} along {_AXES[each.axis]}"
    symbols, patterns = dict(design.symbols), dict(design.patterns)
    for (axis, name), names in new.items():
        symbols |= {new_name: replace(symbols[old], name=new_name) for old, new_name in names.items()}
        patterns[_renamed_pattern(axis, name)] = with_symbols(design.patterns[name], names)
    layers = tuple(_with_patterns(layer, new) for layer in design.layers)
    return replace(design, symbols=symbols, patterns=patterns, layers=layers, shapes={})


def with_symbols(pattern: LayerPattern, names: Mapping[str, str]) -> LayerPattern:
    """A pattern with other symbols in the places of some; its text stays."""
    contents = tuple((sign, _with_symbols(node, names)) for sign, node in pattern.contents)
    return LayerPattern(pattern.text, _with_symbols(pattern.body, names), contents)


def _with_symbols(node: Node, names: Mapping[str, str]) -> Node:
    match node:
        case Sign():
            return replace(node, symbol=names.get(node.symbol, node.symbol))
        case Power():
            return replace(node, base=_with_symbols(node.base, names))
        case Row():
            return Row(tuple(_with_symbols(part, names) for part in node.parts))
        case Alternatives():
            return replace(node, options=tuple(_with_symbols(option, names) for option in node.options))


def _renamed_pattern(axis: int, name: str) -> str:
    return f"{name} along {_AXES[axis]}"


def _with_patterns(layer: Layer, new: Mapping[tuple[int, str], Mapping[str, str]]) -> Layer:
    """A layer with its renamed patterns, and masks that show the same places."""
    patterns, masks = list(layer.patterns), list(layer.masks)
    for axis, name in enumerate(layer.patterns):
        names = new.get((axis, name))
        if names is None:
            continue
        patterns[axis] = _renamed_pattern(axis, name)
        mask = masks[axis]
        masks[axis] = None if mask is None else frozenset(names.get(symbol, symbol) for symbol in mask)
    return replace(layer, patterns=(patterns[0], patterns[1]), masks=(masks[0], masks[1]), shapes={})
