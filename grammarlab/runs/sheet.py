"""The contact sheet of a run."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from grammarlab.render.camera import Camera, View, frame, frame_alike, seen_aspect
from grammarlab.render.choice import Choice
from grammarlab.render.renderer import RenderOptions
from grammarlab.runs.atomic import atomic_file
from grammarlab.runs.batches import Batch
from grammarlab.runs.request import SampleRequest
from grammarlab.runs.sheet_page import draw_page, lay_out
from grammarlab.runs.single_file import load_scene
from grammarlab.runs.workers import map_unordered
from grammarlab.scene import TriangleBatch, triangles

SHEET_MODELS = 144
"""Models on the sheet of a larger run: the first ones."""
TILE_AREA = 320 * 320
"""Pixels of the picture of one model."""
NARROWEST, WIDEST = 0.65, 1.6
"""Width over height of these pictures, as fits the models."""

_Task: TypeAlias = tuple[int, TriangleBatch, Camera]


def sheet_name(request: SampleRequest) -> str:
    """Name of the picture of all models."""
    return f"{request.name}.png"


def draw_sheet(request: SampleRequest, folder: Path, batches: tuple[Batch, ...], jobs: int, choice: Choice) -> Path:
    """Draw the models of finished batches onto one picture, `SHEET_MODELS` at most."""
    models = _first_models(folder, batches)
    points = [model.vertices if len(model.vertices) else np.zeros((1, 3), np.float32) for model in models]
    view = View()
    width, height = _tile_size(points, view)
    if request.scale == "same":
        cameras = frame_alike(points, width / height, view)
    else:
        cameras = [frame(of_model, width / height, view) for of_model in points]
    pictures: list[NDArray[np.uint8]] = [np.zeros(0, np.uint8)] * len(models)
    tasks = list(zip(range(len(models)), models, cameras, strict=True))
    draw = partial(_draw, choice, RenderOptions(width, height))
    # OpenGL drivers use all cores by themselves.
    for index, picture in map_unordered(draw, tasks, 1 if choice.name == "gl" else min(jobs, len(tasks))):
        pictures[index] = picture
    page = lay_out(len(models), request.columns, width, height)
    captions = [(str(index), _size_text(of_model)) for index, of_model in enumerate(points)]
    scale = "all to one scale" if request.scale == "same" else "each to its own scale"
    heading = (f"{request.name}   seed {request.seed}", f"width x height x depth, {scale}")
    path = folder / sheet_name(request)
    with atomic_file(path) as part:
        Image.fromarray(draw_page(page, pictures, captions, heading)).save(part)
    return path


def _first_models(folder: Path, batches: tuple[Batch, ...]) -> list[TriangleBatch]:
    count = 0
    shown = []
    for batch in batches:
        if count < SHEET_MODELS:
            shown.append(batch)
        count += batch.num_models
    together = triangles(load_scene(folder, tuple(shown)))
    return [together.model(index) for index in range(min(together.num_models, SHEET_MODELS))]


def _tile_size(points: list[NDArray[np.float32]], view: View) -> tuple[int, int]:
    """Width and height of the pictures in pixels: all alike, in a shape that suits most models."""
    aspect = float(np.median([seen_aspect(of_model, view) for of_model in points]))
    aspect = min(max(aspect, NARROWEST), WIDEST)
    return round(math.sqrt(TILE_AREA * aspect)), round(math.sqrt(TILE_AREA / aspect))


def _size_text(points: NDArray[np.float32]) -> str:
    extents = np.ptp(points.astype(np.float64), axis=0)
    return " x ".join(_metres(extent) for extent in extents.tolist()) + " m"


def _metres(length: float) -> str:
    """A length with about three digits that count."""
    return f"{length:.2f}" if length < 10 else f"{length:.1f}" if length < 100 else f"{length:.0f}"


def _draw(choice: Choice, options: RenderOptions, task: _Task) -> tuple[int, NDArray[np.uint8]]:
    index, model, camera = task
    return index, choice.make().render(model, camera, options)
