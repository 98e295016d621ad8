"""The contact sheet of a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grammarlab.files import atomic_file
from grammarlab.rendering.choice import RendererChoice
from grammarlab.runs.pictures.sheet_page import draw_page, lay_out
from grammarlab.runs.pictures.tiles import draw_tiles, seen_points
from grammarlab.runs.requests.batches import Batch
from grammarlab.runs.requests.request import SampleRequest
from grammarlab.runs.sampling.single_file import StoredScenes
from grammarlab.runs.work.executors import AbstractExecutor
from grammarlab.scene import TriangleBatch, triangles

SHEET_MODELS = 144
"""Largest number of models on the sheet; of more, the first ones are shown."""
TILE_AREA = 320 * 320
"""Pixels of the picture of one model."""


def sheet_name(request: SampleRequest) -> str:
    """Name of the picture of all models."""
    return f"{request.name}.png"


def draw_sheet(
    request: SampleRequest, folder: Path, batches: tuple[Batch, ...], executor: AbstractExecutor, choice: RendererChoice
) -> Path:
    """Draw the models of finished batches onto one picture, `SHEET_MODELS` at most."""
    models = _first_models(request, folder, batches)
    same = request.scale == "same"
    tiles = draw_tiles(models, TILE_AREA, executor, same_scale=same, choice=choice)
    page = lay_out(len(models), request.columns, tiles.width, tiles.height)
    captions = [(str(index), _size_text(seen_points(model))) for index, model in enumerate(models)]
    scale = "all to one scale" if same else "each to its own scale"
    heading = (f"{request.name}   seed {request.seed}", f"width x height x depth, {scale}")
    path = folder / sheet_name(request)
    with atomic_file(path) as part:
        Image.fromarray(draw_page(page, tiles.pictures, captions, heading)).save(part)
    return path


def _first_models(request: SampleRequest, folder: Path, batches: tuple[Batch, ...]) -> list[TriangleBatch]:
    models: list[TriangleBatch] = []
    for scene in StoredScenes(request, folder, batches):
        batch = triangles(scene)
        models += [batch.model(index) for index in range(min(scene.num_models, SHEET_MODELS - len(models)))]
        if len(models) == SHEET_MODELS:
            break
    return models


def _size_text(points: NDArray[np.float32]) -> str:
    extents = np.ptp(points.astype(np.float64), axis=0)
    return " x ".join(_metres(extent) for extent in extents.tolist()) + " m"


def _metres(length: float) -> str:
    """A length with about three significant digits."""
    return f"{length:.2f}" if length < 10 else f"{length:.1f}" if length < 100 else f"{length:.0f}"
