"""Where things stand in a TOML text, for messages."""

from __future__ import annotations

import re
from collections.abc import Sequence

from grammarlab.errors import Location

_HEADER = re.compile(r"\s*\[+\s*([^\[\]]+?)\s*\]+\s*(?:#.*)?$")


def place_of(
    text: str, file: str, table: str, index: int | None, keys: Sequence[str], value: object = None
) -> Location:
    """Where a value stands, or as much of the way to it as is found.

    Args:
        text: the file.
        file: its name.
        table: a table at the top.
        index: which one of an array of tables.
        keys: from the table down to the value.
        value: the value, if it is a text that a mistake is in: then the place is that of its first character.
    """
    line, column, found = 1, 1, -1
    names = [table, *keys]
    at_table = False
    for number, content in enumerate(text.splitlines(), start=1):
        header = _HEADER.match(content)
        if header:
            path = [part.strip().strip("\"'") for part in header[1].split(".")]
            found += header[0].lstrip().startswith("[[") and path == [table]
            at_table = path == names[: len(path)] and (index is None or found == index)
            if at_table:
                line, column = number, content.index("[") + 1
                rest = names[len(path) :]
                if not rest:
                    break
            continue
        after = _after(content, names[1:] if at_table else names) if (at_table or index is None) else None
        if after is None and at_table:
            after = _after(content, rest)
        if after is not None:
            return Location(number, _value_column(content, after, value), file=file)
    return Location(line, column, file=file)


def _after(content: str, keys: Sequence[str]) -> int | None:
    """The character after the last of some keys of a line, which follow each other and begin it."""
    at = 0
    for number, key in enumerate(keys):
        quoted = rf"(?:{re.escape(key)}|\"{re.escape(key)}\"|'{re.escape(key)}')"
        before = r"\s*" if not number else r"(?:\s*\.\s*|\s*=\s*\{.*?(?<![\w-]))"
        match = re.compile(before + quoted + r"(?=\s*[.=])").match(content, at)
        if match is None:
            return at if number else None
        at = match.end()
    return at


def _value_column(content: str, after: int, value: object) -> int:
    equals = content.find("=", after)
    start = equals + 1 + len(content[equals + 1 :]) - len(content[equals + 1 :].lstrip()) if equals >= 0 else after
    if isinstance(value, str):
        inside = content.find(value, start)
        return inside + 1 if inside >= 0 else start + 1
    return start + 1
