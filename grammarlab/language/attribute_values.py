"""Values of attributes, from the command line and from files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from grammarlab.errors import UsageError
from grammarlab.language.checking.limits import objection
from grammarlab.language.grammar import Grammar
from grammarlab.language.lengths import length
from grammarlab.language.syntax.tree import Boolean, Call, Number, String, alternatives

AttributeValue: TypeAlias = float | bool | str
"""A plain value of an attribute."""

_BOOLEANS = {"true": True, "false": False}
_WIDEST = 60
"""Characters of a value that a message shows."""
_TRUTH = {"yes": "true", "1": "true", "no": "false", "0": "false"}


def read_attributes(texts: Iterable[str], grammar: Grammar) -> dict[str, AttributeValue]:
    """Attribute values from texts like ``height=12``, ``shops=true``, ``style=old``.

    The attribute's own value decides whether a text is a number, a bool or a string, if that value is a literal or a
    random number; otherwise the text decides.

    Args:
        texts: texts of the user.
        grammar: a grammar with these attributes.

    Raises:
        UsageError: If a text has no name or no ``=``, a name occurs twice, or a value has another type than its
            attribute or violates its annotations.

    >>> grammar = Grammar.parse('attr height = rand(3) attr style = "new" attr shops = false Lot --> NIL')
    >>> read_attributes(["height=12.5", "shops=true", "style=1900"], grammar)
    {'height': 12.5, 'shops': True, 'style': '1900'}
    """
    values: dict[str, AttributeValue] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not name:
            raise UsageError(f"attribute {text!r}: expected name=value, as in height=12 or style=old.")
        if name in values:
            raise UsageError(f"attribute {name!r} is given twice.")
        values[name] = _fitted(name, _unquoted(value), grammar)
        problem = objection(grammar.attributes[name], values[name]) if name in grammar.attributes else ""
        if problem:
            raise UsageError(f"attribute {name!r}: {problem}.")
    return values


@dataclass(frozen=True, slots=True)
class UsableProperties:
    """Properties with the names of a grammar's attributes."""

    values: Mapping[str, AttributeValue]
    """Values of the attributes' types."""
    problems: Mapping[str, str]
    """Message for each property that its attribute cannot take."""


def usable_properties(properties: Mapping[str, AttributeValue], grammar: Grammar) -> UsableProperties:
    """Properties of a footprint with the names of a grammar's attributes, as values of their types.

    Maps write numbers with units, such as ``12 m`` (see `length`), and truth as yes or no, 1 or 0.

    >>> grammar = Grammar.parse("attr height = 5 attr shops = false Lot --> NIL")
    >>> usable_properties({"height": "12 m", "shops": "yes", "name": "Town hall"}, grammar).values
    {'height': 12.0, 'shops': True}
    >>> usable_properties({"height": "tall"}, grammar).problems
    {'height': "attribute 'height': expected a finite number, found 'tall'"}
    """
    values: dict[str, AttributeValue] = {}
    problems: dict[str, str] = {}
    for name, attribute in grammar.attributes.items():
        if attribute.constant or name not in properties:
            continue
        try:
            values[name] = _fitted(name, _plain(_written(properties[name]), _kind(name, grammar)), grammar)
        except UsageError as error:
            problems[name] = str(error).rstrip(".")
    return UsableProperties(values, problems)


def fit_properties(properties: Mapping[str, AttributeValue], grammar: Grammar) -> dict[str, AttributeValue]:
    """The values of `usable_properties`.

    Raises:
        UsageError: If a value has another type.
    """
    usable = usable_properties(properties, grammar)
    for problem in usable.problems.values():
        raise UsageError(f"{problem}.")
    return dict(usable.values)


def _fitted(name: str, text: str, grammar: Grammar) -> AttributeValue:
    """Value of an attribute from a text."""
    kind = _kind(name, grammar)
    number = _number(text)
    if kind is String or (kind is None and number is None and text.lower() not in _BOOLEANS):
        return text
    if kind in (None, Boolean) and text.lower() in _BOOLEANS:
        return _BOOLEANS[text.lower()]
    if kind is Boolean:
        raise UsageError(f"attribute {name!r}: expected true or false, found {_shown(text)!r}.")
    if number is None or not math.isfinite(number):
        raise UsageError(f"attribute {name!r}: expected a finite number, found {_shown(text)!r}.")
    return number


def _shown(text: str) -> str:
    return text if len(text) <= _WIDEST else f"{text[:_WIDEST]}…"


def _plain(text: str, kind: type | None) -> str:
    """The text of a property without the habits of maps."""
    if kind is Boolean:
        return _TRUTH.get(text.strip().lower(), text)
    metres = length(text) if kind is Number else None
    return text if metres is None else repr(metres)


def _kind(name: str, grammar: Grammar) -> type | None:
    """Number, String or Boolean if the attribute's own value is such a literal or a random number, otherwise None."""
    if name not in grammar.attributes:
        return None
    leaves = alternatives(grammar.attributes[name].value)
    kinds = {Number if isinstance(leaf, Call) and leaf.function == "rand" else type(leaf) for leaf in leaves}
    return kinds.pop() if len(kinds) == 1 and kinds <= {Number, String, Boolean} else None


def _number(text: str) -> float | None:
    if "_" in text or not text.isascii():  # Python reads 1_000 as 1000
        return None
    try:
        return float(text)
    except ValueError:
        return None


def _unquoted(text: str) -> str:
    return text[1:-1] if len(text) >= 2 and text[0] == text[-1] == '"' else text


def _written(value: AttributeValue) -> str:
    if isinstance(value, str):
        return value
    return str(value).lower() if isinstance(value, bool) else f"{value:.17g}"
