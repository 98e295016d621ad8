"""Finished results on disk, one file per key, so that a run can be interrupted anywhere and resumed.

Any number of processes may write into one folder, since files are written atomically. A damaged file counts as
missing, so its result is computed again.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Generic, TypeVar

from grammarlab.errors import AssetError
from grammarlab.files import atomic_file, file_below, open_regular, read_bounded
from grammarlab.runs.work.executors import AbstractExecutor, Task
from grammarlab.runs.work.workers import reporting

Value = TypeVar("Value")
Progress = Callable[[str, int, int], None]
"""Function called with the name of a task, the number of finished parts, and the number of all parts."""

MAX_BYTES = 1 << 28
"""Largest size of a file."""
KEY = re.compile(r"[0-9a-f]{64}(-\d+)?")
"""Keys of results that `Results.clear` removes: SHA-256 of their inputs, and perhaps a size."""
_DAMAGES = (
    AssetError,
    OSError,
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    EOFError,
    OverflowError,
    MemoryError,
    RecursionError,
)


@dataclass(frozen=True, slots=True)
class Kind(Generic[Value]):
    """Format of results."""

    suffix: str
    write: Callable[[BinaryIO, Value], None]
    read: Callable[[BinaryIO], Value]
    """Read a result; any exception means a damaged file."""
    most: int = MAX_BYTES
    """Largest size of a file."""


def json_kind(to_json: Callable[[Value], Any], from_json: Callable[[Any], Value]) -> Kind[Value]:
    """Results as JSON, to the last bit."""

    def write(file: BinaryIO, value: Value) -> None:
        file.write(json.dumps(to_json(value), indent=1).encode() + b"\n")

    return Kind(".json", write, lambda file: from_json(json.load(file)))


@dataclass(frozen=True, slots=True)
class Results(Generic[Value]):
    """Results of a folder, which is made with the first of them."""

    folder: Path
    kind: Kind[Value]
    lasting: bool = True
    """Whether each survives a power failure after it is stored; see `grammarlab.files.atomic_file`."""

    def get(self, key: str) -> Value | None:
        """Result of a key; None if it is missing or damaged."""
        try:
            with open_regular(self._path(key), self.kind.most) as file:
                return self.kind.read(file)
        except _DAMAGES:
            return None

    def put(self, key: str, value: Value) -> None:
        """Store a result; an earlier one of the key is replaced."""
        self.folder.mkdir(parents=True, exist_ok=True)
        with atomic_file(self._path(key), lasting=self.lasting) as part, part.open("wb") as file:
            self.kind.write(file, value)

    def all(self) -> dict[str, Value]:
        """All results by key."""
        keys = sorted(path.stem for path in self._files())
        entries = ((key, self.get(key)) for key in keys)
        return {key: value for key, value in entries if value is not None}

    def clear(self) -> None:
        """Remove all results with hashes as keys; nothing else, and nothing if the folder is a link."""
        for path in self._files():
            if KEY.fullmatch(path.stem) and file_below(self.folder.parent, f"{self.folder.name}/{path.name}"):
                path.unlink(missing_ok=True)

    def _files(self) -> Iterator[Path]:
        return (path for path in self.folder.glob(f"*{self.kind.suffix}") if not path.name.startswith("."))

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}{self.kind.suffix}"


def computed(
    results: Results[Value],
    work: Callable[[Task], Value],
    tasks: Mapping[str, Task],
    executor: AbstractExecutor,
    what: str,
    on_progress: Progress,
) -> dict[str, Value]:
    """Results of tasks: stored ones, and the others, each stored when it is finished.

    Args:
        results: storage of results.
        work: does a task; other processes must be able to import it.
        tasks: tasks by the keys of their results.
        executor: runs the tasks.
        what: name of the results for `on_progress`.
        on_progress: called with the number of finished results, and with what tasks report.

    Returns:
        The results, by key, in the order of the tasks.
    """
    values = {key: value for key in tasks if (value := results.get(key)) is not None}
    missing = [key for key in tasks if key not in values]
    on_progress(what, len(values), len(tasks))

    def finish(index: int, value: Value) -> None:
        results.put(missing[index], value)
        values[missing[index]] = value
        on_progress(what, len(values), len(tasks))

    with reporting(on_progress):
        executor.run(work, [tasks[key] for key in missing], finish)
    return {key: values[key] for key in tasks}


def adopt_lines(results: Results[Value], lines: Path, entry_of: Callable[[Any], tuple[str, Value]]) -> None:
    """Import results that an earlier version stored as lines of one JSON file; damaged lines are skipped.

    Args:
        results: storage, in which existing keys are kept.
        lines: the file; it may be missing.
        entry_of: key and result of a line; any exception means a damaged line.
    """
    try:
        content = read_bounded(lines, MAX_BYTES)
    except _DAMAGES:
        return
    for line in content.splitlines():
        try:
            key, value = entry_of(json.loads(line))
        except _DAMAGES:
            continue
        # A file may contain anything, such as a key with a path.
        if key.replace("-", "").isalnum() and results.get(key) is None:
            results.put(key, value)
