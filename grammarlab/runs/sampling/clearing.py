"""Removing the files of an earlier run, and nothing else."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

from grammarlab.errors import UsageError
from grammarlab.runs.sampling.manifest import MANIFEST
from grammarlab.runs.sampling.records import DERIVATIONS, RECORD


def clear_run(folder: Path, name: str) -> None:
    """Remove what the manifest and the records in a folder say a run made, and both of them.

    Only plain files inside the folder are touched, whatever the manifest says.

    Args:
        folder: one that holds a file of the name of a manifest.
        name: of the grammar whose run is to take the place of the earlier one.

    Raises:
        UsageError: the earlier run was of a grammar of another name, or the manifest is not ours; nothing is removed.
    """
    earlier = _name_of_grammar(folder / MANIFEST)
    if earlier != name:
        other = f"a {MANIFEST} that no run wrote" if earlier is None else f"models of another grammar, {earlier!r}"
        raise UsageError(f"{folder} holds {other}. Write into another folder with -o.")
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


def _name_of_grammar(manifest: Path) -> str | None:
    """What the grammar of a run is called; None where the file is no manifest."""
    try:
        name = json.loads(manifest.read_text(encoding="utf-8"))["grammar"]["name"]
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return name if isinstance(name, str) else None


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
