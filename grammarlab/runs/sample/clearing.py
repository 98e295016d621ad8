"""Removal of the files of an earlier run, and of nothing else."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grammarlab.errors import AssetError, UsageError
from grammarlab.files import folder_below, is_inside, read_bounded
from grammarlab.runs.sample.manifest import MANIFEST, MAX_FILE_BYTES
from grammarlab.runs.sample.models import cut_batches
from grammarlab.runs.sample.records import DERIVATIONS, RECORD, is_unchanged, recorded_files
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.work.run_folder import own_folder

_BATCH = re.compile(r"\d{5,}")
_FILE = re.compile(r"(?:-(\d{5,}))?(_texture_\d+|_plan)?\.(glb|obj|mtl|ply|usdz?|stl|3mf|png|jpg)")
"""Names of the files of models and of the sheet after the name of the grammar."""
_PLAN = "_plan"
"""End of the name of the plan of a stand of trees."""
_MAX_NAMES = 5
"""Largest number of names in a message."""


@dataclass(frozen=True, slots=True)
class EarlierRun:
    """Files of an earlier run in a folder."""

    records: tuple[str, ...]
    """Records of its batches; this and the next fields are paths relative to the folder."""
    unchanged: tuple[str, ...]
    """Listed files that are as the run wrote them."""
    changed: tuple[str, ...]
    """Listed files that differ, or that a link leads to."""
    unlisted: tuple[str, ...]
    """Other files that have names of models or of the sheet."""
    interrupted: bool
    """Whether the run may have written the unlisted files."""


def find_run(folder: Path, name: str) -> EarlierRun:
    """The files that an earlier run wrote into a folder, by its manifest and records.

    Args:
        folder: folder of the new run; without a manifest, records count for nothing, and all files are unlisted. A
            run of another grammar that failed before it wrote any file is no run.
        name: name of the grammar of the new run.

    Raises:
        UsageError: If the earlier run has files of a grammar of another name, or the manifest is invalid.
    """
    candidates = {path.name for path in folder.iterdir() if _parts_of_name(name, path.name)}
    no_run = EarlierRun((), (), (), tuple(sorted(candidates)), interrupted=False)
    if not (folder / MANIFEST).is_file():
        return no_run
    values = _json(folder / MANIFEST)
    earlier = _name_of_grammar(values)
    if earlier != name:
        if earlier is not None and _failed_early(folder, values, earlier):
            return no_run
        content = f"a {MANIFEST} that no run wrote" if earlier is None else f"models of {earlier!r}"
        raise UsageError(f"{folder} holds {content}. Write into another folder with -o.")
    records = tuple(f"{DERIVATIONS}/{batch}/{RECORD}" for batch in batch_names(folder))
    records = tuple(record for record in records if recorded_files(folder, record))
    files = values.get("files")
    hashes: dict[str, Any] = dict(files) if isinstance(files, dict) else {}
    for record in records:
        hashes |= recorded_files(folder, record)
    present = [name for name in sorted(hashes) if is_inside(name) and _exists(folder, name)]
    # Hashes are computed here only, since this takes a second per gigabyte.
    unchanged = tuple(name for name in present if is_unchanged(folder, name, hashes[name]))
    return EarlierRun(
        records=records,
        unchanged=unchanged,
        changed=tuple(name for name in present if name not in set(unchanged)),
        unlisted=tuple(sorted(candidates - hashes.keys())),
        interrupted=values.get("complete") is False,
    )


def check_kept(folder: Path, run: EarlierRun, request: SampleRequest) -> tuple[str, ...]:
    """Refuse to write over files that no manifest lists, or that were changed since.

    Returns:
        Files that differ from what the earlier run recorded, or that it did not come to record; they stay.

    Raises:
        UsageError: If a new run would write over one.
    """
    foreign = () if run.interrupted else run.unlisted
    for reason, names in (
        ("changed after the run that wrote them", run.changed),
        ("not listed in a manifest", foreign),
    ):
        lost = [name for name in names if _is_written(request, name)]
        if lost:
            raise UsageError(
                f"{folder}: {reason}, and a new run would replace them: {in_short(lost)}. "
                "Move or remove them, or write into another folder with -o."
            )
    unfinished = [name for name in run.unlisted if run.interrupted and not _is_written(request, name)]
    return (*run.changed, *unfinished)


def clear_run(folder: Path, run: EarlierRun) -> None:
    """Remove the unchanged files of a run, its records and its manifest, and folders that are empty then."""
    for name in (*run.unchanged, *run.records):
        (folder / name).unlink(missing_ok=True)
    for name in (*(f"{DERIVATIONS}/{batch}" for batch in batch_names(folder)), DERIVATIONS):
        inner = folder_below(folder, name)
        if inner is not None and not any(inner.iterdir()):
            inner.rmdir()
    (folder / MANIFEST).unlink(missing_ok=True)


def batch_names(folder: Path) -> tuple[str, ...]:
    """Names of the folders of batches in a folder of a run, in order.

    Raises:
        UsageError: If a link stands in place of one of them, or of the folder of all.
    """
    batches = own_folder(folder, DERIVATIONS)
    names = sorted(path.name for path in batches.iterdir() if _BATCH.fullmatch(path.name)) if batches else ()
    for name in names:
        own_folder(folder, f"{DERIVATIONS}/{name}")
    return tuple(names)


def in_short(names: Collection[str]) -> str:
    """Some names and the number of others, for a message; names of strangers may have any characters."""
    printable = ["".join(letter if letter.isprintable() else "?" for letter in name) for name in sorted(names)]
    rest = f" and {len(printable) - _MAX_NAMES:,} more" if len(printable) > _MAX_NAMES else ""
    return ", ".join(printable[:_MAX_NAMES]) + rest


def _is_written(request: SampleRequest, name: str) -> bool:
    """Whether the run of a request writes a file of a name."""
    batch = re.fullmatch(rf"{DERIVATIONS}/(\d{{5,}})/.*", name)
    if batch:
        return int(batch[1]) < len(cut_batches(request))
    parts = _parts_of_name(request.name, name)
    if parts is None:
        return False
    index, texture, suffix = parts
    if index is None and suffix == "png" and request.image and (not texture or texture == _PLAN):
        return not texture or request.stand is not None  # the sheet and the plan
    suffixes = {"obj": ("png", "jpg") if texture else ("obj", "mtl")}.get(request.file_format, (request.file_format,))
    is_model = index is None if request.single_file else index is not None and int(index) in request.model_numbers
    return is_model and suffix in suffixes


def _parts_of_name(grammar: str, name: str) -> tuple[str | None, str | None, str] | None:
    """Index, texture or plan, and suffix in the name of a file; None if no run of a grammar gives such a name."""
    match = _FILE.fullmatch(name.removeprefix(grammar)) if name.startswith(grammar) else None
    return None if match is None else (match[1], match[2], match[3])


def _failed_early(folder: Path, values: Mapping[str, Any], grammar: str) -> bool:
    """Whether a run of a grammar has written its manifest and nothing else."""
    if values.get("complete") is not False or values.get("files") or batch_names(folder):
        return False
    return not any(_parts_of_name(grammar, path.name) for path in folder.iterdir())


def _name_of_grammar(values: Mapping[str, Any]) -> str | None:
    """Name of the grammar of a run; None if the values are not those of a manifest."""
    grammar = values.get("grammar")
    name = grammar.get("name") if isinstance(grammar, dict) else None
    return name if isinstance(name, str) else None


def _json(path: Path) -> Mapping[str, Any]:
    """The members of a JSON file; none if it is not an object."""
    try:
        values = json.loads(read_bounded(path, MAX_FILE_BYTES))
    except (AssetError, ValueError, RecursionError):
        return {}
    return values if isinstance(values, dict) else {}


def _exists(folder: Path, name: str) -> bool:
    try:
        return os.path.lexists(folder / name)
    except ValueError:  # not a name
        return False
