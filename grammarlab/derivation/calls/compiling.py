"""Interface of the compiler of expressions in arguments, heads of parts and arrays."""

from __future__ import annotations

from typing import Protocol

from grammarlab.derivation.state.workspace import Code
from grammarlab.language.syntax.tree import Choice, Expression


class Compiler(Protocol):
    """Compiles the expressions of one definition."""

    def expression(self, node: Expression) -> Code:
        """Code for one expression."""
        ...

    def choice(self, choice: Choice) -> Code:
        """Code for a choice whose leaves are expressions."""
        ...

    def with_selectors(self, selectors: frozenset[str]) -> Compiler:
        """A compiler for expressions in which these words are selectors of a block."""
        ...
