"""Checked values of JSON files that may come from a stranger: sizes are bounded, and messages name the value."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import AssetError, shown

MOST_TEXT = 256
"""Most characters of a text, unless another number is given."""
MOST_CRS = 20_000
"""Most characters of a coordinate system, which may be WKT."""
_MOST_ROWS = 1024
"""Most rows of a matrix."""
_LARGEST = 1e9
"""Largest size of a number, for sums without overflow."""


class JsonValueError(AssetError):
    """A value that is not as expected; the name of the file is added where it is caught."""


class JsonValues:
    """Checked values of an object; each method raises `JsonValueError` for another value.

    Args:
        values: the object.
        where: its place in the file, which begins the names of its values.
    """

    def __init__(self, values: Any, where: str = "") -> None:
        if not isinstance(values, dict):
            raise JsonValueError(f"{where[:-1] or 'file'}: expected an object, found {shown(values)}.")
        self.values: dict[str, Any] = values
        self.where = where

    def get(self, key: str) -> Any:
        """A value that must be there."""
        if key not in self.values:
            raise JsonValueError(f"{self.where}{key}: expected a value, found none.")
        return self.values[key]

    def text(self, key: str, most: int = MOST_TEXT) -> str:
        """A line of at most so many characters."""
        return self._text(self.get(key), key, most)

    def texts(self, key: str, most: int) -> list[str]:
        """At most so many texts."""
        return [self._text(item, f"{key}[{index}]", MOST_TEXT) for index, item in enumerate(self._items(key, most))]

    def number(self, key: str) -> float:
        """A number."""
        return self._number(self.get(key), key)

    def positive(self, key: str) -> float:
        """A number > 0."""
        number = self.number(key)
        if number < 1 / _LARGEST:
            raise JsonValueError(f"{self.where}{key}: expected a number > 0, found {number:g}.")
        return number

    def amount(self, key: str, most: float) -> float:
        """A number from 0 on."""
        number = self.number(key)
        if not 0.0 <= number <= most:
            raise JsonValueError(f"{self.where}{key}: expected a number from 0 to {most:g}, found {number:g}.")
        return number

    def numbers(self, key: str, count: int) -> list[float]:
        """So many numbers."""
        return self._row(self.get(key), key, count)

    def matrix(self, key: str, count: int | None, width: int) -> Floats:
        """[count, width] numbers; with any number of rows if the count is None."""
        rows = self._items(key, _MOST_ROWS)
        if count is not None and len(rows) != count:
            raise JsonValueError(f"{self.where}{key}: expected {count} rows, found {len(rows)}.")
        checked = [self._row(row, f"{key}[{index}]", width) for index, row in enumerate(rows)]
        return np.array(checked, np.float64).reshape(-1, width)

    def table(self, key: str) -> JsonValues:
        """An object."""
        return JsonValues(self.get(key), f"{self.where}{key}.")

    def tables(self, key: str, most: int) -> list[JsonValues]:
        """At most so many objects."""
        return [JsonValues(item, f"{self.where}{key}[{index}].") for index, item in enumerate(self._items(key, most))]

    def _items(self, key: str, most: int) -> Sequence[Any]:
        items = self.get(key)
        if not isinstance(items, list) or len(items) > most:
            raise JsonValueError(f"{self.where}{key}: expected a list of at most {most}, found {shown(items)}.")
        return items

    def _row(self, value: Any, key: str, count: int) -> list[float]:
        if not isinstance(value, list) or len(value) != count:
            raise JsonValueError(f"{self.where}{key}: expected {count} numbers, found {shown(value)}.")
        return [self._number(item, f"{key}[{index}]") for index, item in enumerate(value)]

    def _number(self, value: Any, key: str) -> float:
        # Integers of many digits are compared before they are made floats, which they may not fit.
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not -_LARGEST <= value <= _LARGEST or math.isnan(value):
            raise JsonValueError(f"{self.where}{key}: expected a number of at most {_LARGEST:g}, found {shown(value)}.")
        return float(value)

    def _text(self, value: Any, key: str, most: int) -> str:
        if not isinstance(value, str) or len(value) > most or not value.isprintable():
            raise JsonValueError(
                f"{self.where}{key}: expected a line of at most {most} characters, found {shown(value)}."
            )
        return value


def lines_of_json(values: Mapping[str, Any]) -> str:
    """The text of an object: a line per key."""
    lines = [f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in values.items()]
    return "{" + ",\n ".join(lines) + "}\n"


def values_of_json(content: bytes, kind: str, version: int) -> JsonValues:
    """The values of a file.

    Args:
        content: the whole file.
        kind: its ``format``.
        version: its ``version``.

    Raises:
        JsonValueError: If it is not such a file.
    """
    values = JsonValues(_json(content))
    if values.get("format") != kind:
        raise JsonValueError(f"format: expected {kind!r}, found {shown(values.get('format'))}.")
    if values.get("version") != version:
        found = shown(values.get("version"))
        raise JsonValueError(f"version: expected {version}, found {found}: learn the file again, or update grammarlab.")
    return values


def _json(content: bytes) -> Any:
    try:
        return json.loads(content)
    except RecursionError as error:
        raise JsonValueError("this JSON is nested too deep.") from error
    except ValueError as error:  # invalid text, encoding, or an integer of too many digits
        raise JsonValueError(f"this is not valid JSON: {error}.") from error
