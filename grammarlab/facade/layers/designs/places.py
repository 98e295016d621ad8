"""Locations of values in a TOML text, for messages."""

from __future__ import annotations

import re
from collections.abc import Sequence

from grammarlab.errors import Location

_HEADER = re.compile(r"\s*\[+\s*([^\[\]]+?)\s*\]+\s*(?:#.*)?$")


def place_of(
    text: str, file: str, table: str, index: int | None, keys: Sequence[str], value: object = None
) -> Location:
    """Location of a value, or of the closest enclosing entry that is found.

    Args:
        text: content of the file.
        file: name of the file.
        table: name of a top-level table.
        index: index in an array of tables.
        keys: keys from the table down to the value.
        value: the value, if the mistake is inside a text: then the location is that of its first character.
    """
    names = [table, *keys]
    best, depth, found, rest = Location(file=file), 0, -1, names if index is None else []
    for number, content in enumerate(text.splitlines(), start=1):
        header = _HEADER.match(content)
        if header:
            path = [part.strip().strip("\"'") for part in header[1].split(".")]
            found += header[0].lstrip().startswith("[[") and path == [table]
            inside = path == names[: len(path)] and (index is None or found == index)
            rest = names[len(path) :] if inside else []
            if inside and len(path) > depth:
                best, depth = Location(number, content.index("[") + 1, file=file), len(path)
            continue
        matched, after = _matched(content, rest)
        if matched and len(names) - len(rest) + matched > depth:
            depth = len(names) - len(rest) + matched
            best = Location(number, _value_column(content, after, value), file=file)
    return best


def _matched(content: str, keys: Sequence[str]) -> tuple[int, int]:
    """Number of leading keys of a line that match in order, and the index of the character after the last one."""
    at = 0
    for number, key in enumerate(keys):
        quoted = rf"(?:{re.escape(key)}|\"{re.escape(key)}\"|'{re.escape(key)}')"
        before = r"\s*" if not number else r"(?:\s*\.\s*|\s*=\s*\{.*?(?<![\w-]))"
        match = re.compile(before + quoted + r"(?=\s*[.=])").match(content, at)
        if match is None:
            return number, at
        at = match.end()
    return len(keys), at


def _value_column(content: str, after: int, value: object) -> int:
    equals = content.find("=", after)
    start = equals + 1 + len(content[equals + 1 :]) - len(content[equals + 1 :].lstrip()) if equals >= 0 else after
    inside = content.find(value, start) if isinstance(value, str) else -1
    return (inside if inside >= 0 else start) + 1
