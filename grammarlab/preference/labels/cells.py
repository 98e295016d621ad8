"""Cells of label files as values: numbers and blanks as spreadsheets and other programs write them."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from decimal import Decimal

from grammarlab.errors import UsageError
from grammarlab.tables import Table

_DIGITS = re.compile(r"-?[0-9]{1,4300}")
_WITH_ZEROS = re.compile(r"(-?[0-9]{1,4300})[.,](0+)")
_ROUNDED = re.compile(r"-?[0-9]+([.,][0-9]+)?[eE]\+?[0-9]+")
_EXACT = 1 << 53
"""Integers below this are exact as floats of 64 bits."""
_NO_SCORE = frozenset(("", "nan", "na", "n/a", "#n/a", "null", "none"))

number: Callable[[str], float | None] = Table(",", ()).number
"""A text with a decimal point as a finite number; None if it is not one."""


def whole(name: str, value: object) -> object:
    """A whole number as an integer, such as ``17``, ``17.0`` or ``"17"``; any other value unchanged.

    Args:
        name: name of the column, for messages.
        value: a cell.

    Raises:
        UsageError: If digits may have been lost, or the number may be two.

    >>> [whole("model", value) for value in ("17", "17.0", 17.0, "17,0", "1_000", "1e3x", "١٧")]
    [17, 17, 17, 17, '1_000', '1e3x', '١٧']
    """
    if isinstance(value, str):
        return _whole_text(name, value)
    if isinstance(value, float | Decimal) and math.isfinite(value) and value == int(value):
        if isinstance(value, float) and abs(value) >= _EXACT:
            raise UsageError(f"{name}: {value:.17g} is rounded: {_KEEP}")
        return int(value)
    return value


_KEEP = "integers of more than 15 digits lose some in spreadsheets and in floats. Keep this column as text."


def _whole_text(name: str, text: str) -> object:
    text = text.strip()
    if _DIGITS.fullmatch(text):
        return int(text)
    match = _WITH_ZEROS.fullmatch(text)
    if match is not None:
        if len(match[2]) == 3:
            raise UsageError(
                f"{name}: {text[:40]} may be {match[1][:40]} or a thousand times as much: write one number."
            )
        return int(match[1])
    if _ROUNDED.fullmatch(text):
        raise UsageError(f"{name}: {text[:40]} is rounded: {_KEEP}")
    return text


def score(value: object, read_number: Callable[[str], float | None] = number) -> object:
    """A score as a number, None for a blank or missing one; any other value unchanged.

    Args:
        value: a cell.
        read_number: reads a text.

    >>> [score(value) for value in (3, "12.5", " ", "NaN", float("nan"), "good")]
    [3, 12.5, None, None, None, 'good']
    """
    if isinstance(value, str):
        if value.strip().lower() in _NO_SCORE:
            return None
        result = read_number(value.strip())
        return value if result is None else result
    if isinstance(value, Decimal):
        value = float(value)
    return None if isinstance(value, float) and math.isnan(value) else value


def is_blank(value: object) -> bool:
    """Whether a cell of text has no value."""
    return value is None or value == "" or (isinstance(value, float) and math.isnan(value))
