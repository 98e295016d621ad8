"""The contact sheet of a run."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grammarlab.render.camera import Camera, View, frame_alike
from grammarlab.render.raycast import RaycastRenderer
from grammarlab.render.renderer import RenderOptions
from grammarlab.runs.atomic import atomic_file
from grammarlab.runs.batches import Batch
from grammarlab.runs.request import SampleRequest
from grammarlab.runs.single_file import load_scene
from grammarlab.runs.workers import map_unordered
from grammarlab.scene import TriangleBatch, triangles

SHEET_MODELS = 144
"""Models on the sheet of a larger run: the first ones."""
TILE = 320
"""Pixels along each side of the picture of one model."""


def sheet_name(request: SampleRequest) -> str:
    """Name of the picture of all models."""
    return f"{request.name}.png"


def draw_sheet(request: SampleRequest, folder: Path, batches: tuple[Batch, ...], jobs: int) -> Path:
    """Draw the models of finished batches onto one picture, `SHEET_MODELS` at most, all at one scale."""
    count = 0
    shown = []
    for batch in batches:
        if count < SHEET_MODELS:
            shown.append(batch)
        count += batch.num_models
    batch = triangles(load_scene(folder, tuple(shown)))
    models = [batch.model(index) for index in range(min(batch.num_models, SHEET_MODELS))]
    cameras = frame_alike([m.vertices if len(m.vertices) else np.zeros((1, 3)) for m in models], 1.0, View())
    columns = request.columns or math.ceil(math.sqrt(len(models)))
    rows = math.ceil(len(models) / columns)
    sheet = np.full((rows * TILE, columns * TILE, 3), 255, np.uint8)
    tasks = [(index, model, camera) for index, (model, camera) in enumerate(zip(models, cameras, strict=True))]
    for index, picture in map_unordered(_draw, tasks, min(jobs, len(tasks))):
        row, column = divmod(index, columns)
        sheet[row * TILE : (row + 1) * TILE, column * TILE : (column + 1) * TILE] = picture
    path = folder / sheet_name(request)
    with atomic_file(path) as part:
        Image.fromarray(sheet).save(part)
    return path


def _draw(task: tuple[int, TriangleBatch, Camera]) -> tuple[int, NDArray[np.uint8]]:
    index, model, camera = task
    return index, RaycastRenderer().render(model, camera, RenderOptions(TILE, TILE))
