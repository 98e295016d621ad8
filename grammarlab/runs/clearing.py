"""Removing the files of an earlier run, and nothing else."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

from grammarlab.runs.manifest import MANIFEST
from grammarlab.runs.records import DERIVATIONS, RECORD


def clear_run(folder: Path) -> None:
    """Remove what the manifest and the records in a folder say a run made, and both of them.

    Only plain files inside the folder are touched, whatever the manifest says.
    """
    batches = folder / DERIVATIONS
    records = sorted(batches.glob(f"*/{RECORD}"))
    made = set(_listed(folder / MANIFEST, "files"))
    for record in records:
        made |= set(_listed(record, "hashes"))
    for file in made:
        (folder / file).unlink(missing_ok=True)
    for record in records:
        shutil.rmtree(record.parent)
    if batches.is_dir() and not any(batches.iterdir()):
        batches.rmdir()
    (folder / MANIFEST).unlink(missing_ok=True)


def _listed(path: Path, member: str) -> Iterator[PurePosixPath]:
    """The names in one member of a JSON file, without those that lead out of the folder."""
    try:
        names: Any = json.loads(path.read_text(encoding="utf-8"))[member]
    except (OSError, ValueError, KeyError, TypeError):
        return
    for name in names if isinstance(names, dict) else ():
        file = PurePosixPath(name)
        if not file.is_absolute() and ".." not in file.parts and "\\" not in name and ":" not in name:
            yield file
