"""Files that a command wrote into a folder, so that its next run removes them and nothing else."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from grammarlab.errors import AssetError
from grammarlab.files import file_below, file_hash, read_bounded, write_text

WRITTEN = ".grammarlab.json"
"""SHA-256 of each file by command and by path relative to the folder."""
_MOST_BYTES = 1 << 24


def replace_written(folder: Path, command: str, files: Iterable[Path], sources: Iterable[Path] = ()) -> None:
    """Remove files of the earlier run of a command that are not among its new files, and record the new ones.

    A file that was changed since stays, and so does one that a link leads to.

    Args:
        folder: folder of the command's output.
        command: name of the command.
        files: all files below the folder that the command has written now.
        sources: inputs of the command, which are not removed even if an earlier run wrote them.
    """
    record = _record(folder)
    inputs = [path for path in sources if path.exists()]
    written = {path.relative_to(folder).as_posix(): file_hash(path) for path in files}
    for name, digest in record.get(command, {}).items():
        file = None if name in written else file_below(folder, name)
        if file is None or any(map(file.samefile, inputs)):
            continue
        if file_hash(file) == digest:
            file.unlink()
    record[command] = dict(sorted(written.items()))
    write_text(folder / WRITTEN, json.dumps(record, indent=1, ensure_ascii=False) + "\n")


def _record(folder: Path) -> dict[str, Mapping[str, Any]]:
    """The record in a folder, perhaps of a stranger; empty if there is none."""
    try:
        values = json.loads(read_bounded(folder / WRITTEN, _MOST_BYTES))
    except (AssetError, OSError, ValueError, RecursionError):
        return {}
    if not isinstance(values, dict):
        return {}
    return {command: files for command, files in values.items() if isinstance(files, dict)}
