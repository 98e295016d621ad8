"""Arrays on disk by key, so that features are counted once for all curves and all runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from grammarlab.evaluation.preparation import Arrays, Keep
from grammarlab.runs.results import ARRAYS, Results


def keep_in(folder: Path) -> Keep:
    """A memory in a folder, made when missing; deleting any of it costs nothing but time."""
    results = Results(folder, ARRAYS, lasting=False)

    def keep(key: str, make: Callable[[], Arrays]) -> Arrays:
        found = results.get(key)
        if found is None:
            found = make()
            results.put(key, found)
        return found

    return keep
