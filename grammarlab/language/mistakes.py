"""What a syntax error means: expected, found, and what to try."""

from __future__ import annotations

from grammarlab.errors import Finding
from grammarlab.language.tokens import Token


def explain(tokens: tuple[Token, ...], position: int, expected: frozenset[str]) -> Finding:
    """The finding for a token that cannot stand where it stands.

    Args:
        tokens: the tokens of the definition.
        position: index of the token; past the last one when the definition ends too early.
        expected: token types that could stand there.
    """
    token = tokens[min(position, len(tokens) - 1)]
    return Finding("error", "syntax", f"unexpected {token.value} {sorted(expected)}", token.location)
