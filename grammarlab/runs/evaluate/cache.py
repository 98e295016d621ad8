"""Arrays on disk by key, so that features are counted once for all curves and all runs."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from grammarlab.evaluation.preparation import Arrays, Keep
from grammarlab.files import atomic_file


def keep_in(folder: Path) -> Keep:
    """A memory in a folder, made when missing; deleting any of it costs nothing but time."""

    def keep(key: str, make: Callable[[], Arrays]) -> Arrays:
        path = folder / f"{key}.npz"
        found = _read(path)
        if found is not None:
            return found
        arrays = make()
        folder.mkdir(parents=True, exist_ok=True)
        with atomic_file(path) as part:
            np.savez_compressed(part, allow_pickle=False, **arrays)
        return arrays

    return keep


def _read(path: Path) -> Arrays | None:
    """The arrays of a file; None when it is missing or broken."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return dict(arrays)
    except (OSError, ValueError, TypeError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
        return None
