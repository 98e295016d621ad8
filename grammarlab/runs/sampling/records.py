"""Records of the models of a run, stored beside the derivations so that an interrupted run can be resumed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from grammarlab.derivation.forest import MissingAsset
from grammarlab.errors import Location
from grammarlab.files import file_below, file_hash
from grammarlab.runs.disk.members import member, numbers, of_kind, texts
from grammarlab.runs.disk.results import Results, json_kind
from grammarlab.runs.requests.batches import Batch
from grammarlab.runs.requests.request import SampleRequest

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


def model_name(request: SampleRequest, index: int) -> str:
    """Name of the file of a model without its suffix."""
    return f"{request.name}-{index:05d}"


def write_record(folder: Path, batch: Batch, record: BatchRecord) -> None:
    """Record that a batch is finished; written last, and on the disk when this returns."""
    Results(batch_folder(folder, batch), _KIND).put(_KEY, record)


def forget_record(folder: Path, batch: Batch) -> None:
    """Remove the record of a batch whose files are about to be made again."""
    (batch_folder(folder, batch) / RECORD).unlink(missing_ok=True)


def read_record(folder: Path, request: SampleRequest, batch: Batch) -> BatchRecord | None:
    """The record of a batch; None unless it is finished and all its files are as they were written."""
    record = Results(batch_folder(folder, batch), _KIND).get(_KEY)
    if record is None or not _is_about(record, request, batch):
        return None
    return record if all(is_unchanged(folder, *entry) for entry in record.hashes.items()) else None


def recorded_files(folder: Path, name: str) -> Mapping[str, str]:
    """SHA-256 of the files of a batch by path relative to the run's folder; none if there is no such record.

    Args:
        folder: the run's folder.
        name: path of the record relative to it.
    """
    record = file_below(folder, name)
    batch = None if record is None else Results(record.parent, _KIND).get(_KEY)
    return {} if batch is None else batch.hashes


def is_unchanged(folder: Path, name: str, digest: Any) -> bool:
    """Whether a file of a run is a regular file below its folder, not through a link, with the recorded SHA-256."""
    file = file_below(folder, name)
    return file is not None and file_hash(file) == digest


def _is_about(record: BatchRecord, request: SampleRequest, batch: Batch) -> bool:
    """Whether a record, perhaps of somebody else, has the models of a batch and their files."""
    indices = range(batch.first_model, batch.first_model + batch.num_models)
    names = [request.name if request.single_file else model_name(request, index) for index in indices]
    files = [f"{name}.{request.file_format}" for name in names]
    models = [(model.index, model.file) for model in record.models]
    return models == list(zip(indices, files, strict=True)) and (
        request.single_file or record.hashes.keys() >= set(files)
    )


def _parse(values: Any) -> BatchRecord:
    """A record, if it is one.

    Raises:
        AssetError: If a member is missing or has another type.
    """
    lists = {name: of_kind(values, dict, "record").get(name, []) for name in ("prints", "missing_images")}
    prints, images = (
        tuple(of_kind(text, str, name) for text in of_kind(entries, list, name)) for name, entries in lists.items()
    )
    assets = of_kind(values.get("missing_assets", []), list, "missing_assets")
    models = tuple(map(_model, member(values, "models", list)))
    return BatchRecord(models, texts(values, "hashes"), prints, images, tuple(map(_missing_asset, assets)))


def _model(values: Any) -> ModelRecord:
    density = of_kind(values, dict, "models").get("log_probability")
    reports = member(values, "reports", dict, "models")
    return ModelRecord(
        index=member(values, "index", int, "models"),
        file=member(values, "file", str, "models"),
        seed=member(values, "seed", int, "models"),
        shapes=member(values, "shapes", int, "models"),
        triangles=member(values, "triangles", int, "models"),
        log_probability=None if density is None else float(density),
        reports={key: of_kind(report, dict, "reports") for key, report in reports.items()},
        origin=tuple(numbers(values.get("origin", [0.0, 0.0, 0.0]), 3, "origin")),
        tries=of_kind(values.get("tries", 1), int, "tries"),
        accepted=of_kind(values.get("accepted", True), bool, "accepted"),
    )


def _missing_asset(values: Any) -> MissingAsset:
    position = member(values, "location", dict, "missing_assets")
    line, column, length = (member(position, name, int, "location") for name in ("line", "column", "length"))
    location = Location(line, column, length, member(position, "file", str, "location"))
    return MissingAsset(member(values, "path", str, "missing_assets"), location)


_KIND = json_kind(asdict, _parse)
