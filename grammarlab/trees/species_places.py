"""Places of the values of a species file, for messages."""

from __future__ import annotations

import re
from typing import TypeAlias

from grammarlab.errors import Location

Path: TypeAlias = tuple[str | int, ...]
"""Keys from the outermost table to a value; the tables of a list are counted from 0: ``("kinds", 0, "ranges")``."""

_KEY = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')"""
_HEADER = re.compile(rf"^[ \t]*(\[\[?)[ \t]*({_KEY}(?:[ \t]*\.[ \t]*{_KEY}){{0,8}})[ \t]*\]")
_ENTRY = re.compile(rf"^[ \t]*({_KEY}(?:[ \t]*\.[ \t]*{_KEY}){{0,8}})[ \t]*=[ \t]*")
_VALUE = r"""(?:\[[^\]\n]{0,200}\]?|"[^"\n]*"?|'[^'\n]*'?|[^\s,}\]#]+)"""


class Places:
    """Lines and columns of the keys of a TOML text, as it is usually written.

    A place that is written in an unusual way has the place of the table around it.

    Args:
        text: the whole file.
        file: its name.
    """

    def __init__(self, text: str, file: str) -> None:
        self._file = file
        self._lines = text.split("\n")
        self._starts: dict[Path, tuple[int, int, int]] = {}
        """Index of the line of a key, and where the key and its value start there."""
        self._scan()

    def _scan(self) -> None:
        table: Path = ()
        counts: dict[Path, int] = {}
        for index, line in enumerate(self._lines):
            if header := _HEADER.match(line):
                table = _resolved(_keys(header[2]), counts)
                if header[1] == "[[":
                    counts[table] = counts.get(table, -1) + 1
                    table = (*table, counts[table])
                self._starts.setdefault(table, (index, header.start(1), header.start(2)))
            elif entry := _ENTRY.match(line):
                self._starts.setdefault((*table, *_keys(entry[1])), (index, entry.start(1), entry.end()))

    def of_value(self, path: Path) -> Location:
        """Place of a value, or of the smallest table around it whose place is clear."""
        if path in self._starts:
            index, _, start = self._starts[path]
            return self._location(index, start, _length(self._lines[index], start))
        return self._inner(path, to_value=True)

    def of_key(self, path: Path) -> Location:
        """Place of a key, or of the smallest table around it whose place is clear."""
        if path in self._starts:
            index, start, _ = self._starts[path]
            return self._location(index, start, max(1, len(str(path[-1]))))
        return self._inner(path, to_value=False)

    def _inner(self, path: Path, *, to_value: bool) -> Location:
        """Place of a value of a table within a line, such as ``scale = { value = 3.0 }``."""
        outer = path[:-1]
        while outer and outer not in self._starts:
            outer = outer[:-1]
        if outer not in self._starts:
            return Location(file=self._file)
        index, _, start = self._starts[outer]
        line = self._lines[index]
        key = re.compile(rf"""(?<![\w-])["']?{re.escape(str(path[-1]))}["']?[ \t]*=[ \t]*""").search(line, start)
        if key is None:
            return self._location(index, start, _length(line, start))
        if to_value:
            return self._location(index, key.end(), _length(line, key.end()))
        return self._location(index, key.start(), max(1, len(str(path[-1]))))

    def _location(self, index: int, start: int, length: int) -> Location:
        return Location(index + 1, start + 1, length, self._file)


def _keys(dotted: str) -> Path:
    return tuple(key.strip("\"'") for key in re.findall(_KEY, dotted))


def _resolved(keys: Path, counts: dict[Path, int]) -> Path:
    """The path of a table below the last item of each list of tables on the way."""
    path: Path = ()
    for key in keys[:-1]:
        path = (*path, key)
        if path in counts:
            path = (*path, counts[path])
    return (*path, keys[-1])


def _length(line: str, start: int) -> int:
    """Characters of the value that starts at a column."""
    match = re.compile(_VALUE).match(line, start)
    return max(1, len(match[0])) if match else 1
