"""Finished measurements on disk, one JSON line each, so that a run can be interrupted anywhere and resumed."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from grammarlab.errors import GrammarlabError

MAX_BYTES = 1 << 28


class Kept:
    """Measurements by key: made once, and remembered in a file.

    Args:
        path: the file, made when missing; what a writer that was killed left of a last line is cut off.
        fresh: forget what it holds.

    Raises:
        GrammarlabError: when it is not one of ours.
    """

    def __init__(self, path: Path, *, fresh: bool = False) -> None:
        self._path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        if fresh:
            path.unlink(missing_ok=True)
        self._values = _read(path)

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def get(self, key: str, make: Callable[[], Mapping[str, Any]]) -> Mapping[str, Any]:
        """What is kept under a key; made and kept where there is nothing."""
        if key not in self._values:
            self.put(key, make())
        return self._values[key]

    def put(self, key: str, values: Mapping[str, Any]) -> None:
        """Keeps a measurement; after this returns it survives a crash of the machine."""
        self._values[key] = values
        line = json.dumps({"key": key, "values": values}, allow_nan=False) + "\n"
        with self._path.open("ab") as file:
            file.write(line.encode())
            file.flush()
            os.fsync(file.fileno())


def _read(path: Path) -> dict[str, Mapping[str, Any]]:
    if not path.is_file():
        return {}
    if path.stat().st_size > MAX_BYTES:
        raise GrammarlabError(f"{path} is larger than {MAX_BYTES:,} bytes. Start again with --fresh.")
    content = path.read_bytes()
    whole = content.rfind(b"\n") + 1
    if whole < len(content):
        with path.open("r+b") as file:
            file.truncate(whole)
    found: dict[str, Mapping[str, Any]] = {}
    for number, line in enumerate(content[:whole].splitlines(), 1):
        try:
            entry = json.loads(line)
            found[str(entry["key"])] = dict(entry["values"])
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise GrammarlabError(
                f"{path}:{number}: expected a measurement as grammarlab writes it, found {line[:60]!r}. "
                "Start again with --fresh, or write into another folder."
            ) from error
    return found
