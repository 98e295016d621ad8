"""Patterns: regular expressions over symbols, with counters shared by all patterns (paper 003, section 3.2).

Errors in the text of a pattern have positions.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Literal, cast

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

Reflection = Literal["none", "inner", "outer", "pivot-inner", "pivot-outer", "pivot-total"]
"""Meaning of a negative number of copies (supplement 002, table 1)."""
REFLECTIONS: tuple[Reflection, ...] = ("none", "inner", "outer", "pivot-inner", "pivot-outer", "pivot-total")
MOST_CHARACTERS = 2_000
"""Largest number of characters of a pattern."""
_MAX_DEPTH = 40
"""Largest depth of nested groups."""
_MOST_COPIES = 100_000
"""Largest number in an exponent."""
_TERM = re.compile(r"\s*([+-]?)\s*(?:([0-9]+)\s*\*?\s*([^\W\d_]\w*)?|([^\W\d_]\w*))\s*")
_TOKEN_WORDS = {
    "LPAR": "'('",
    "RPAR": "')'",
    "VBAR": "'|'",
    "SEMICOLON": "';'",
    "SYMBOL": "a symbol",
    "EXPONENT": "'^'",
}


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
    position: int
    """Character index in the pattern's text, from 0."""


@dataclass(frozen=True, slots=True)
class Power:
    """Copies of a part, or for a negative number its reflection."""

    base: Node
    count: Linear
    position: int
    """Character index of the exponent in the pattern's text, from 0."""


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
        for root in (self.body, *(node for _, node in self.contents)):
            yield from _within(root)

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


@dataclass(frozen=True, slots=True)
class Values:
    """Values that determine a word of a pattern."""

    counters: Mapping[str, int]
    choices: tuple[int, ...]
    """Selected option of each choice."""
    reflections: Mapping[str, Reflection]
    """Mode of each counter whose mode is not `inner`."""


@dataclass(frozen=True)
class PatternError(Exception):
    """A mistake in the text of a pattern."""

    message: str
    position: int
    """Character index in the text, from 0."""
    length: int = 1
    hint: str = ""


@dataclass(frozen=True, slots=True)
class Slot:
    """A position of a word."""

    symbol: str
    placeholder: bool = False
    """Whether it is a letter of a control pattern without content."""
    mirrored: bool = False


Slots = tuple[Slot, ...]


def expand(pattern: LayerPattern, values: Values, most: int) -> Slots | None:
    """The word of a pattern for given values; None if it has more than `most` letters."""
    contents: dict[str, Slots] = {}
    for sign, node in pattern.contents:
        content = _expand(node, values, most, {}, placeholder=False)
        if content is None:
            return None
        contents[sign.symbol] = content
    return _expand(pattern.body, values, most, contents, placeholder=bool(contents))


def parse_pattern(text: str) -> LayerPattern:
    """A pattern in the paper's notation.

    >>> [sign.symbol for sign, _ in parse_pattern("cec; c := A(BA)^k").contents]
    ['c']

    Raises:
        PatternError: If the text has a mistake; with its position.
    """
    if len(text) > MOST_CHARACTERS:
        raise PatternError(f"this pattern has {len(text):,} characters: expected at most {MOST_CHARACTERS:,}", 0)
    _check_depth(text)
    try:
        tree = _parser().parse(text)
    except UnexpectedInput as error:
        raise _explained(text, error) from error
    return _Builder(text).pattern(tree)


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
            slots: list[Slot] = []
            for part in node.parts:
                more = _expand(part, values, most, contents, placeholder=placeholder)
                if more is None or len(slots) + len(more) > most:
                    return None
                slots += more
            return tuple(slots)
        case Power():
            base = _expand(node.base, values, most, contents, placeholder=placeholder)
            count = node.count.value(values.counters)
            if base is None or len(base) * abs(count) > most:
                return None
            mode: Reflection = "inner"
            for name, _ in node.count.terms:
                mode = values.reflections.get(name, mode)
            word = _repeated(base, count, mode)
            return word if len(word) <= most else None


def _repeated(base: Slots, count: int, reflection: Reflection) -> Slots:
    """Copies of a word; for a negative count, with mirror images (supplement 002, table 1).

    Inner modes mirror each copy beside it, outer ones all copies together. A pivot is the letter at the mirror, which
    is not doubled; with `pivot-total`, adjacent copies share a letter too.

    >>> def shown(count, reflection):
    ...     word = _repeated(tuple(map(Slot, "EkG")), count, reflection)
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
            unit = base + _mirrored(base)[1:]
            return unit + unit[1:] * (times - 1)


def _mirrored(word: Slots) -> Slots:
    return tuple(Slot(slot.symbol, slot.placeholder, not slot.mirrored) for slot in reversed(word))


def _check_depth(text: str) -> None:
    depth = 0
    for position, character in enumerate(text):
        depth += (character == "(") - (character == ")")
        if depth > _MAX_DEPTH:
            raise PatternError(f"expected groups nested at most {_MAX_DEPTH} deep", position)


@cache
def _parser() -> Lark:
    grammar = (Path(__file__).parent / "pattern.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", propagate_positions=True, maybe_placeholders=False)


def _explained(text: str, error: UnexpectedInput) -> PatternError:
    match error:
        case UnexpectedToken(token=token) if token.type != "$END":
            position, actual = token.start_pos or 0, f"{str(token)!r}"
        case UnexpectedCharacters(pos_in_stream=offset) if offset is not None and offset < len(text):
            position, actual = offset, f"{text[offset]!r}"
        case _:
            position, actual = len(text.rstrip()), "the end"
    expected_sets = (getattr(error, name, None) for name in ("accepts", "expected", "allowed"))
    accepted = set(next(filter(None, expected_sets), ()))
    signs = sorted(_TOKEN_WORDS[name] for name in accepted if name in _TOKEN_WORDS)
    hint = ""
    if text[position : position + 1] == "^":
        hint = "a number of copies follows a symbol or a group: (BA)^k, A^2, (BA)^{n - 1}"
    elif text[position : position + 1].isalnum() or text[position : position + 1] == "_":
        hint = "write names of more than one letter in braces: {wall}({window}{wall})^k"
    elif text[position : position + 1] == "{":
        hint = "expected a name between '{' and '}'"
    expected = f"expected {', '.join(signs[:-1])}{' or ' if signs[:-1] else ''}{signs[-1]}, " if signs else ""
    return PatternError(f"{expected}found {actual}", position, 1, hint)


@dataclass
class _Builder:
    """Makes the tree of one pattern."""

    text: str
    choices: int = 0
    open_powers: list[int] = field(default_factory=list)
    open_choices: list[int] = field(default_factory=list)

    def pattern(self, tree: Tree[Token]) -> LayerPattern:
        children = list(tree.children)
        body = self._node(children[0])
        contents: list[tuple[Sign, Node]] = []
        for symbol, content in zip(children[1::2], children[2::2], strict=True):
            sign = self._sign(cast(Token, symbol))
            if any(sign.symbol == other.symbol for other, _ in contents):
                raise PatternError(f"{sign.symbol} is given twice", sign.position, hint="one content per symbol")
            contents.append((sign, self._node(content)))
        pattern = LayerPattern(self.text, body, tuple(contents))
        self._check_contents(pattern)
        return pattern

    def _check_contents(self, pattern: LayerPattern) -> None:
        control = {node.symbol for node in LayerPattern("", pattern.body).nodes() if isinstance(node, Sign)}
        for sign, content in pattern.contents:
            if sign.symbol not in control:
                raise PatternError(
                    f"{sign.symbol} does not occur before the first ';'",
                    sign.position,
                    hint=f"a control pattern such as 'x {sign.symbol}; {sign.symbol} := A(BA)^k' contains it",
                )
            for node in LayerPattern("", content).nodes():
                if isinstance(node, Sign) and pattern.content_of(node.symbol) is not None:
                    raise PatternError(
                        f"{node.symbol} is a content inside a content: operations of one kind cannot be nested",
                        node.position,
                        hint="replace it by its content",
                    )

    def _node(self, tree: Any) -> Node:
        if tree.data == "letter":
            (child,) = tree.children
            return self._sign(child) if isinstance(child, Token) else self._node(child.children[0])
        if tree.data == "sequence":
            parts = tuple(self._node(child) for child in tree.children)
            return parts[0] if len(parts) == 1 else Row(parts)
        if tree.data == "power":
            return self._power(tree)
        return self._choice(tree)

    def _sign(self, token: Token) -> Sign:
        name, position = " ".join(str(token).strip("{}").split()), token.start_pos or 0
        if not name or not (name[0].isalpha() and name.isprintable()):
            raise PatternError(f"expected a name that begins with a letter, found {str(token)!r}", position, len(token))
        return Sign(name, position)

    def _power(self, tree: Any) -> Power:
        base, exponent = tree.children
        if self.open_powers:
            raise PatternError(
                "copies of copies: operations of one kind cannot be nested",
                exponent.start_pos,
                len(exponent),
                hint="write the inner copies out, or put them on a layer of their own",
            )
        self.open_powers.append(exponent.start_pos)
        node = Power(self._node(base), _linear(str(exponent), exponent.start_pos), exponent.start_pos)
        self.open_powers.pop()
        return node

    def _choice(self, tree: Any) -> Node:
        if len(tree.children) == 1:
            return self._node(tree.children[0])
        position = tree.meta.start_pos
        if self.open_choices:
            raise PatternError(
                "a choice inside a choice: operations of one kind cannot be nested",
                position,
                tree.meta.end_pos - position,
                hint="A|(B|C) is A|B|C",
            )
        number, self.choices = self.choices, self.choices + 1
        self.open_choices.append(position)
        options = tuple(self._node(child) for child in tree.children)
        self.open_choices.pop()
        return Alternatives(options, number)


def _linear(exponent: str, position: int) -> Linear:
    """The number of copies after a ``^``."""
    inside = exponent[1:].strip()
    text = inside[1:-1] if inside.startswith("{") else inside
    constant, factors, offset = 0, dict[str, int](), 0
    while offset < len(text) or not offset:
        match = _TERM.match(text, offset)
        if match is None or match.end() == offset or (offset and not match[1]):
            raise PatternError(
                f"expected a number of copies such as k, 3 or {{2n - 1}}, found {inside!r}", position, len(exponent)
            )
        sign, number, name = -1 if match[1] == "-" else 1, int(match[2] or 1), match[3] or match[4]
        if number > _MOST_COPIES:
            raise PatternError(f"expected at most {_MOST_COPIES:,} copies, found {number:,}", position, len(exponent))
        if name is None:
            constant += sign * number
        else:
            factors[name] = factors.get(name, 0) + sign * number
        offset = match.end()
    return Linear(constant, tuple(sorted((name, factor) for name, factor in factors.items() if factor)))
