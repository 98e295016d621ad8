"""Finished measurements on disk, one JSON line each, so that a run can be interrupted anywhere and resumed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from grammarlab.runs.evaluate import json_lines


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
        self._values = dict(json_lines.read(path, _parse, "a measurement"))

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
        json_lines.append(self._path, {"key": key, "values": values})


def _parse(entry: Any) -> tuple[str, Mapping[str, Any]]:
    return str(entry["key"]), dict(entry["values"])
