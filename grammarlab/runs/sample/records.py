"""Batches of a run: made and written in any process, with records from which an interrupted run is resumed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.texture_files import image_file
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.forest import MissingAsset
from grammarlab.derivation.program import Program
from grammarlab.errors import Finding, Location
from grammarlab.export import SaveOptions, save_each, save_together
from grammarlab.export.save import Reuse, counts_from_model
from grammarlab.files import file_below, file_hash, sync_files
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.checks import grammar_to_run
from grammarlab.runs.sample.models import Batch, Report, models_of
from grammarlab.runs.sample.request import Instancing, SampleRequest
from grammarlab.runs.sample.shipped import SUFFIX
from grammarlab.runs.work.json_members import member, numbers, of_kind, texts
from grammarlab.runs.work.results import Results, json_kind
from grammarlab.scene import Scene
from grammarlab.scene.pivots import at_pivot
from grammarlab.scene.triangles import count_triangles

DERIVATIONS = "derivations"
"""Folder with one folder per batch, in the format of `grammarlab.runs.sample.derivations`, and its record."""
_KEY = "models"
RECORD = f"{_KEY}.json"
_REUSE: dict[Instancing, Reuse] = {"none": "merged", "nodes": "nodes", "gpu": "instancing"}


@dataclass(frozen=True, slots=True)
class ModelRecord:
    """One finished model."""

    index: int
    """Index of the model under the seed; its address is (seed, index)."""
    file: str
    """Path relative to the run's folder; the shared file if there is one for all models."""
    seed: int
    shapes: int
    """Number of nodes of the derivation tree, or of parts of a model without a tree."""
    triangles: int
    log_probability: float | None
    """Natural logarithm of the density of its random draws; None if unknown."""
    reports: Mapping[str, Mapping[str, float | int | None]] = field(default_factory=dict)
    """Values of ``report`` by key: see `grammarlab.runs.sample.grammar_models`."""
    origin: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Origin of the coordinates in the model's file, in world metres; a GLB has it as a node."""
    tries: int = 1
    """Number of candidates until one was accepted (`grammarlab.features.acceptance`)."""
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
    """Meshes that the asset folder lacks."""
    warnings: tuple[Finding, ...] = ()
    """What the rules passed over."""


@dataclass(frozen=True, slots=True)
class StoredScenes:
    """The scenes of finished batches, in order, made again from what is on disk at each iteration."""

    request: SampleRequest
    folder: Path
    batches: Sequence[Batch]

    def __iter__(self) -> Iterator[Scene]:
        models = models_of(self.request)
        for batch in self.batches:
            yield from models.stored(self.request, batch, _batch_folder(self.folder, batch))


def read_record(folder: Path, request: SampleRequest, batch: Batch) -> BatchRecord | None:
    """The record of a batch; None unless it is finished and all its files are as they were written."""
    record = Results(_batch_folder(folder, batch), _KIND).get(_KEY)
    if record is None or not _is_about(record, request, batch):
        return None
    return record if all(is_unchanged(folder, *entry) for entry in record.hashes.items()) else None


def is_unchanged(folder: Path, name: str, digest: Any) -> bool:
    """Whether a file of a run is a regular file below its folder, not through a link, with the recorded SHA-256."""
    file = file_below(folder, name)
    return file is not None and file_hash(file) == digest


def recorded_files(folder: Path, name: str) -> Mapping[str, str]:
    """SHA-256 of the files of a batch by path relative to the run's folder; none if there is no such record.

    Args:
        folder: the run's folder.
        name: path of the record relative to it.
    """
    record = file_below(folder, name)
    batch = None if record is None else Results(record.parent, _KIND).get(_KEY)
    return {} if batch is None else batch.hashes


def write_single_file(request: SampleRequest, folder: Path, batches: tuple[Batch, ...]) -> dict[str, str]:
    """Write all models of finished batches into one file.

    Returns:
        SHA-256 of this file and of those beside it, by name.
    """
    path = folder / single_file_name(request)
    files: list[Path] = []
    scenes = StoredScenes(request, folder, batches)
    save_together(scenes, path, request.file_format, _save_options(request), files.append, request.model_numbers)
    sync_files(files, folder)
    return {file.name: file_hash(file) for file in files}


def single_file_name(request: SampleRequest) -> str:
    """Name of the one file with all models."""
    return f"{request.name}.{request.file_format}"


@lru_cache(maxsize=4)
def compiled(text: str, name: str) -> tuple[Grammar, Program]:
    """Compiled grammar of a rule text, made once per process.

    Raises:
        LanguageError: If the text has errors.
    """
    grammar = grammar_to_run(text, f"{name}{SUFFIX}")
    return grammar, compile_grammar(grammar)


def sample_batch(request: SampleRequest, folder: Path, batch: Batch) -> BatchRecord:
    """Make a batch and write its models, its derivations and, last, its record.

    Files are on the disk before the record that names them, so a record is right even after a power failure.
    """
    _forget_record(folder, batch)
    made = models_of(request).make(request, batch)
    derivations = _batch_folder(folder, batch)
    written: set[Path] = {derivations / name for name in made.save(derivations)}
    files: list[str] = []
    shapes: list[int] = []
    triangles: list[int] = []
    reports: list[Report] = []
    origins: list[NDArray[np.float64]] = []
    images: set[str] = set()
    for part in made.scenes:
        scene = part.scene
        files += _write_files(request, folder, scene, batch.first_model + len(files), written.add)
        shapes += part.shapes
        triangles += count_triangles(scene).tolist()
        reports += part.reports
        origins.append(_file_origins(request, at_pivot(scene, request.pivot).origins))
        images |= _missing_images(scene, request.assets)
    columns = zip(
        files,
        shapes,
        triangles,
        made.log_probability,
        reports,
        map(tuple, np.concatenate(origins).tolist()),
        made.tries or [1] * batch.num_models,
        made.accepted or [True] * batch.num_models,
        strict=True,
    )
    models = tuple(
        ModelRecord(
            index=batch.first_model + k,
            file=file,
            seed=request.seed,
            shapes=num_shapes,
            triangles=num_triangles,
            log_probability=log_probability,
            reports=report,
            origin=origin,
            tries=tries,
            accepted=accepted,
        )
        for k, (file, num_shapes, num_triangles, log_probability, report, origin, tries, accepted) in enumerate(columns)
    )
    sync_files(written, folder)
    hashes = {path.relative_to(folder).as_posix(): file_hash(path) for path in sorted(written)}
    record = BatchRecord(models, hashes, made.prints, tuple(sorted(images)), made.missing_assets, made.warnings)
    _write_record(folder, batch, record)
    return record


def _write_files(
    request: SampleRequest, folder: Path, scene: Scene, first_model: int, on_file: Callable[[Path], None]
) -> list[str]:
    """Write the models of a scene, unless all models are in one file; returns the names of their files."""
    if request.single_file:
        return [single_file_name(request)] * scene.num_models
    paths = save_each(
        scene,
        folder,
        request.file_format,
        _save_options(request),
        name=partial(_model_name, request),
        first_model=first_model,
        on_file=on_file,
    )
    return [path.name for path in paths]


def _batch_folder(folder: Path, batch: Batch) -> Path:
    """Folder of the derivations of a batch."""
    return folder / DERIVATIONS / f"{batch.index:05d}"


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
    warnings = tuple(map(_warning, of_kind(values.get("warnings", []), list, "warnings")))
    return BatchRecord(models, texts(values, "hashes"), prints, images, tuple(map(_missing_asset, assets)), warnings)


_KIND = json_kind(asdict, _parse)


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
    path, reason = member(values, "path", str, "missing_assets"), of_kind(values.get("reason", ""), str, "reason")
    return MissingAsset(path, _location(values, "missing_assets"), reason)


def _warning(values: Any) -> Finding:
    code, message, hint = (member(values, name, str, "warnings") for name in ("code", "message", "hint"))
    return Finding("warning", code, message, _location(values, "warnings"), hint)


def _location(values: Any, name: str) -> Location:
    position = member(values, "location", dict, name)
    line, column, length = (member(position, number, int, "location") for number in ("line", "column", "length"))
    return Location(line, column, length, member(position, "file", str, "location"))


def _is_about(record: BatchRecord, request: SampleRequest, batch: Batch) -> bool:
    """Whether a record, perhaps of somebody else, has the models of a batch and their files."""
    indices = range(batch.first_model, batch.first_model + batch.num_models)
    names = [request.name if request.single_file else _model_name(request, index) for index in indices]
    files = [f"{name}.{request.file_format}" for name in names]
    models = [(model.index, model.file) for model in record.models]
    return models == list(zip(indices, files, strict=True)) and (
        request.single_file or record.hashes.keys() >= set(files)
    )


def _model_name(request: SampleRequest, index: int) -> str:
    """Name of the file of a model without its suffix."""
    return f"{request.name}-{index:05d}"


def _save_options(request: SampleRequest) -> SaveOptions:
    """Options of saving the files of a run; models keep their places as `SampleRequest.is_in_place` says.

    A model with a file of its own has a place if it stands on somebody's footprint.
    """
    has_places = request.is_in_place or (len(request.footprints) > 0 and not request.single_file)
    return SaveOptions(
        reuse=_REUSE[request.instancing],
        assets=request.assets,
        columns=request.columns or None,
        in_place=has_places,
        origin=request.origin,
        pivot=request.pivot,
    )


def _forget_record(folder: Path, batch: Batch) -> None:
    """Remove the record of a batch whose files are about to be made again."""
    (_batch_folder(folder, batch) / RECORD).unlink(missing_ok=True)


def has_own_origins(request: SampleRequest) -> bool:
    """Whether the coordinates of each model count from its own origin instead of `SampleRequest.origin`."""
    if request.single_file:
        return not request.is_in_place
    return counts_from_model(_save_options(request), request.file_format)


def _file_origins(request: SampleRequest, origins: NDArray[np.float64]) -> NDArray[np.float64]:
    """Origins [N, 3] in the world of the coordinates of models in their files.

    Args:
        request: the request.
        origins: [N, 3] origins of the models themselves.
    """
    return (
        origins
        if request.origin is None or has_own_origins(request)
        else np.broadcast_to(request.origin, origins.shape)
    )


def _missing_images(scene: Scene, assets: AssetRoot) -> set[str]:
    """The textures of visible shapes that the asset folder lacks."""
    used = {scene.materials.textures[material] for material in np.unique(scene.material).tolist()}
    used -= scene.materials.pictures.keys()
    return {name for name in used if name and image_file(name, assets) is None}


def _write_record(folder: Path, batch: Batch, record: BatchRecord) -> None:
    """Record that a batch is finished; written last, and on the disk when this returns."""
    Results(_batch_folder(folder, batch), _KIND).put(_KEY, record)
