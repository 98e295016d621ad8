"""Runs: from a request to files and a contact sheet on disk; repeated from a manifest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import MissingAsset, by_path, by_place
from grammarlab.errors import AssetError, Finding, UsageError
from grammarlab.files import atomic_file, file_hash, folder_below, remove_parts
from grammarlab.rendering.choice import RendererChoice, choose
from grammarlab.runs.sample.checks import first_difference, hash_assets, warnings_of
from grammarlab.runs.sample.clearing import batch_names, check_kept, clear_run, find_run
from grammarlab.runs.sample.manifest import BATCHES_OVER_FOOTPRINTS, MANIFEST, Manifest, read_manifest, write_manifest
from grammarlab.runs.sample.models import EMPTY_MODELS, Batch, cut_batches, models_of
from grammarlab.runs.sample.records import (
    DERIVATIONS,
    BatchRecord,
    ModelRecord,
    StoredScenes,
    is_unchanged,
    read_record,
    sample_batch,
    single_file_name,
    write_single_file,
)
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.stand import Stand
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.runs.work.results import Progress
from grammarlab.runs.work.run_folder import only_run_in
from grammarlab.scene import TriangleBatch, triangles
from grammarlab.scene.scene_pictures import with_pictures

TILE_AREA = 320 * 320
"""Pixels of the picture of one model."""
MAX_FILES = 2_000_000
"""Largest number of models of a run with model files: a manifest has some 400 bytes for each, and 1 GiB at most."""
_SHEET_MODELS = 144
"""Largest number of models on the sheet; of more, the first ones are shown."""


@dataclass(frozen=True, slots=True)
class RunResult:
    """A finished run."""

    request: SampleRequest
    folder: Path
    models: tuple[ModelRecord, ...]
    """Models by index."""
    sheet: Path | None
    """The contact sheet, if requested."""
    manifest: Path
    plan: Path | None = None
    """The plan of a stand of trees, if a sheet was requested."""
    prints: tuple[str, ...] = ()
    """Texts printed by the rules, a bounded number per batch."""
    missing_images: tuple[str, ...] = ()
    """Missing textures of the models, in alphabetical order."""
    missing_assets: tuple[MissingAsset, ...] = ()
    """Missing meshes, by path."""
    warnings: tuple[Finding, ...] = ()
    """What the rules passed over, by place."""
    kept_files: tuple[str, ...] = ()
    """Files that differ from what an earlier run recorded, or that it did not come to record, and were not removed."""

    @property
    def accept_rate(self) -> float | None:
        """Share of candidates that an acceptance rule kept; None without a rule."""
        tries = sum(model.tries for model in self.models)
        return None if tries == len(self.models) else sum(model.accepted for model in self.models) / tries

    @property
    def not_accepted(self) -> tuple[ModelRecord, ...]:
        """Models without an accepted candidate; the nearest candidate is used."""
        return tuple(model for model in self.models if not model.accepted)

    def missing_asset_warnings(self) -> tuple[Finding, ...]:
        """One finding per missing mesh, as in `grammarlab check`."""
        return warnings_of(self.missing_assets, self.request.assets)

    @property
    def derivations(self) -> Path:
        """Folder with one folder of Parquet files for each batch (`grammarlab.runs.sample.derivations`)."""
        return self.folder / DERIVATIONS


def repeat_run(
    manifest: Manifest,
    folder: Path | str,
    *,
    executor: AbstractExecutor = SERIAL,
    resume: bool = False,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> tuple[RunResult, tuple[str, ...]]:
    """Make the run of a manifest again, and compare.

    Args:
        manifest: manifest of a complete run.
        folder: folder for the files; not the folder of the repeated run.
        executor: makes the batches, as in `sample_run`.
        resume: whether to continue an interrupted run, as in `sample_run`.
        on_progress: called with the progress, as in `sample_run`.

    Returns:
        The run, and the names of the files that are not equal, bit for bit, to those of the manifest.

    Raises:
        AssetError: If asset files differ from those of the manifest.
        GrammarlabError: See `sample_run`.
    """
    difference = first_difference(manifest.asset_files, hash_assets(manifest.request))
    if difference:
        raise AssetError(
            f"the run cannot be repeated: {difference}, compared with the manifest, in {manifest.request.assets}. "
            "Give the folder that holds the assets as they were with `assets=`."
        )
    result = sample_run(manifest.request, folder, executor=executor, resume=resume, on_progress=on_progress)
    new_files = read_manifest(result.manifest).files
    return result, tuple(
        sorted(file for file in {*new_files, *manifest.files} if new_files.get(file) != manifest.files.get(file))
    )


def sample_run(
    request: SampleRequest,
    folder: Path | str,
    *,
    executor: AbstractExecutor = SERIAL,
    resume: bool = False,
    on_progress: Progress = lambda _what, _done, _total: None,
) -> RunResult:
    """Derive the models of a request and write all files into a folder.

    Files are written atomically, so an interrupted run leaves valid files and can be resumed.

    Args:
        request: the request.
        folder: made if missing. The files of an earlier run of the grammar in it are removed, unless it is resumed
            or they were changed since. A folder is refused if it has a run of another grammar, if another run is
            writing into it, or if a changed file, or one that no manifest lists, would be replaced.
        executor: makes the batches and the picture; the files do not depend on it.
        resume: continue the run in the folder, and make only batches with missing or damaged files.
        on_progress: called after every finished batch.

    Raises:
        GrammarlabError: If the grammar, the assets or the folder cannot be used.

    >>> import grammarlab as gl
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> rules = "Lot --> extrude(3) Tower"
    >>> request = gl.SampleRequest(name="tower", text=rules, assets=Path(), num_models=2, image=False)
    >>> with TemporaryDirectory() as folder:
    ...     run = gl.sample_run(request, Path(folder) / "towers")
    ...     sorted(file.name for file in run.folder.glob("*.glb"))
    ['tower-00000.glb', 'tower-00001.glb']
    """
    folder = Path(folder)
    if request.total_models > MAX_FILES:
        raise UsageError(
            f"expected at most {MAX_FILES:,} models with files, found {request.total_models:,}. Sample them without "
            "files, as rows of tables (`no_models=True`)."
        )
    # Errors in the rules and options come before anything is written or removed.
    models = models_of(request)
    models.check(request)
    request = replace(request, remarks=tuple(dict.fromkeys((*request.remarks, *models.remarks(request)))))
    choice = choose(request.renderer) if request.image else RendererChoice("cast")
    if request.image:
        request = replace(request, renderer=choice.name)
    asset_files = hash_assets(request)
    with only_run_in(folder, (DERIVATIONS,)):
        earlier = _prepare(folder, request, asset_files, resume)
        write_manifest(folder, request, choice, asset_files)
        return _make(request, folder, executor, on_progress, choice, asset_files, earlier)


def _prepare(folder: Path, request: SampleRequest, asset_files: Mapping[str, str], resume: bool) -> _Earlier:
    """Remove an earlier run from a folder unless it is resumed; without a manifest there is none."""
    batch_names(folder)
    if not (resume and (folder / MANIFEST).is_file()):
        run = find_run(folder, request.name)
        kept_files = check_kept(folder, run, request)
        clear_run(folder, run)
        return _Earlier(resumed=False, files={}, kept_files=kept_files)
    manifest = read_manifest(folder, request.assets)
    difference = _changed_option(manifest.request, request) or first_difference(manifest.asset_files, asset_files)
    if difference:
        raise UsageError(
            f"{folder} holds another run than the one to resume: {difference}. "
            "Repeat the options of that run, or write into another folder."
        )
    if manifest.format < BATCHES_OVER_FOOTPRINTS and len(request.footprints) > 1:
        raise UsageError(
            f"{folder} holds a run on {len(request.footprints)} footprints of an earlier version, which cut it into "
            "other batches, so that it cannot be resumed. Run it again without `resume=True`: its files are replaced."
        )
    return _Earlier(resumed=True, files=manifest.files)


@dataclass(frozen=True, slots=True)
class _Earlier:
    """What a folder holds of an earlier run."""

    resumed: bool
    """Whether its batches count; otherwise all are made."""
    files: Mapping[str, str]
    """SHA-256 of the files of the run that is resumed, if it was complete."""
    kept_files: tuple[str, ...] = ()
    """Files of a run that is not resumed, see `RunResult.kept_files`."""

    def has(self, folder: Path, name: str) -> bool:
        """Whether a file is as that run wrote it."""
        return name in self.files and is_unchanged(folder, name, self.files[name])

    def single_file(self, folder: Path, name: str) -> dict[str, str]:
        """SHA-256 of the file of all models and of those beside it; empty if one is missing or has changed."""
        stem = name.rpartition(".")[0]
        names = [file for file in self.files if file in (name, f"{stem}.mtl") or file.startswith(f"{stem}_texture_")]
        return (
            {file: self.files[file] for file in names} if all(self.has(folder, file) for file in (name, *names)) else {}
        )


def _changed_option(earlier: SampleRequest, request: SampleRequest) -> str:
    """Description of a difference between two requests; empty if there is none."""
    if (earlier.text, earlier.suffix) != (request.text, request.suffix):
        return "the file of the models differs"
    before, now = earlier.as_json(), request.as_json()
    for name in (*now, *(before.keys() - now.keys())):  # some options are listed only if they are not the usual ones
        if before.get(name) != now.get(name):
            return f"{name} was {before.get(name, 'as usual')!r:.60} and is {now.get(name, 'as usual')!r:.60}"
    return ""


def _make(
    request: SampleRequest,
    folder: Path,
    executor: AbstractExecutor,
    on_progress: Progress,
    choice: RendererChoice,
    asset_files: Mapping[str, str],
    earlier: _Earlier,
) -> RunResult:
    """Make all files of a run in a folder that has been prepared."""
    records, unchanged = _run_batches(request, folder, executor, on_progress, resumed=earlier.resumed)
    model_records = tuple(model for record in records for model in record.models)
    hashes = {file: digest for record in records for file, digest in record.hashes.items()}
    batches = cut_batches(request)
    if request.single_file:
        single = earlier.single_file(folder, single_file_name(request)) if unchanged else {}
        hashes |= single or write_single_file(request, folder, batches)
    sheet = folder / request.sheet_name if request.image else None
    if sheet is not None:
        on_progress("picture", 0, 1)
        if not (unchanged and earlier.has(folder, sheet.name)):
            _draw_sheet(request, folder, batches, executor, choice)
        hashes[sheet.name] = file_hash(sheet)
        on_progress("picture", 1, 1)
    plan = folder / request.plan_name if request.image and request.stand is not None else None
    if plan is not None and request.stand is not None:
        _draw_plan(request.stand, request.name, plan)
        hashes[plan.name] = file_hash(plan)
    missing_assets = by_path(asset for record in records for asset in record.missing_assets)
    manifest = write_manifest(folder, request, choice, asset_files, model_records, hashes, missing_assets)
    prints = tuple(text for record in records for text in record.prints)
    images = sorted({name for record in records for name in record.missing_images})
    return RunResult(
        request=request,
        folder=folder,
        models=model_records,
        sheet=sheet,
        manifest=manifest,
        plan=plan,
        prints=prints,
        missing_images=tuple(images),
        missing_assets=missing_assets,
        warnings=_warnings(records),
        kept_files=earlier.kept_files,
    )


def _warnings(records: Sequence[BatchRecord]) -> tuple[Finding, ...]:
    """The warnings of all batches; that models have no shapes is one only if those of no batch have any."""
    everywhere = set.intersection(*(set(record.warnings) for record in records)) if records else set[Finding]()
    every = by_place(finding for record in records for finding in record.warnings)
    return tuple(finding for finding in every if finding.code != EMPTY_MODELS or finding in everywhere)


def _run_batches(
    request: SampleRequest, folder: Path, executor: AbstractExecutor, on_progress: Progress, *, resumed: bool
) -> tuple[tuple[BatchRecord, ...], bool]:
    """The records of all batches, in order, and whether all existed; makes missing ones, or all unless resumed."""
    batches = cut_batches(request)
    existing = ((batch.index, read_record(folder, request, batch)) for batch in batches if resumed)
    records = {index: record for index, record in existing if record is not None}
    missing = [batch for batch in batches if batch.index not in records]
    done = sum(len(record.models) for record in records.values())
    on_progress("models", done, request.total_models)

    def finish(index: int, record: BatchRecord) -> None:
        nonlocal done
        records[missing[index].index] = record
        done += len(record.models)
        on_progress("models", done, request.total_models)

    try:
        executor.in_folder(folder).run(partial(sample_batch, request, folder), missing, finish)
    finally:  # unfinished files of killed processes
        for inner in filter(None, (folder, folder_below(folder, DERIVATIONS))):
            remove_parts(inner)
    return tuple(records[batch.index] for batch in batches), not missing


def _draw_sheet(
    request: SampleRequest, folder: Path, batches: tuple[Batch, ...], executor: AbstractExecutor, choice: RendererChoice
) -> Path:
    """Draw the models of finished batches onto one picture, `_SHEET_MODELS` at most."""
    # Many runs draw no sheet.
    from PIL import Image  # noqa: PLC0415

    from grammarlab.runs.sample.contact_sheet import draw_page, draw_tiles, lay_out  # noqa: PLC0415

    models = _FirstModels(StoredScenes(request, folder, batches))
    same = request.scale == "same"
    tiles = draw_tiles(models, TILE_AREA, executor, same_scale=same, choice=choice)
    page = lay_out(len(tiles.pictures), request.columns, tiles.width, tiles.height)
    shown = zip(request.model_numbers, tiles.extents, strict=False)
    captions = [(str(index), _size_text(extents)) for index, extents in shown]
    scale = "all to one scale" if same else "each to its own scale"
    heading = (f"{request.name}   seed {request.seed}", f"width x height x depth, {scale}")
    path = folder / request.sheet_name
    with atomic_file(path) as part:
        Image.fromarray(draw_page(page, tiles.pictures, captions, heading)).save(part)
    return path


def _draw_plan(stand: Stand, name: str, path: Path) -> None:
    """Draw the places of a stand of trees."""
    from PIL import Image  # noqa: PLC0415

    from grammarlab.runs.sample.stand_plan import draw_plan  # noqa: PLC0415

    with atomic_file(path) as part:
        Image.fromarray(draw_plan(stand, name)).save(part)


@dataclass(frozen=True, slots=True)
class _FirstModels:
    """The models on the sheet, made at each iteration, one scene at a time."""

    scenes: StoredScenes

    def __iter__(self) -> Iterator[TriangleBatch]:
        count = 0
        for scene in self.scenes:
            batch = triangles(with_pictures(scene, self.scenes.request.assets))
            for index in range(min(scene.num_models, _SHEET_MODELS - count)):
                yield batch.model(index)
            count += scene.num_models
            if count >= _SHEET_MODELS:
                return


def _size_text(extents: NDArray[np.float64]) -> str:
    return " x ".join(_metres(extent) for extent in extents.tolist()) + " m"


def _metres(length: float) -> str:
    """A length with about three significant digits."""
    return f"{length:.2f}" if length < 10 else f"{length:.1f}" if length < 100 else f"{length:.0f}"
