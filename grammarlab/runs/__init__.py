"""Whole runs: from the name of a grammar to files and pictures on disk, repeatable and resumable.

Names are looked up when they are first used, so that the command line can list grammars without loading the engine.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from grammarlab.geometry.outlines.footprints import Footprint, read_footprints
    from grammarlab.runs.disk.derivations import load_forest, save_forest
    from grammarlab.runs.requests.request import SampleRequest
    from grammarlab.runs.sampling.manifest import Manifest, read_manifest
    from grammarlab.runs.sampling.records import ModelRecord
    from grammarlab.runs.sampling.sample import RunResult, repeat_run, sample_run
    from grammarlab.runs.work.executors import AbstractExecutor, Processes, Serial

__all__ = [
    "AbstractExecutor",
    "Footprint",
    "Manifest",
    "ModelRecord",
    "Processes",
    "RunResult",
    "SampleRequest",
    "Serial",
    "load_forest",
    "read_footprints",
    "read_manifest",
    "repeat_run",
    "sample_run",
    "save_forest",
]

_MODULES = {
    "runs.disk.derivations": ("load_forest", "save_forest"),
    "runs.work.executors": ("AbstractExecutor", "Processes", "Serial"),
    "geometry.outlines.footprints": ("Footprint", "read_footprints"),
    "runs.sampling.manifest": ("Manifest", "read_manifest"),
    "runs.sampling.records": ("ModelRecord",),
    "runs.requests.request": ("SampleRequest",),
    "runs.sampling.sample": ("RunResult", "repeat_run", "sample_run"),
}
_HOME = {name: f"grammarlab.{module}" for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
