"""Whole runs: from the name of a grammar to files and pictures on disk, repeatable and resumable."""

from grammarlab.runs.derivations import load_forest, save_forest
from grammarlab.runs.footprints import Footprint, read_footprints
from grammarlab.runs.manifest import Manifest, read_manifest
from grammarlab.runs.records import ModelRecord
from grammarlab.runs.request import SampleRequest
from grammarlab.runs.sample import RunResult, repeat_run, sample_run
from grammarlab.runs.workers import available_cores

__all__ = [
    "Footprint",
    "Manifest",
    "ModelRecord",
    "RunResult",
    "SampleRequest",
    "available_cores",
    "load_forest",
    "read_footprints",
    "read_manifest",
    "repeat_run",
    "sample_run",
    "save_forest",
]
