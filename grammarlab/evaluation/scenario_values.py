"""Typed values of TOML files, and objects from lists of names; errors name the line and the expected value."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar

from grammarlab.errors import AssetError, TomlError, UsageError
from grammarlab.files import read_bounded
from grammarlab.toml_text import toml_table, toml_text

_Named = TypeVar("_Named")
SUFFIX = ".toml"
MAX_BYTES = 1 << 18
"""Largest size of a file in bytes."""
_MAX_CHARACTERS = 1000
"""Largest number of characters of a text."""
_MAX_ITEMS = 100
"""Largest number of items of a list."""


class TomlFile:
    """A parsed TOML file with the lines of its values.

    Args:
        text: the whole file.
        path: path of the file, for messages.
    """

    def __init__(self, text: str, path: Path) -> None:
        self.path = path
        self._text = text

    def table(self) -> dict[str, Any]:
        """All of it."""
        try:
            return toml_table(self._text)
        except TomlError as error:
            raise self.wrong(error.message, line=error.line) from None

    def part(self, table: dict[str, Any], key: str, allowed: Sequence[str]) -> dict[str, Any]:
        """A subtable, empty if it is missing; ``allowed`` are the allowed keys."""
        part = table.get(key, {})
        if not isinstance(part, dict):
            raise self.wrong(f"expected a table [{key}], found {part!r:.40}", key)
        self.check_keys(part, allowed, key)
        return part

    def string(self, table: dict[str, Any], key: str, default: str | None = None) -> str:
        """A text; required and not empty if there is no default."""
        value = table.get(key, default)
        if not isinstance(value, str) or (default is None and not value.strip()) or len(value) > _MAX_CHARACTERS:
            raise self.wrong(f"expected {key} = a text of 1 to {_MAX_CHARACTERS} characters, found {value!r:.40}", key)
        return value

    def strings(self, table: dict[str, Any], key: str, default: tuple[str, ...]) -> tuple[str, ...]:
        """A list of texts."""
        value = table.get(key, list(default))
        if not isinstance(value, list) or len(value) > _MAX_ITEMS or not all(isinstance(item, str) for item in value):
            raise self.wrong(f"expected {key} = a list of texts, found {value!r:.40}", key)
        return tuple(value)

    def one_of(self, table: dict[str, Any], key: str, allowed: tuple[str, ...]) -> str:
        """One of several texts; the first of them if the key is missing."""
        value = table.get(key, allowed[0])
        if value not in allowed:
            raise self.wrong(
                f"expected {key} = {' or '.join(repr(item) for item in allowed)}, found {value!r:.40}", key
            )
        return value

    def integer(self, table: dict[str, Any], key: str, low: int, high: int) -> int | None:
        """A whole number from ``low`` to ``high``; None if the key is missing."""
        value = table.get(key)
        if key in table and (isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high):
            raise self.wrong(f"expected {key} = a whole number from {low} to {high}, found {value!r:.40}", key)
        return value

    def number(self, table: dict[str, Any], key: str, high: float, line: int | None = None) -> float | None:
        """A number from 0 to ``high``; None if the key is missing."""
        value = table.get(key)
        if key not in table:
            return None
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= high:
            raise self.wrong(f"expected {key} = a number from 0 to {high:g}, found {value!r:.40}", key, line)
        return float(value)

    def check_keys(
        self, table: dict[str, Any], allowed: Sequence[str], part: str = "", line: int | None = None
    ) -> None:
        """Check that a table, called ``part``, has only known keys."""
        for key in table:
            if key not in allowed:
                where = f" in [{part}]" if part else ""
                raise self.wrong(f"unknown key {key!r:.60}{where}{nearest(key, allowed)}", key, line)

    def line(self, pattern: str, number: int = 0) -> int | None:
        """Line, from 1, of the match ``number``, from 0, of a regular expression; None if there is none."""
        starts = [match.start() for match in re.finditer(pattern, self._text, re.MULTILINE)]
        return self._text.count("\n", 0, starts[number]) + 1 if number < len(starts) else None

    def wrong(self, message: str, key: str | None = None, line: int | None = None) -> UsageError:
        """An error about a line, or about the first line that sets a key."""
        if key is not None and line is None:
            line = self.line(rf"^[ \t]*(?:\[+[ \t]*)?[\"']?{re.escape(key)}[\"']?[ \t]*[=.\]]")
        return UsageError(f"{self.path}{f':{line}' if line else ''}: {message}")


def chosen_one(name: str, objects: Mapping[str, _Named], what: str) -> _Named:
    """Object from a single name; for the arguments see `chosen`.

    Raises:
        UsageError: If the name is unknown, or there are several names.
    """
    matches = chosen(name, objects, what)
    if len(matches) != 1:
        raise UsageError(f"expected one {what}, found {len(matches)} in {name!r}.")
    return matches[0]


def chosen(names: str, objects: Mapping[str, _Named], what: str) -> tuple[_Named, ...]:
    """Objects from a comma-separated list, in its order.

    Args:
        names: ``default,paper``; each name once.
        objects: all objects by name.
        what: noun for one of them, for messages: ``method``.

    Raises:
        UsageError: If a name is unknown, repeated or missing.
    """
    requested = [name.strip() for name in names.split(",") if name.strip()]
    if not requested:
        raise UsageError(f"which {what}s? Give names from: {', '.join(objects)}; several with commas between.")
    for name in requested:
        if name not in objects:
            near = get_close_matches(name, objects, n=1)
            hint = f" Did you mean {near[0]!r}?" if near else ""
            raise UsageError(f"unknown {what} {name!r}.{hint} Expected one of {', '.join(objects)}.")
        if requested.count(name) > 1:
            raise UsageError(f"{what} {name!r} is given twice.")
    return tuple(objects[name] for name in requested)


def read(path: Path, what: str) -> str:
    """Text of a file.

    Args:
        path: the file.
        what: expected kind of file, for messages: ``scenario``.

    Raises:
        UsageError: If the file is missing, unreadable, too large or not in UTF-8.
    """
    if not path.exists() or path.is_dir():
        near = get_close_matches(path.name, [p.name for p in path.parent.glob(f"*{SUFFIX}")], n=3, cutoff=0.5)
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        raise UsageError(f"no {what} file {str(path)!r}{hint}")
    try:
        return toml_text(read_bounded(path, MAX_BYTES))
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror or error}") from None
    except AssetError as error:
        raise UsageError(f"{error} A {what} is a short text file.") from None
    except TomlError as error:
        raise UsageError(f"{path}{f':{error.line}' if error.line else ''}: {error.message}") from None


def nearest(name: str, names: Sequence[str]) -> str:
    """Suggestion at the end of a message."""
    near = get_close_matches(name, names, n=1, cutoff=0.6)
    return f"; did you mean {near[0]}?" if near else f"; expected {', '.join(names)}"
