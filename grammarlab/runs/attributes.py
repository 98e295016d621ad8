"""Values for attributes, as people type them."""

from __future__ import annotations

import math
from collections.abc import Iterable

from grammarlab.errors import UsageError
from grammarlab.runs.request import AttributeValue

_BOOLEANS = {"true": True, "false": False}


def read_attributes(texts: Iterable[str]) -> dict[str, AttributeValue]:
    """Attribute values from texts like ``height=12``, ``shops=true``, ``style=old``.

    A text in double quotes is always a string: ``code="12"``.

    Raises:
        UsageError: when a text has no name or no ``=``, or a name comes twice.

    >>> read_attributes(["height=12.5", "shops=true", "style=old town", 'code="12"'])
    {'height': 12.5, 'shops': True, 'style': 'old town', 'code': '12'}
    """
    values: dict[str, AttributeValue] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name:
            raise UsageError(f"attribute {text!r}: expected name=value, as in height=12 or style=old.")
        if name in values:
            raise UsageError(f"attribute {name!r} is given twice.")
        values[name] = _value(value.strip())
    return values


def _value(text: str) -> AttributeValue:
    if text.lower() in _BOOLEANS:
        return _BOOLEANS[text.lower()]
    if len(text) >= 2 and text[0] == text[-1] == '"':
        return text[1:-1]
    try:
        number = float(text)
    except ValueError:
        return text
    if not math.isfinite(number):
        raise UsageError(f"attribute value {text!r}: expected a finite number.")
    return number
