"""Contradictions in a design: a minimal set of its statements that cannot hold together.

Statements are removed, first many at once and then one by one, as long as the remaining ones have no layout (deletion
filter). In the final set, every statement is needed for the contradiction.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from grammarlab.layers.design import Counter, Design, Layer, Symbol
from grammarlab.layers.patterns import Alternatives, LayerPattern, Linear, Node, Power, Row, Sign, parse_pattern

_FLAGS = {"attached": False, "unoccludable": False, "transparent": False, "opaque": True}
_AXES = ("x", "y")
_MOST_TRIALS = 120
"""Largest number of trials to lay out a subset of the statements; after that, the set may not be minimal."""
_MOST_COPIES = 60
"""Largest number of copies of a part without a size."""
_WILD_SYMBOL = "Ω"
"""A symbol that fits everywhere."""


@dataclass(frozen=True, slots=True)
class Statement:
    """A requirement of a design."""

    kind: str
    """`pattern`, `size`, `counter`, `everywhere` (one size along both axes), or a flag."""
    name: str
    """Name of the pattern, counter or symbol."""
    axis: int = 0
    """Axis of a pattern."""


def statements(design: Design) -> list[Statement]:
    """All requirements of a design; the most helpful ones come last."""
    layers = design.visible_layers
    rows = list(dict.fromkeys((axis, layer.patterns[axis]) for layer in layers for axis in (0, 1)))
    along = {
        axis: {symbol for row_axis, name in rows if row_axis == axis for symbol in design.patterns[name].symbols()}
        for axis in (0, 1)
    }
    used = [name for name in design.symbols if name in along[0] | along[1]]
    requirements = [
        Statement(flag, name)
        for flag, default in _FLAGS.items()
        for name in used
        if getattr(design.symbols[name], flag) is not default
    ]
    requirements += [Statement("everywhere", name) for name in used if name in along[0] & along[1]]
    counters = [name for _, pattern in rows for name in design.patterns[pattern].counters()]
    requirements += [Statement("counter", name) for name in dict.fromkeys(counters) if counters.count(name) > 1]
    requirements += [Statement("size", name) for name in used if design.symbols[name].size is not None]
    return requirements + [Statement("pattern", name, axis) for axis, name in rows]


def contradiction(
    design: Design, fits: Callable[[Design], bool], candidates: Sequence[Statement] | None = None
) -> tuple[Statement, ...]:
    """A minimal set of statements that cannot hold together; empty if all of them can.

    Args:
        design: a design.
        fits: whether a design can be laid out.
        candidates: the statements to check; all others are dropped. All statements of the design if left out.
    """
    remaining = list(statements(design) if candidates is None else candidates)
    trials = 0
    if fits(relaxed(design, remaining)):
        return ()
    size = max(len(remaining) // 2, 1)
    while size:
        start = 0
        while start < len(remaining) and trials < _MOST_TRIALS:
            fewer = remaining[:start] + remaining[start + size :]
            trials += 1
            if fits(relaxed(design, fewer)):
                start += size
            else:
                remaining = fewer
        size //= 2
    return tuple(remaining)


def relaxed(design: Design, retained: Sequence[Statement]) -> Design:
    """A design with only some of its requirements."""
    requirements = set(retained)
    symbols = {
        name: replace(
            symbol,
            size=symbol.size if Statement("size", name) in requirements else None,
            **{flag: default for flag, default in _FLAGS.items() if Statement(flag, name) not in requirements},
        )
        for name, symbol in design.symbols.items()
    }
    symbols[_WILD_SYMBOL], symbols[_WILD_SYMBOL * 2] = Symbol(_WILD_SYMBOL), Symbol(_WILD_SYMBOL * 2)
    patterns: dict[str, LayerPattern] = {}
    counters: dict[str, Counter] = dict(design.counters)
    layers: list[Layer] = []
    for layer in design.visible_layers:
        names, groups, masks = list(layer.patterns), list(layer.groups), list(layer.masks)
        for axis, name in enumerate(layer.patterns):
            if Statement("pattern", name, axis) not in requirements:
                names[axis] = groups[axis] = f"{_WILD_SYMBOL}{_AXES[axis]}"
                masks[axis] = None
                patterns[names[axis]] = parse_pattern(_WILD_SYMBOL if axis == 0 else f"{{{_WILD_SYMBOL * 2}}}")
                continue
            names[axis] = f"{name} {_AXES[axis]}"
            renamed = _Renamed(
                requirements, names[axis], axis, {sign.symbol for sign, _ in design.patterns[name].contents}
            )
            patterns[names[axis]] = renamed.pattern(design.patterns[name])
            counters |= {new: replace(design.counters[old], name=new) for old, new in renamed.counters.items()}
            symbols |= {new: replace(symbols[old], name=new) for old, new in renamed.symbols.items()}
            if any(symbols[part].size is None for part in design.patterns[name].symbols()):
                # The count of a part without a size is free.
                counters |= {
                    counter: replace(counters[counter], most=min(_MOST_COPIES, counters[counter].most or _MOST_COPIES))
                    for counter in patterns[names[axis]].counters()
                }
            mask = masks[axis]
            masks[axis] = None if mask is None else frozenset(renamed.symbols.get(visible, visible) for visible in mask)
        layers.append(
            replace(layer, patterns=(names[0], names[1]), groups=(groups[0], groups[1]), masks=(masks[0], masks[1]))
        )
    return replace(design, symbols=symbols, counters=counters, patterns=patterns, layers=tuple(layers), shapes={})


@dataclass
class _Renamed:
    """A pattern with new names for counters, or for symbols along y, so that it is independent of others."""

    requirements: set[Statement]
    where: str
    axis: int
    replaced: set[str]
    """Symbols with contents."""
    counters: dict[str, str] = field(default_factory=dict)
    symbols: dict[str, str] = field(default_factory=dict)

    def pattern(self, pattern: LayerPattern) -> LayerPattern:
        """The pattern with new names."""
        contents = tuple((sign, self._node(node)) for sign, node in pattern.contents)
        return LayerPattern(pattern.text, self._node(pattern.body), contents)

    def _node(self, node: Node) -> Node:
        match node:
            case Sign():
                return replace(node, symbol=self._symbol(node.symbol))
            case Power():
                terms = tuple(sorted((self._counter(name), factor) for name, factor in node.count.terms))
                return replace(node, base=self._node(node.base), count=Linear(node.count.constant, terms))
            case Row():
                return Row(tuple(self._node(part) for part in node.parts))
            case Alternatives():
                return replace(node, options=tuple(self._node(option) for option in node.options))

    def _symbol(self, name: str) -> str:
        if self.axis == 0 or name in self.replaced or Statement("everywhere", name) in self.requirements:
            return name
        self.symbols[name] = f"{name} {_AXES[self.axis]}"
        return self.symbols[name]

    def _counter(self, name: str) -> str:
        if Statement("counter", name) in self.requirements:
            return name
        self.counters[name] = f"{name} {self.where}"
        return self.counters[name]


def in_words(design: Design, conflict: Sequence[Statement]) -> str:
    """Statements in words."""
    canvas = (design.width, design.height)
    sentences = []
    for statement in conflict:
        match statement.kind:
            case "pattern":
                text = design.patterns[statement.name].text
                sentences.append(
                    f"the pattern {text!r} fills {canvas[statement.axis]:g} m along {_AXES[statement.axis]}"
                )
            case "size":
                sentences.append(f"{statement.name} is {design.symbols[statement.name].size:g} m long")
            case "counter":
                sentences.append(f"{statement.name} has one value in all patterns")
            case "everywhere":
                sentences.append(f"{statement.name} has one size along both axes")
            case "opaque":
                sentences.append(f"{statement.name} is not opaque")
            case _:
                sentences.append(f"{statement.name} is {statement.kind}")
    return "; ".join(reversed(sentences))
