"""Values of attributes, from the command line and from maps, within the ranges of their annotations.

Maps write lengths with units: ``12 m``, ``7,5``, ``40 ft``, ``6'4"``.

Annotations are ``@Range(min=1, max=5)`` and ``@Enum("low", "high")``. As in CityEngine, they restrict values entered by
users, not values set by rules, and nothing with ``restricted=false``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from numbers import Real
from typing import NamedTuple, TypeAlias

from grammarlab.errors import UsageError, shown
from grammarlab.language.checking.percentages import constant
from grammarlab.language.grammar import Grammar
from grammarlab.language.syntax.printing import expression
from grammarlab.language.syntax.syntax_tree import (
    Annotation,
    Attribute,
    Boolean,
    Call,
    Expression,
    Number,
    String,
    alternatives,
)

_METRES = {
    **dict.fromkeys(("", "m", "metre", "metres", "meter", "meters"), 1.0),
    **dict.fromkeys(("km", "kilometre", "kilometres", "kilometer", "kilometers"), 1000.0),
    **dict.fromkeys(("cm", "centimetre", "centimetres", "centimeter", "centimeters"), 0.01),
    **dict.fromkeys(("mm", "millimetre", "millimetres", "millimeter", "millimeters"), 0.001),
    **dict.fromkeys(("ft", "foot", "feet", "'", "\u2032"), 0.3048),
    **dict.fromkeys(("in", "inch", "inches", '"', "\u2033"), 0.0254),
}
"""Metres of each unit; the foot is the international one."""
_MAX_LENGTH_CHARACTERS = 64
"""Characters of the longest text that is a length."""
_NUMBER = r"[-+]?\d+(?:[.,]\d+)?"
_LENGTH = re.compile(rf"\s*({_NUMBER})\s*([a-z]*|['\"\u2032\u2033])\.?\s*", re.IGNORECASE)
_FEET_AND_INCHES = re.compile(r"\s*(\d+)\s*(?:'|ft|\u2032)\s*(\d+(?:\.\d+)?)\s*(?:\"|in|\u2033)\s*", re.IGNORECASE)
_THOUSANDS = re.compile(r"[-+]?\d{1,3},\d{3}")
AttributeValue: TypeAlias = float | bool | str
"""A plain value of an attribute."""
_BOOLEANS = {"true": True, "false": False}
_MAX_SHOWN_CHARACTERS = 60
"""Characters of a value that a message shows."""
_MAX_NAMES = 12
"""Names of a file that a message lists."""
_OTHER_BOOLEANS = {"yes": "true", "1": "true", "no": "false", "0": "false"}


class _ExpectedType(NamedTuple):
    """Python types of the values of an attribute, and their description in messages."""

    types: tuple[type, ...]
    description: str


_TYPES: Mapping[type | None, _ExpectedType] = {
    Number: _ExpectedType((float,), "a finite number"),
    Boolean: _ExpectedType((bool,), "true or false"),
    String: _ExpectedType((str,), "a text"),
    None: _ExpectedType((float, bool, str), "a finite number, true, false or a text"),
}
"""Types of the values that an attribute takes, by the kind of its own value (`_kind`)."""


@dataclass(frozen=True, slots=True)
class UsableProperties:
    """Properties with the names of a grammar's attributes."""

    values: Mapping[str, AttributeValue]
    """Values of the attributes' types."""
    problems: Mapping[str, str]
    """Message for each property that its attribute cannot take."""


def named_values(texts: Iterable[str], examples: str) -> dict[str, str]:
    """Values, still as texts, by name from texts like ``height=12``.

    Args:
        texts: the texts.
        examples: right ones, for messages.

    Raises:
        UsageError: If a text has no name or no ``=``, or a name occurs twice.
    """
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not name:
            raise UsageError(f"attribute {text!r}: expected name=value, as in {examples}.")
        if name in values:
            raise UsageError(f"attribute {name!r} is given twice.")
        values[name] = value
    return values


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
    for name, value in named_values(texts, "height=12 or style=old").items():
        values[name] = _fitted(name, _unquoted(value), grammar)
        problem = objection(grammar.attributes[name], values[name]) if name in grammar.attributes else ""
        if problem:
            raise UsageError(f"attribute {name!r}: {problem}.")
    return values


def checked_attributes(values: Mapping[str, AttributeValue], grammar: Grammar) -> dict[str, AttributeValue]:
    """Attribute values of programs and files, checked; numbers become floats.

    Args:
        values: values by name.
        grammar: a grammar with these attributes.

    Raises:
        UsageError: If there is no such attribute, or a value has another type than its attribute, violates its
            annotations, or cannot be written in a rule file.

    >>> grammar = Grammar.parse('attr height = rand(3) attr style = "new" Lot --> NIL')
    >>> checked_attributes({"height": 12, "style": "old"}, grammar)
    {'height': 12.0, 'style': 'old'}
    """
    checked: dict[str, AttributeValue] = {}
    for name, value in values.items():
        if name not in grammar.attributes:
            raise UsageError(f"unknown attribute {name!r:.80}; {nearest_names(name, list(grammar.attributes))}")
        expected = _TYPES[_kind(name, grammar)]
        plain = plain_value(name, value)
        if not isinstance(plain, expected.types) or (isinstance(plain, float) and not math.isfinite(plain)):
            raise UsageError(f"attribute {name!r}: expected {expected.description}, found {shown(value)}.")
        if isinstance(plain, str) and any(not character.isprintable() for character in plain):
            raise UsageError(f"attribute {name!r}: expected a text of one line, found {shown(value)}.")
        if problem := objection(grammar.attributes[name], plain):
            raise UsageError(f"attribute {name!r}: {problem}.")
        checked[name] = plain
    return checked


def plain_value(name: str, value: AttributeValue) -> AttributeValue:
    """A number of any type, such as NumPy's, as a float; other values as they are.

    Args:
        name: name of the attribute, for messages.
        value: its value.

    Raises:
        UsageError: If it is a number that is too large.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        return value
    try:
        return float(value)
    except OverflowError:
        raise UsageError(f"attribute {name!r:.80}: expected a finite number, found {shown(value)}.") from None


def nearest_names(name: str, names: Sequence[str]) -> str:
    """End of a message about an unknown name: the nearest name, otherwise the first names.

    >>> nearest_names("heigth", ["height", "style"]), nearest_names("x", [])
    ("did you mean 'height'?", 'there are none')
    """
    near = get_close_matches(name[:_MAX_SHOWN_CHARACTERS], names, n=1, cutoff=0.6)
    if near:
        return f"did you mean {near[0]!r}?"
    rest = f" and {len(names) - _MAX_NAMES} more" if len(names) > _MAX_NAMES else ""
    return f"expected one of {', '.join(names[:_MAX_NAMES])}{rest}" if names else "there are none"


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


def objection(attribute: Attribute, value: AttributeValue) -> str:
    """Message about a forbidden value of an attribute, such as ``expected 1 to 5, found 9``; empty if it is allowed.

    >>> from grammarlab.language.grammar import Grammar
    >>> grammar = Grammar.parse("@Range(min=1, max=5) attr floors = 2 Lot --> NIL")
    >>> objection(grammar.attributes["floors"], 9.0), objection(grammar.attributes["floors"], 3.0)
    ('expected 1 to 5, found 9', '')
    """
    for annotation in attribute.annotations:
        name = annotation.name.lower()
        if any(key == "restricted" and node == Boolean(False) for key, node in annotation.arguments):
            continue
        expected = (
            _violated_range(annotation, value)
            if name == "range"
            else _violated_enumeration(annotation, value)
            if name == "enum"
            else ""
        )
        if expected:
            return f"expected {expected}, found {f'{value:g}' if isinstance(value, float) else value}"
    return ""


def length(text: str) -> float | None:
    """A length in metres; None if a text is not a length.

    A number without a unit is in metres. A comma is a decimal point, but ``1,200`` may also be twelve hundred, so it is
    not a length.

    >>> length("12 m"), length("7,5"), length("40 ft"), length("1,200"), length("about 12")
    (12.0, 7.5, 12.192, None, None)
    """
    if len(text) > _MAX_LENGTH_CHARACTERS:
        return None
    if match := _FEET_AND_INCHES.fullmatch(text):
        return round(float(match[1]) * 0.3048 + float(match[2]) * 0.0254, 9)
    match = _LENGTH.fullmatch(text)
    if match is None or match[2].lower() not in _METRES or _THOUSANDS.fullmatch(match[1]):
        return None
    unit = _METRES[match[2].lower()]
    value = float(match[1].replace(",", "."))
    return value if unit == 1.0 else round(value * unit, 9)


def _fitted(name: str, text: str, grammar: Grammar) -> AttributeValue:
    """Value of an attribute from a text."""
    kind = _kind(name, grammar)
    number = _number(text)
    if kind is String or (kind is None and number is None and text.lower() not in _BOOLEANS):
        return text
    if kind in (None, Boolean) and text.lower() in _BOOLEANS:
        return _BOOLEANS[text.lower()]
    if kind is Boolean:
        raise UsageError(f"attribute {name!r}: expected true or false, found {excerpt(text)!r}.")
    if number is None or not math.isfinite(number):
        raise UsageError(f"attribute {name!r}: expected a finite number, found {excerpt(text)!r}.")
    return number


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


def excerpt(text: str) -> str:
    """A text for a message, abbreviated."""
    return text if len(text) <= _MAX_SHOWN_CHARACTERS else f"{text[:_MAX_SHOWN_CHARACTERS]}…"


def _unquoted(text: str) -> str:
    return text[1:-1] if len(text) >= 2 and text[0] == text[-1] == '"' else text


def _violated_range(annotation: Annotation, value: AttributeValue) -> str:
    """The range that a number violates; empty if it is inside, or there is no range."""
    if isinstance(value, bool | str):
        return ""
    named = dict(annotation.arguments)
    plain = [node for key, node in annotation.arguments if not key]
    low, high = (named.get("min"), named.get("max")) if {"min", "max"} & named.keys() else (*plain, None, None)[:2]
    least, most = (None if node is None else constant(node) for node in (low, high))
    if (least is None or value >= least) and (most is None or value <= most):
        return ""
    if least is not None and most is not None:
        return f"{least:g} to {most:g}"
    return f"at most {most:g}" if least is None else f"at least {least:g}"


def _violated_enumeration(annotation: Annotation, value: AttributeValue) -> str:
    """The values of an enumeration that lacks a value; empty if it has the value, or there is no enumeration."""
    listed = [node for key, node in annotation.arguments if not key]
    if not listed or value in [_constant_value(node) for node in listed]:
        return ""
    return "one of " + ", ".join(expression(node).strip('"') for node in listed)


def _constant_value(node: Expression) -> AttributeValue | None:
    return node.value if isinstance(node, String | Boolean | Number) else constant(node)


def _plain(text: str, kind: type | None) -> str:
    """The text of a property without the habits of maps."""
    if kind is Boolean:
        return _OTHER_BOOLEANS.get(text.strip().lower(), text)
    metres = length(text) if kind is Number else None
    return text if metres is None else repr(metres)


def _written(value: AttributeValue) -> str:
    if isinstance(value, str):
        return value
    return str(value).lower() if isinstance(value, bool) else f"{value:.17g}"
