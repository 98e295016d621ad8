"""TOML from strangers: text in UTF-8, values of bounded size and depth, mistakes with line and column."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from grammarlab.errors import TomlError

_OTHER_ENCODINGS = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16"}
MOST_KEY_PARTS = 64
"""Largest number of parts of a dotted key; the time to read one grows with the square of its length."""
_LONG_KEY = re.compile(rf"""(?<![\w-])(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){{{MOST_KEY_PARTS}}}""")
_LONG_NUMBER = re.compile(r"(?<![\w.])(?:0[xob][0-9a-fA-F_]{17,}|[0-9][0-9_]{18,})(?![\w.])")
_PLACE = re.compile(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)$")


def toml_text(content: bytes) -> str:
    r"""The text of a TOML file, without its byte order mark and with the line end ``\n``.

    Raises:
        TomlError: If it is not text in UTF-8, which the format requires.

    >>> toml_text("\ufefftitle = 'Grüße'\r\n".encode())
    "title = 'Grüße'\n"
    """
    encoding = _OTHER_ENCODINGS.get(content[:2]) or ("UTF-16" if b"\0" in content[:4] else "")
    if encoding:
        raise TomlError(f"expected text in UTF-8, found {encoding}: save the file as UTF-8")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        before = content[: error.start]
        line = before.count(b"\n") + 1
        column = len(before[before.rfind(b"\n") + 1 :].decode("utf-8", "replace")) + 1
        message = f"expected text in UTF-8; byte {error.start} is not: save the file as UTF-8"
        raise TomlError(message, line, column) from error


def toml_table(text: str) -> dict[str, Any]:
    r"""The values of a TOML text.

    Raises:
        TomlError: If it is not TOML, is nested too deep, or has a key of more than `MOST_KEY_PARTS` parts or an integer
            of more than 64 bits.

    >>> toml_table("size = { width = 6.0 }")
    {'size': {'width': 6.0}}
    >>> toml_table("a = 1\nb = ")
    Traceback (most recent call last):
    grammarlab.errors.TomlError: this is not TOML: Invalid value (line 2, column 5)
    """
    if key := _LONG_KEY.search(text):
        raise TomlError(f"expected a key of at most {MOST_KEY_PARTS} parts", *_line_and_column(text, key.start()))
    table: dict[str, Any] | None = None
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        position = _PLACE.search(message)
        end = _line_and_column(text, len(text))
        line, column = (int(position[1]), int(position[2])) if position and position[1] else end
        raise TomlError(f"this is not TOML: {_PLACE.sub('', message)}", line, column) from error
    except RecursionError:
        pass  # of thousands of frames, which are no part of the error below
    except ValueError as error:  # an integer of too many digits for Python
        raise _too_large(text) from error
    if table is None:
        raise TomlError("the arrays or tables are nested too deep")
    if _has_large_integers(table):
        raise _too_large(text)
    return table


def _too_large(text: str) -> TomlError:
    number = _LONG_NUMBER.search(text)
    position = _line_and_column(text, number.start()) if number else (None, None)
    return TomlError("expected a number, an integer of at most 64 bits", *position)


def _has_large_integers(table: dict[str, Any]) -> bool:
    """Whether there are integers that other readers of TOML do not have, and that Python may refuse to print."""
    pending: list[Any] = [table]
    while pending:
        value = pending.pop()
        if isinstance(value, int) and value.bit_length() > 64:
            return True
        if isinstance(value, dict):
            pending += value.values()
        elif isinstance(value, list):
            pending += value
    return False


def _line_and_column(text: str, offset: int) -> tuple[int, int]:
    """Line and column, from 1, of an offset."""
    return text.count("\n", 0, offset) + 1, offset - text.rfind("\n", 0, offset)
