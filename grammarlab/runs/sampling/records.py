"""What a run says about each model, kept beside the derivations so that an interrupted run can go on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from grammarlab.derivation.forest import MissingAsset
from grammarlab.errors import Location
from grammarlab.runs.disk.results import Results, json_kind
from grammarlab.runs.requests.batches import Batch

DERIVATIONS = "derivations"
"""Folder with one folder a batch, each as `grammarlab.runs.disk.derivations` describes it, and these records."""
_KEY = "models"
RECORD = f"{_KEY}.json"


@dataclass(frozen=True, slots=True)
class ModelRecord:
    """One finished model."""

    index: int
    """Its address is (seed, index)."""
    file: str
    """Path relative to the run's folder; the shared file when there is one for all."""
    seed: int
    shapes: int
    """Nodes of the derivation tree; parts of a model that has none."""
    triangles: int
    log_probability: float | None
    """Natural logarithm of the density of its random draws; None where that is not known."""
    reports: Mapping[str, Mapping[str, float | int | None]] = field(default_factory=dict)
    """What ``report`` collected, by key: see `grammarlab.runs.models.reports`."""
    origin: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Where in the world the model's own coordinates begin, in metres; a GLB moves them there by a node."""
    tries: int = 1
    """Candidates that it took until one was accepted (`grammarlab.features.rules.accepting`)."""
    accepted: bool = True
    """False where none was: the one that came nearest stands there."""


@dataclass(frozen=True, slots=True)
class BatchRecord:
    """One finished batch."""

    models: tuple[ModelRecord, ...]
    hashes: Mapping[str, str]
    """SHA-256 of each file that the batch made, by path relative to the run's folder."""
    prints: tuple[str, ...] = ()
    """What the rules printed."""
    missing_images: tuple[str, ...] = ()
    """Textures of the models that the asset folder lacks."""
    missing_assets: tuple[MissingAsset, ...] = ()
    """Meshes that it lacks."""


def batch_folder(folder: Path, batch: Batch) -> Path:
    """Where the derivations of a batch lie."""
    return folder / DERIVATIONS / f"{batch.index:05d}"


def write_record(folder: Path, batch: Batch, record: BatchRecord) -> None:
    """Record that a batch is finished; the last thing that is written of it."""
    _records(folder, batch).put(_KEY, record)


def read_record(folder: Path, batch: Batch) -> BatchRecord | None:
    """The record of a batch, None unless it is finished and all its files are still there."""
    record = _records(folder, batch).get(_KEY)
    return record if record is not None and all((folder / file).is_file() for file in record.hashes) else None


def _records(folder: Path, batch: Batch) -> Results[BatchRecord]:
    # No more lasting than the files that they are about.
    return Results(batch_folder(folder, batch), _KIND, lasting=False)


def _parse(values: Any) -> BatchRecord:
    models = tuple(ModelRecord(**model) for model in values["models"])
    images = tuple(values.get("missing_images", ()))
    assets = tuple(
        MissingAsset(each["path"], Location(**each["location"])) for each in values.get("missing_assets", ())
    )
    return BatchRecord(models, dict(values["hashes"]), tuple(values["prints"]), images, assets)


_KIND = json_kind(asdict, _parse)
