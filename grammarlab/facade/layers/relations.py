"""Equations of counters and sizes: different remainders of two patterns of one group are equally long (supplement 3.1).

All layers span the canvas. If two words have equal beginnings and ends, their remainders are equally long; this gives
an equation of counters and of sizes. It holds if no layer leaves a gap for a letter above it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grammarlab.facade.layers.designs.patterns import LayerPattern, Linear, Node, Power, Row, Sign

_ONE = Linear(1, ())


@dataclass(frozen=True, slots=True)
class Relation:
    """An equation between sums of symbol sizes."""

    terms: tuple[tuple[str, Linear], ...]
    """Symbols, and the difference of their counts in the first and the second pattern; none is 0."""

    def __str__(self) -> str:
        """The equation, with one side for each pattern.

        >>> from grammarlab.facade.layers.designs.parsing import parse_pattern
        >>> print(relation(parse_pattern("A^kcC^mcA^k; c := C"), parse_pattern("A^kC^lA^k")))
        m + 2 = l
        >>> print(relation(parse_pattern("cec; c := C"), parse_pattern("A(BA)^k")))
        2C + e = (k + 1)A + k B
        """
        if len(self.terms) == 1:
            return _equation(self.terms[0][1])
        sides = [[], []]
        for symbol, count in self.terms:
            less = _is_less(count)
            text = _linear_text(Linear(0, ()).minus(count) if less else count)
            often = {"1": ""}.get(text, text if text.isdigit() else f"({text})" if " " in text else f"{text} ")
            sides[less].append(f"{often}{symbol}")
        return " = ".join(" + ".join(side) or "0" for side in sides)


def relation(first: LayerPattern, second: LayerPattern) -> Relation | None:
    """The equation of two patterns; None if they do not differ, or have choices or copies of copies."""
    if not (_is_plain(first) and _is_plain(second)):
        return None
    items = [_items(first), _items(second)]
    for end in (0, -1):
        while items[0] and items[1] and items[0][end] == items[1][end]:
            for each in items:
                each.pop(end)
    counts: dict[str, Linear] = {}
    for sign, each in zip((1, -1), items, strict=True):
        for letters, count in each:
            for letter in letters:
                counts[letter] = _plus(counts.get(letter, Linear(0, ())), count, sign)
    terms = tuple((symbol, count) for symbol, count in counts.items() if count.constant or count.terms)
    return Relation(terms) if terms else None


def _is_plain(pattern: LayerPattern) -> bool:
    """Whether the count of each symbol is linear in the counters."""
    powers = [node for node in pattern.nodes() if isinstance(node, Power)]
    copied = {
        node.symbol for power in powers for node in LayerPattern("", power.base).nodes() if isinstance(node, Sign)
    }
    inner = {
        sign.symbol
        for sign, content in pattern.contents
        for node in LayerPattern("", content).nodes()
        if isinstance(node, Power)
    }
    reflected = any(factor < 0 for power in powers for _, factor in power.count.terms)
    return not (pattern.options() or inner & copied or reflected)


def _items(pattern: LayerPattern) -> list[tuple[tuple[str, ...], Linear]]:
    """Runs of letters and the number of copies of each."""
    found: list[tuple[tuple[str, ...], Linear]] = []

    def add(node: Node, count: Linear | None) -> None:
        match node:
            case Sign():
                content = pattern.content_of(node.symbol)
                if content is not None:
                    add(content, count)
                else:
                    found.append(((node.symbol,), count or _ONE))
            case Row():
                if count is None:
                    for part in node.parts:
                        add(part, None)
                else:
                    found.append((tuple(_letters(node, pattern)), count))
            case Power():
                add(node.base, node.count)
            case _:
                raise AssertionError("patterns with choices have no relations")

    add(pattern.body, None)
    return found


def _letters(node: Node, pattern: LayerPattern) -> Sequence[str]:
    match node:
        case Sign():
            content = pattern.content_of(node.symbol)
            return [node.symbol] if content is None else _letters(content, pattern)
        case Row():
            return [letter for part in node.parts for letter in _letters(part, pattern)]
        case _:
            raise AssertionError("copies cannot be nested")


def _plus(total: Linear, count: Linear, sign: int) -> Linear:
    zero = Linear(0, ())
    return total.minus(zero.minus(count)) if sign > 0 else total.minus(count)


def _is_less(count: Linear) -> bool:
    return (count.terms[0][1] if count.terms else count.constant) < 0


def _equation(count: Linear) -> str:
    """A linear form that equals 0 as an equation, with positive factors on each side.

    >>> _equation(Linear(2, (("l", -1), ("m", 1))))
    'm + 2 = l'
    """
    left = Linear(max(count.constant, 0), tuple((name, factor) for name, factor in count.terms if factor > 0))
    right = Linear(max(-count.constant, 0), tuple((name, -factor) for name, factor in count.terms if factor < 0))
    return f"{_linear_text(left)} = {_linear_text(right)}"


def _linear_text(count: Linear) -> str:
    parts = [f"{'' if abs(factor) == 1 else abs(factor)}{name}" for name, factor in count.terms]
    signs = [factor < 0 for _, factor in count.terms]
    if count.constant or not parts:
        parts.append(str(abs(count.constant)))
        signs.append(count.constant < 0)
    text = ("-" if signs[0] else "") + parts[0]
    return text + "".join(f" {'-' if less else '+'} {part}" for less, part in zip(signs[1:], parts[1:], strict=True))
