"""What arguments, heads of parts and arrays ask of the compiler of the expressions in them."""

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
        """The same for expressions in which these words stand for what a block's selectors pick."""
        ...
