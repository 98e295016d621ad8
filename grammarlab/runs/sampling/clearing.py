"""Removal of the files of an earlier run, and of nothing else."""

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
    """Remove the files of a run listed in its manifest and records, and both of these.

    Only plain files inside the folder are removed, for any content of the manifest.

    Args:
        folder: a folder with a manifest.
        name: name of the grammar of the new run.

    Raises:
        UsageError: If the earlier run has a grammar of another name, or the manifest is invalid; nothing is removed.
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
    """Name of the grammar of a run; None if the file is not a manifest."""
    try:
        name = json.loads(manifest.read_text(encoding="utf-8"))["grammar"]["name"]
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return name if isinstance(name, str) else None


def _listed(path: Path, member: str) -> Iterator[PurePosixPath]:
    """The names in one member of a JSON file, without paths out of the folder."""
    try:
        names: Any = json.loads(path.read_text(encoding="utf-8"))[member]
    except (OSError, ValueError, KeyError, TypeError):
        return
    for name in names if isinstance(names, dict) else ():
        file = PurePosixPath(name)
        if not file.is_absolute() and ".." not in file.parts and "\\" not in name and ":" not in name:
            yield file
