"""Parts of ``split`` without a size, as in older rule files: ``split(x) { 1 : A | split(y) { ~1 : B }* }``.

Such a part takes the remaining length. Only a part that begins with a block can be distinguished from a size.
"""

from __future__ import annotations

from collections.abc import Sequence

from grammarlab.language.parsing.tokens import Token

_OPEN, _SHUT = frozenset({"_LPAR", "_LBRACE", "_LBRACKET"}), frozenset({"RPAR", "CLOSE", "RBRACKET"})


def with_sizes(tokens: Sequence[Token]) -> list[Token]:
    """Words of a definition, with ``~1 :`` before parts of ``split`` that have no size."""
    if not any(token.value == "split" for token in tokens):
        return list(tokens)
    partners = _partners(tokens)
    is_split = [False]
    result: list[Token] = []
    for place, token in enumerate(tokens):
        begins = place > 0 and tokens[place - 1].type in ("_LBRACE", "_BAR")
        if is_split[-1] and begins and _is_block_alone(tokens, place, partners):
            mark = Token("PREFIX", "~", token.location, token.start, token.start)
            result += [mark, mark._replace(type="NUMBER", value="1"), mark._replace(type="_COLON", value=":")]
        if token.type in _OPEN:
            is_group = token.type == "_LBRACE" and (
                _follows_split(tokens, place, partners) or (is_split[-1] and begins)
            )
            is_split.append(is_group)
        elif token.type in _SHUT and len(is_split) > 1:
            is_split.pop()
        result.append(token)
    return result


def _partners(tokens: Sequence[Token]) -> dict[int, int]:
    """Index of the matching bracket, by index of each bracket."""
    partners: dict[int, int] = {}
    waiting: list[int] = []
    for place, token in enumerate(tokens):
        if token.type in _OPEN:
            waiting.append(place)
        elif token.type in _SHUT and waiting:
            first = waiting.pop()
            partners[first], partners[place] = place, first
    return partners


def _follows_split(tokens: Sequence[Token], place: int, partners: dict[int, int]) -> bool:
    """Whether the brace at a place opens the block of a ``split(...)``."""
    before = partners.get(place - 1, 0)
    return before > 0 and tokens[place - 1].type == "RPAR" and tokens[before - 1].value == "split"


def _is_block_alone(tokens: Sequence[Token], place: int, partners: dict[int, int]) -> bool:
    """Whether a whole part is an operation with a block."""
    if tokens[place].type != "NAME":
        return False
    following = place + 1
    if following < len(tokens) and tokens[following].type == "_LPAR":
        following = partners.get(following, len(tokens)) + 1
    if following >= len(tokens) or tokens[following].type != "_LBRACE":
        return False
    after = partners.get(following, len(tokens)) + 1
    return after < len(tokens) and tokens[after].type in ("_BAR", "CLOSE")
