"""Beginning of an expression from its end: the percentage before ``%``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from grammarlab.language.parsing.tokens import Token

_OPERAND_ENDS = frozenset({"NAME", "NUMBER", "RPAR", "RBRACKET", "BOOLEAN"})
_OPERATORS = frozenset({"OPERATOR", "SIGN"})


def expression_start(tokens: Sequence[Token], partner: Mapping[int, int], index: int) -> int:
    """Index of the first token of the expression whose last token is at `index`.

    No token separates a percentage from the operation before it: in ``A (b)% : C`` only the space shows that the
    percentage is ``(b)`` and not ``A(b)``.

    Args:
        tokens: the tokens of the file.
        partner: index of the opening bracket by index of the closing one.
        index: where to begin, at least -1.
    """
    while True:
        index = max(_operand_start(tokens, partner, index), 0)
        while index and _is_prefix(tokens, index - 1):
            index -= 1
        if index == 0 or tokens[index - 1].type not in _OPERATORS:
            return index
        index -= 2


def _is_prefix(tokens: Sequence[Token], index: int) -> bool:
    if tokens[index].type == "PREFIX":
        return True
    return tokens[index].type == "SIGN" and (index == 0 or tokens[index - 1].type not in _OPERAND_ENDS)


def _operand_start(tokens: Sequence[Token], partner: Mapping[int, int], index: int) -> int:
    """Step over ``name``, ``name(...)``, ``(...)``, ``[...]`` and ``name[...][...]``."""
    while index in partner and tokens[index].type in ("RPAR", "RBRACKET"):
        bracket = tokens[index].type
        index = partner[index]
        before = tokens[index - 1] if index else None
        if before is None or before.end != tokens[index].start:
            return index
        if before.type == "NAME":
            return index - 1
        if bracket == "RPAR" or before.type not in ("RPAR", "RBRACKET"):
            return index
        index -= 1
    return index
