"""Intermediate parts of definitions that are not nodes of the tree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from grammarlab.errors import Finding, Location
from grammarlab.language.parsing.tokens import Token
from grammarlab.language.syntax.tree import Array, Attribute, Choice, Expression, Name, Override, Rule, Variable


class MistakeError(Exception):
    """Text that the parser's grammar accepts but CGA does not allow."""

    def __init__(self, code: str, message: str, location: Location, hint: str = "") -> None:
        super().__init__(message)
        self.finding = Finding("error", code, message, location, hint)


@dataclass(frozen=True, slots=True)
class Version:
    """The version line."""

    text: str
    location: Location


@dataclass(frozen=True, slots=True)
class Vector:
    """``{1, 0, 0}``, allowed only in annotations."""

    array: Array

    @property
    def location(self) -> Location:
        return self.array.location


@dataclass(frozen=True, slots=True)
class Keyword:
    """``name = value`` between parentheses."""

    name: Token
    value: Expression | Vector


@dataclass(frozen=True, slots=True)
class Arguments:
    """Items between parentheses: arguments, parameters or styles."""

    items: tuple[Expression | Vector | Keyword | Rule, ...]
    end: Location

    def expressions(self) -> tuple[Expression, ...]:
        """Arguments of a call."""
        for item in self.items:
            if isinstance(item, Keyword):
                hint = "to compare, write '=='; a value is given by name only in annotations and imports"
                raise MistakeError("single-equals", "expected an expression, found '='", item.name.location, hint)
            if isinstance(item, Rule):
                hint = "a rule is redefined only in an import"
                raise MistakeError("misplaced-rule", "expected an expression, found a rule", item.location, hint)
            without_braces(item)
        return cast(tuple[Expression, ...], self.items)

    def names(self, what: str) -> tuple[str, ...]:
        """Parameters of a definition, or styles of an import."""
        names: list[str] = []
        for item in self.expressions():
            if not isinstance(item, Name) or "." in item.identifier:
                hint = "write Name(a, b): a definition has names in parentheses, a call has values"
                raise MistakeError("bad-parameter", f"expected the plain name of a {what}", item.location, hint)
            names.append(item.identifier)
        return tuple(names)

    def overrides(self) -> tuple[Override, ...]:
        """Redefinitions of a dynamic import."""
        result: list[Override] = []
        for item in self.items:
            if isinstance(item, Keyword):
                result.append(Attribute(item.name.value, without_braces(item.value), location=item.name.location))
            elif isinstance(item, Rule):
                result.append(item)
            else:
                hint = "write imported(height = 20).Rule"
                raise MistakeError("bad-override", "expected 'attribute = value'", item.location, hint)
        return tuple(result)


@dataclass(frozen=True, slots=True)
class Variables:
    items: tuple[Variable, ...]


@dataclass(frozen=True, slots=True)
class DefinitionHead:
    """Beginning of a definition."""

    name: Token
    parameters: tuple[str, ...] | None
    """Parameters; None without parentheses."""
    variables: tuple[Variable, ...]


@dataclass(frozen=True, slots=True)
class Branch:
    """A branch of a choice; `mark` is its ``case`` or the token where its percentage begins, None for ``else``."""

    mark: Token | None
    condition: Expression | None
    body: Choice


def without_braces(item: Expression | Vector) -> Expression:
    """An argument in a place where braces are not allowed."""
    if isinstance(item, Vector):
        message = "expected an expression, found '{'"
        raise MistakeError("misplaced-braces", message, item.array.location, "an array is written [1, 2, 3]")
    return item
