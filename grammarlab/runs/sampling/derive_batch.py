"""Making, writing and recording one batch of a run, in any process."""

from __future__ import annotations

from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.program import Program
from grammarlab.export import save_each
from grammarlab.export.textures import image_file
from grammarlab.files import file_hash, sync_files
from grammarlab.language.grammar import Grammar
from grammarlab.runs.models.abstract import models_of
from grammarlab.runs.requests.batches import Batch
from grammarlab.runs.requests.checks import grammar_to_run
from grammarlab.runs.requests.examples import SUFFIX
from grammarlab.runs.requests.request import SampleRequest
from grammarlab.runs.sampling.records import (
    BatchRecord,
    ModelRecord,
    batch_folder,
    forget_record,
    model_name,
    write_record,
)
from grammarlab.runs.sampling.single_file import file_origins, save_options, single_file_name
from grammarlab.scene import Scene
from grammarlab.scene.triangles import count_triangles


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
    forget_record(folder, batch)
    made = models_of(request).make(request, batch)
    scene = made.scene
    written: set[Path] = set()
    if request.single_file:
        files = [single_file_name(request)] * batch.num_models
    else:
        paths = save_each(
            scene,
            folder,
            request.file_format,
            save_options(request),
            name=partial(model_name, request),
            first_model=batch.first_model,
            on_file=written.add,
        )
        files = [path.name for path in paths]
    place = batch_folder(folder, batch)
    written |= {place / name for name in made.save(place)}
    columns = zip(
        files,
        made.shapes,
        count_triangles(scene).tolist(),
        made.log_probability,
        made.reports,
        map(tuple, file_origins(request, scene.origins).tolist()),
        made.tries or [1] * batch.num_models,
        made.kept or [True] * batch.num_models,
        strict=True,
    )
    models = tuple(
        ModelRecord(
            index=batch.first_model + k,
            file=file,
            seed=request.seed,
            shapes=shapes,
            triangles=triangles,
            log_probability=log_probability,
            reports=reports,
            origin=origin,
            tries=tries,
            accepted=accepted,
        )
        for k, (file, shapes, triangles, log_probability, reports, origin, tries, accepted) in enumerate(columns)
    )
    sync_files(written, folder)
    hashes = {path.relative_to(folder).as_posix(): file_hash(path) for path in sorted(written)}
    images = _missing_images(scene, request.assets)
    record = BatchRecord(models, hashes, made.prints, images, made.missing_assets)
    write_record(folder, batch, record)
    return record


def _missing_images(scene: Scene, assets: Path) -> tuple[str, ...]:
    """The textures of visible shapes that the asset folder lacks, in alphabetical order."""
    used = {scene.materials.textures[material] for material in np.unique(scene.material).tolist()}
    return tuple(sorted(name for name in used if name and image_file(name, assets) is None))
