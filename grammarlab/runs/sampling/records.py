"""Records of the models of a run, stored beside the derivations so that an interrupted run can be resumed."""

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
"""Folder with one folder per batch, in the format of `grammarlab.runs.disk.derivations`, and these records."""
_KEY = "models"
RECORD = f"{_KEY}.json"


@dataclass(frozen=True, slots=True)
class ModelRecord:
    """One finished model."""

    index: int
    """Its address is (seed, index)."""
    file: str
    """Path relative to the run's folder; the shared file if there is one for all models."""
    seed: int
    shapes: int
    """Number of nodes of the derivation tree, or of parts of a model without a tree."""
    triangles: int
    log_probability: float | None
    """Natural logarithm of the density of its random draws; None if unknown."""
    reports: Mapping[str, Mapping[str, float | int | None]] = field(default_factory=dict)
    """Values of ``report`` by key: see `grammarlab.runs.models.reports`."""
    origin: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Origin of the coordinates in the model's file, in world metres; a GLB has it as a node."""
    tries: int = 1
    """Number of candidates until one was accepted (`grammarlab.features.rules.accepting`)."""
    accepted: bool = True
    """False if none was accepted; the model is then the nearest candidate."""


@dataclass(frozen=True, slots=True)
class BatchRecord:
    """One finished batch."""

    models: tuple[ModelRecord, ...]
    hashes: Mapping[str, str]
    """SHA-256 of each file of the batch, by path relative to the run's folder."""
    prints: tuple[str, ...] = ()
    """Texts printed by the rules."""
    missing_images: tuple[str, ...] = ()
    """Missing textures of the models."""
    missing_assets: tuple[MissingAsset, ...] = ()
    """Missing meshes."""


def batch_folder(folder: Path, batch: Batch) -> Path:
    """Folder of the derivations of a batch."""
    return folder / DERIVATIONS / f"{batch.index:05d}"


def write_record(folder: Path, batch: Batch, record: BatchRecord) -> None:
    """Record that a batch is finished; written last."""
    _records(folder, batch).put(_KEY, record)


def read_record(folder: Path, batch: Batch) -> BatchRecord | None:
    """The record of a batch; None unless it is finished and all its files still exist."""
    record = _records(folder, batch).get(_KEY)
    return record if record is not None and all((folder / file).is_file() for file in record.hashes) else None


def _records(folder: Path, batch: Batch) -> Results[BatchRecord]:
    # Not flushed to the disk, like the files themselves.
    return Results(batch_folder(folder, batch), _KIND, lasting=False)


def _parse(values: Any) -> BatchRecord:
    models = tuple(ModelRecord(**model) for model in values["models"])
    images = tuple(values.get("missing_images", ()))
    assets = tuple(
        MissingAsset(each["path"], Location(**each["location"])) for each in values.get("missing_assets", ())
    )
    return BatchRecord(models, dict(values["hashes"]), tuple(values["prints"]), images, assets)


_KIND = json_kind(asdict, _parse)
