"""Pictures of many models in one format, for grids."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.rendering.camera import Camera, View, frame, frame_alike, seen_aspect
from grammarlab.rendering.choice import RendererChoice
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.runs.pictures.sheet_page import Picture
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor
from grammarlab.scene import TriangleBatch

NARROWEST, WIDEST = 0.65, 1.6
"""Aspect ratio of the pictures, chosen for the models."""
_CAST = RendererChoice("cast")


class _Task(NamedTuple):
    """A picture to draw."""

    model: TriangleBatch
    camera: Camera

    def __str__(self) -> str:
        return f"the picture of a model of {len(self.model.triangles):,} triangles"


@dataclass(frozen=True, slots=True)
class Tiles:
    """Pictures of models."""

    width: int
    """Pixels."""
    height: int
    """Pixels."""
    pictures: tuple[Picture, ...]
    """[height, width, 3] of each model."""


def draw_tiles(
    models: Sequence[TriangleBatch],
    area: int,
    executor: AbstractExecutor,
    *,
    same_scale: bool = False,
    choice: RendererChoice = _CAST,
) -> Tiles:
    """Draw each model separately.

    Args:
        models: one model in each.
        area: approximate number of pixels of a picture; its aspect ratio suits most models.
        executor: draws the pictures, which do not depend on it.
        same_scale: whether all pictures have the same scale; otherwise each model fills its own.
        choice: the renderer.
    """
    points = [seen_points(model) for model in models]
    view = View()
    width, height = _size(points, area, view)
    aspect = width / height
    cameras = frame_alike(points, aspect, view) if same_scale else [frame(each, aspect, view) for each in points]
    draw = partial(_draw, choice, RenderOptions(width=width, height=height))
    # OpenGL drivers use all cores by themselves.
    executor = SERIAL if choice.name == "gl" else executor
    return Tiles(width, height, tuple(executor.results(draw, map(_Task, models, cameras))))


def seen_points(model: TriangleBatch) -> NDArray[np.float32]:
    """[n, 3] the vertices of a model; the origin for a model without any."""
    return model.vertices if len(model.vertices) else np.zeros((1, 3), np.float32)


def _size(points: Sequence[NDArray[np.float32]], area: int, view: View) -> tuple[int, int]:
    aspect = float(np.median([seen_aspect(each, view) for each in points]))
    aspect = min(max(aspect, NARROWEST), WIDEST)
    return round(math.sqrt(area * aspect)), round(math.sqrt(area / aspect))


def _draw(choice: RendererChoice, options: RenderOptions, task: _Task) -> Picture:
    return choice.make().render(task.model, task.camera, options)
