"""Members of JSON objects from strangers: their types are checked before use, and errors name their position."""

from __future__ import annotations

import math
from typing import Any, TypeVar

from grammarlab.errors import AssetError, shown

Kind = TypeVar("Kind", str, bool, int, dict, list)

_WORDS = {str: "a text", bool: "true or false", int: "a whole number", dict: "an object", list: "a list"}


def member(values: Any, name: str, kind: type[Kind], where: str = "") -> Kind:
    """A member of an object.

    Args:
        values: expected to be an object.
        name: name of the member.
        kind: type of the member.
        where: position of the object in the file, for messages: ``grammar``; empty for the whole file.

    Raises:
        AssetError: If there is none, or it has another type.
    """
    values = of_kind(values, dict, where or "the file")
    position = f"{where}.{name}" if where else name
    if name not in values:
        raise AssetError(f"{position} is missing.")
    return of_kind(values[name], kind, position)


def of_kind(value: Any, kind: type[Kind], where: str) -> Kind:
    """A value, if it has a type.

    Raises:
        AssetError: If it has another one.
    """
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise AssetError(f"{where}: expected {_WORDS[kind]}, found {shown(value)}.")  # ty: ignore[invalid-argument-type]
    if isinstance(value, str) and _has_lone_surrogates(value):
        raise AssetError(f"{where}: expected a text, found characters that no text has: {shown(value)}.")
    return value


def texts(values: Any, name: str, where: str = "") -> dict[str, str]:
    """A member that is an object of texts.

    Raises:
        AssetError: If there is none, or it has another type.
    """
    entries = member(values, name, dict, where)
    return {key: of_kind(text, str, f"{where}{'.' * bool(where)}{name}.{key}") for key, text in entries.items()}


def plain_values(value: Any, where: str) -> dict[str, float | bool | str]:
    """An object of texts, finite numbers, and true or false.

    Raises:
        AssetError: If it is another value.
    """
    return {key: _plain(entry, f"{where}.{key}") for key, entry in of_kind(value, dict, where).items()}


def numbers(value: Any, count: int, where: str) -> list[float]:
    """A list of finite numbers.

    Raises:
        AssetError: If it is not a list of `count` finite numbers.
    """
    entries = of_kind(value, list, where)
    if len(entries) != count or not all(_is_finite(entry) for entry in entries):
        raise AssetError(f"{where}: expected {count} finite numbers, found {shown(value)}.")
    return [float(entry) for entry in entries]


def _has_lone_surrogates(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return True
    return False


def _plain(value: Any, where: str) -> float | bool | str:
    if isinstance(value, bool) or _is_finite(value):
        return value
    if isinstance(value, str):
        return of_kind(value, str, where)
    raise AssetError(f"{where}: expected a text, a finite number, true or false, found {shown(value)}.")


def _is_finite(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number of too many digits
        return False
