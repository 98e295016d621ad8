"""All models of a run in one file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grammarlab.export import SaveOptions, save_together
from grammarlab.export.save import Reuse
from grammarlab.files import file_hash, sync_files
from grammarlab.runs.models.abstract import models_of
from grammarlab.runs.requests.batches import Batch
from grammarlab.runs.requests.request import Instancing, SampleRequest
from grammarlab.runs.sampling.records import batch_folder
from grammarlab.scene import Scene

_REUSE: dict[Instancing, Reuse] = {"none": "merged", "nodes": "nodes", "gpu": "instancing"}


def save_options(request: SampleRequest) -> SaveOptions:
    """Options of saving the files of a run; with one model on each footprint, models keep their places."""
    return SaveOptions(
        reuse=_REUSE[request.instancing],
        assets=request.assets,
        columns=request.columns or None,
        in_place=len(request.footprints) > 0 and request.num_models == 1,
        origin=request.origin,
    )


def file_origins(request: SampleRequest, origins: NDArray[np.float64]) -> NDArray[np.float64]:
    """Origins [N, 3] in the world of the coordinates of models in their files.

    Args:
        request: the request.
        origins: [N, 3] origins of the models themselves.
    """
    shared = request.num_models == 1 if request.single_file else request.file_format != "glb"
    return origins if request.origin is None or not shared else np.broadcast_to(request.origin, origins.shape)


def single_file_name(request: SampleRequest) -> str:
    """Name of the one file with all models."""
    return f"{request.name}.{request.file_format}"


def write_single_file(request: SampleRequest, folder: Path, batches: tuple[Batch, ...]) -> dict[str, str]:
    """Write all models of finished batches into one file.

    Returns:
        SHA-256 of this file and of those beside it, by name.
    """
    path = folder / single_file_name(request)
    files: list[Path] = []
    scenes = StoredScenes(request, folder, batches)
    save_together(scenes, path, request.file_format, save_options(request), files.append)
    sync_files(files, folder)
    return {file.name: file_hash(file) for file in files}


@dataclass(frozen=True, slots=True)
class StoredScenes:
    """The scenes of finished batches, read from disk at each iteration."""

    request: SampleRequest
    folder: Path
    batches: Sequence[Batch]

    def __iter__(self) -> Iterator[Scene]:
        models = models_of(self.request)
        for batch in self.batches:
            yield models.stored(self.request, batch, batch_folder(self.folder, batch))
