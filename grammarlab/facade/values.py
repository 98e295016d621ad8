"""Checked values of JSON files from strangers, and units of length and up axes of meshes and scans.

Errors name the position of a value in its file.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from grammarlab import files
from grammarlab.errors import AssetError, FacadeError, shown

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048}
"""Length of units of files, metres."""
UP_AXES = {"z": [0, 1, 2], "y": [2, 0, 1]}
"""For each axis that may be up, the columns of points [P, 3] in the order along, across and up."""
MOST_BYTES = 128 * 2**20
"""Largest size of a file; its values may take twenty times the memory."""


def read_bounded(path: Path, most: int = MOST_BYTES) -> bytes:
    """The content of a file.

    Raises:
        FacadeError: If it is not a regular file, or longer than `most` bytes.
    """
    try:
        return files.read_bounded(path, most)
    except AssetError as error:
        raise FacadeError(str(error)) from error


def parse_json(content: bytes) -> Any:
    """The value of a JSON file.

    Raises:
        FacadeError: If it is not JSON, is nested too deep, or has numbers that are not finite.
    """
    try:
        return json.loads(content, parse_constant=_refuse)
    except RecursionError as error:
        raise FacadeError("This JSON is nested too deep.") from error
    except ValueError as error:  # invalid text, encoding, or an integer of too many digits
        raise FacadeError(f"This is not valid JSON: {error}.") from error


def an_object(value: Any, where: str) -> dict[str, Any]:
    """The value, if it is an object."""
    if not isinstance(value, dict):
        raise FacadeError(f"{where}: expected an object, found {shown(value)}.")
    return value


def a_list(value: Any, where: str, most: int) -> list[Any]:
    """The value, if it is a list of at most `most` entries."""
    if not isinstance(value, list):
        raise FacadeError(f"{where}: expected a list, found {shown(value)}.")
    if len(value) > most:
        raise FacadeError(f"{where}: expected at most {most:,} entries, found {len(value):,}.")
    return value


def a_number(value: Any, where: str) -> float:
    """The value as a finite number."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if math.isfinite(number):
            return number
    raise FacadeError(f"{where}: expected a finite number, found {shown(value)}.")


def a_whole_number(value: Any, where: str, low: int, end: int) -> int:
    """The value, if it is an integer in low <= value < end."""
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value < end:
        raise FacadeError(f"{where}: expected a whole number from {low} to {end - 1}, found {shown(value)}.")
    return value


def a_text(value: Any, where: str, most: int = 1_000) -> str:
    """The value, if it is a text of at most `most` characters that can be written."""
    if not isinstance(value, str) or len(value) > most:
        raise FacadeError(f"{where}: expected a text of at most {most} characters, found {shown(value)}.")
    if not is_unicode(value):
        raise FacadeError(f"{where}: expected Unicode text, found half of a character in {shown(value)}.")
    return value


def is_unicode(text: str) -> bool:
    r"""Whether a text can be written; JSON may have halves of characters, such as ``\ud800``."""
    return all(not 0xD800 <= ord(character) < 0xE000 for character in text)


def numbers(value: Any, where: str, count: int) -> list[float]:
    """The value, if it is a list of `count` finite numbers."""
    if len(a_list(value, where, count)) != count:
        raise FacadeError(f"{where}: expected {count} numbers, found {shown(value)}.")
    return [a_number(number, where) for number in value]


def _refuse(text: str) -> float:
    raise FacadeError(f"Expected finite numbers, found {text}.")
