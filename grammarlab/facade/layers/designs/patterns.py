"""Patterns: regular expressions over symbols, with counters of one value in all patterns (paper 003, section 3.2)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

Reflection = Literal["none", "inner", "outer", "pivot-inner", "pivot-outer", "pivot-total"]
"""Meaning of a negative number of copies (supplement 002, table 1)."""
REFLECTIONS: tuple[Reflection, ...] = ("none", "inner", "outer", "pivot-inner", "pivot-outer", "pivot-total")


@dataclass(frozen=True, slots=True)
class Linear:
    """An integer number of copies: a constant plus multiples of counters."""

    constant: int
    terms: tuple[tuple[str, int], ...]
    """Counters and their factors, by name; no factor is 0."""

    def value(self, counters: Mapping[str, int]) -> int:
        """The number for values of its counters."""
        return self.constant + sum(factor * counters[name] for name, factor in self.terms)

    def minus(self, other: Linear) -> Linear:
        """The difference of two numbers."""
        factors = dict(self.terms)
        for name, factor in other.terms:
            factors[name] = factors.get(name, 0) - factor
        terms = tuple(sorted((name, factor) for name, factor in factors.items() if factor))
        return Linear(self.constant - other.constant, terms)


@dataclass(frozen=True, slots=True)
class Sign:
    """A symbol in a pattern."""

    symbol: str
    place: int
    """Character index in the pattern's text, from 0."""


@dataclass(frozen=True, slots=True)
class Power:
    """Copies of a part, or for a negative number its reflection."""

    base: Node
    count: Linear
    place: int


@dataclass(frozen=True, slots=True)
class Row:
    """A sequence of parts."""

    parts: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Alternatives:
    """A choice between parts."""

    options: tuple[Node, ...]
    number: int
    """Index of the choice in its pattern, from 0."""


Node = Sign | Power | Row | Alternatives


@dataclass(frozen=True, slots=True)
class LayerPattern:
    """A pattern; a control pattern also has contents that replace some of its symbols."""

    text: str
    body: Node
    contents: tuple[tuple[Sign, Node], ...] = ()
    """The contents of symbols: the same word at each occurrence."""

    def content_of(self, symbol: str) -> Node | None:
        """The content of a symbol."""
        return next((node for sign, node in self.contents if sign.symbol == symbol), None)

    def nodes(self) -> Iterator[Node]:
        """All of its parts: those of its body, then those of its contents."""
        for each in (self.body, *(node for _, node in self.contents)):
            yield from _within(each)

    def counters(self) -> tuple[str, ...]:
        """Its counters, in order of occurrence."""
        powers = (node for node in self.nodes() if isinstance(node, Power))
        return tuple(dict.fromkeys(name for power in powers for name, _ in power.count.terms))

    def options(self) -> tuple[int, ...]:
        """Number of options of each of its choices."""
        choices = sorted((node.number, len(node.options)) for node in self.nodes() if isinstance(node, Alternatives))
        return tuple(count for _, count in choices)

    def symbols(self) -> tuple[str, ...]:
        """The symbols of its words, in order of occurrence."""
        replaced = {sign.symbol for sign, _ in self.contents}
        signs = [node.symbol for node in self.nodes() if isinstance(node, Sign)]
        return tuple(dict.fromkeys(symbol for symbol in signs if symbol not in replaced))

    def placeholders(self) -> frozenset[str]:
        """Symbols of a control pattern without contents."""
        replaced = {sign.symbol for sign, _ in self.contents}
        signs = {node.symbol for node in _within(self.body) if isinstance(node, Sign)}
        return frozenset(signs - replaced) if replaced else frozenset()


def _within(node: Node) -> Iterator[Node]:
    yield node
    match node:
        case Power():
            yield from _within(node.base)
        case Row():
            for part in node.parts:
                yield from _within(part)
        case Alternatives():
            for option in node.options:
                yield from _within(option)
        case Sign():
            pass


@dataclass(frozen=True, slots=True)
class Slot:
    """A position of a word."""

    symbol: str
    placeholder: bool = False
    """Whether it is a letter of a control pattern without content."""
    mirrored: bool = False


Slots = tuple[Slot, ...]


@dataclass(frozen=True, slots=True)
class Values:
    """Values that determine a word of a pattern."""

    counters: Mapping[str, int]
    choices: tuple[int, ...]
    """Selected option of each choice."""
    reflections: Mapping[str, Reflection]
    """Mode of each counter whose mode is not `inner`."""


def expand(pattern: LayerPattern, values: Values, most: int) -> Slots | None:
    """The word of a pattern for given values; None if it has more than `most` letters."""
    contents: dict[str, Slots] = {}
    for sign, node in pattern.contents:
        content = _expand(node, values, most, {}, placeholder=False)
        if content is None:
            return None
        contents[sign.symbol] = content
    return _expand(pattern.body, values, most, contents, placeholder=bool(contents))


def _expand(node: Node, values: Values, most: int, contents: Mapping[str, Slots], *, placeholder: bool) -> Slots | None:
    match node:
        case Sign():
            return contents.get(node.symbol) or (
                () if node.symbol in contents else (Slot(node.symbol, placeholder=placeholder),)
            )
        case Alternatives():
            chosen = node.options[values.choices[node.number]]
            return _expand(chosen, values, most, contents, placeholder=placeholder)
        case Row():
            found: list[Slot] = []
            for part in node.parts:
                more = _expand(part, values, most, contents, placeholder=placeholder)
                if more is None or len(found) + len(more) > most:
                    return None
                found += more
            return tuple(found)
        case Power():
            base = _expand(node.base, values, most, contents, placeholder=placeholder)
            count = node.count.value(values.counters)
            if base is None or len(base) * abs(count) > most:
                return None
            mode: Reflection = "inner"
            for name, _ in node.count.terms:
                mode = values.reflections.get(name, mode)
            word = repeated(base, count, mode)
            return word if len(word) <= most else None


def repeated(base: Slots, count: int, reflection: Reflection) -> Slots:
    """Copies of a word; for a negative count, with mirror images (supplement 002, table 1).

    Inner modes mirror each copy beside it, outer ones all copies together. A pivot is the letter at the mirror, which
    is not doubled; with `pivot-total`, adjacent copies share a letter too.

    >>> def shown(count, reflection):
    ...     word = repeated(tuple(map(Slot, "EkG")), count, reflection)
    ...     return "".join(slot.symbol for slot in word)
    >>> shown(2, "inner"), shown(-2, "none"), shown(-2, "inner"), shown(-2, "outer")
    ('EkGEkG', 'EkGEkG', 'EkGGkEEkGGkE', 'EkGEkGGkEGkE')
    >>> shown(-2, "pivot-inner"), shown(-2, "pivot-outer"), shown(-2, "pivot-total")
    ('EkGkEEkGkE', 'EkGEkGkEGkE', 'EkGkEkGkE')
    """
    copies, times = base * abs(count), abs(count)
    if count >= 0 or reflection == "none" or not base:
        return copies
    match reflection:
        case "inner":
            return (base + _mirrored(base)) * times
        case "outer":
            return copies + _mirrored(copies)
        case "pivot-inner":
            return (base + _mirrored(base)[1:]) * times
        case "pivot-outer":
            return copies + _mirrored(copies)[1:]
        case "pivot-total":
            one = base + _mirrored(base)[1:]
            return one + one[1:] * (times - 1)


def _mirrored(word: Slots) -> Slots:
    return tuple(Slot(slot.symbol, slot.placeholder, not slot.mirrored) for slot in reversed(word))
