"""Finished measurements on disk."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from grammarlab.runs.disk.results import Results, adopt_lines, json_kind

_KIND = json_kind(dict, dict)


def measurements_in(folder: Path, name: str, *, fresh: bool = False) -> Results[dict[str, Any]]:
    """The measurements of a folder, JSON objects by key.

    Args:
        folder: folder of a run.
        name: name of the folder in it; with the suffix .jsonl, of the file of earlier versions.
        fresh: remove stored measurements first.
    """
    kept, earlier = Results(folder / name, _KIND), (folder / name).with_suffix(".jsonl")
    if fresh:
        kept.clear()
        earlier.unlink(missing_ok=True)
    adopt_lines(kept, earlier, lambda entry: (str(entry["key"]), dict(entry["values"])))
    return kept


def digest(values: object) -> str:
    """SHA-256 of JSON values, as a key."""
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()
