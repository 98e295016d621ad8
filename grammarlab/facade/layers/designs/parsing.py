"""Parser of patterns: text becomes a `LayerPattern`; errors have positions in the text."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, cast

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from grammarlab.facade.layers.designs.patterns import Alternatives, LayerPattern, Linear, Node, Power, Row, Sign

MOST_CHARACTERS = 2_000
"""Largest number of characters of a pattern."""
_DEEPEST = 40
"""Largest depth of nested groups."""
_MOST_COPIES = 100_000
_TERM = re.compile(r"\s*([+-]?)\s*(?:([0-9]+)\s*\*?\s*([^\W\d_]\w*)?|([^\W\d_]\w*))\s*")
_SIGNS = {"LPAR": "'('", "RPAR": "')'", "VBAR": "'|'", "SEMICOLON": "';'", "SYMBOL": "a symbol", "EXPONENT": "'^'"}


@dataclass(frozen=True)
class PatternError(Exception):
    """A mistake in the text of a pattern."""

    message: str
    place: int
    """Character index in the text, from 0."""
    length: int = 1
    hint: str = ""


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


@cache
def _parser() -> Lark:
    grammar = (Path(__file__).parent / "pattern.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", propagate_positions=True, maybe_placeholders=False)


def _check_depth(text: str) -> None:
    depth = 0
    for place, character in enumerate(text):
        depth += (character == "(") - (character == ")")
        if depth > _DEEPEST:
            raise PatternError(f"expected groups nested at most {_DEEPEST} deep", place)


def _explained(text: str, error: UnexpectedInput) -> PatternError:
    match error:
        case UnexpectedToken(token=token) if token.type != "$END":
            place, found = token.start_pos or 0, f"{str(token)!r}"
        case UnexpectedCharacters(pos_in_stream=at) if at is not None and at < len(text):
            place, found = at, f"{text[at]!r}"
        case _:
            place, found = len(text.rstrip()), "the end"
    known = (getattr(error, name, None) for name in ("accepts", "expected", "allowed"))
    accepted = set(next(filter(None, known), ()))
    wanted = sorted(_SIGNS[name] for name in accepted if name in _SIGNS)
    hint = ""
    if text[place : place + 1] == "^":
        hint = "a number of copies follows a symbol or a group: (BA)^k, A^2, (BA)^{n - 1}"
    elif text[place : place + 1].isalnum() or text[place : place + 1] == "_":
        hint = "write names of more than one letter in braces: {wall}({window}{wall})^k"
    elif text[place : place + 1] == "{":
        hint = "expected a name between '{' and '}'"
    expected = f"expected {', '.join(wanted[:-1])}{' or ' if wanted[:-1] else ''}{wanted[-1]}, " if wanted else ""
    return PatternError(f"{expected}found {found}", place, 1, hint)


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
                raise PatternError(f"{sign.symbol} is given twice", sign.place, hint="one content per symbol")
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
                    sign.place,
                    hint=f"a control pattern such as 'x {sign.symbol}; {sign.symbol} := A(BA)^k' contains it",
                )
            for node in LayerPattern("", content).nodes():
                if isinstance(node, Sign) and pattern.content_of(node.symbol) is not None:
                    raise PatternError(
                        f"{node.symbol} is a content inside a content: operations of one kind cannot be nested",
                        node.place,
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
        name, place = " ".join(str(token).strip("{}").split()), token.start_pos or 0
        if not name or not (name[0].isalpha() and name.isprintable()):
            raise PatternError(f"expected a name that begins with a letter, found {str(token)!r}", place, len(token))
        return Sign(name, place)

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
        place = tree.meta.start_pos
        if self.open_choices:
            raise PatternError(
                "a choice inside a choice: operations of one kind cannot be nested",
                place,
                tree.meta.end_pos - place,
                hint="A|(B|C) is A|B|C",
            )
        number, self.choices = self.choices, self.choices + 1
        self.open_choices.append(place)
        options = tuple(self._node(child) for child in tree.children)
        self.open_choices.pop()
        return Alternatives(options, number)


def _linear(exponent: str, place: int) -> Linear:
    """The number of copies after a ``^``."""
    inside = exponent[1:].strip()
    text = inside[1:-1] if inside.startswith("{") else inside
    constant, factors, at = 0, dict[str, int](), 0
    while at < len(text) or not at:
        match = _TERM.match(text, at)
        if match is None or match.end() == at or (at and not match[1]):
            raise PatternError(
                f"expected a number of copies such as k, 3 or {{2n - 1}}, found {inside!r}", place, len(exponent)
            )
        sign, number, name = -1 if match[1] == "-" else 1, int(match[2] or 1), match[3] or match[4]
        if number > _MOST_COPIES:
            raise PatternError(f"expected at most {_MOST_COPIES:,} copies, found {number:,}", place, len(exponent))
        if name is None:
            constant += sign * number
        else:
            factors[name] = factors.get(name, 0) + sign * number
        at = match.end()
    return Linear(constant, tuple(sorted((name, factor) for name, factor in factors.items() if factor)))
