"""Steps shared by all renderers: a model in front of the camera, the ground below it, its edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.rendering.camera import Camera
from grammarlab.rendering.film import Samples
from grammarlab.rendering.light.edges import Breaks, edge_strength, find_breaks
from grammarlab.rendering.light.ground import Ground, ground_below
from grammarlab.rendering.light.look import sun_direction
from grammarlab.rendering.light.surfaces import ShadedModel, Surfaces, prepare
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.scene import TriangleBatch

Floats = NDArray[np.floating]
Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Shot:
    """Inputs of a picture, in model units."""

    model: ShadedModel
    camera: Camera
    ground: Ground
    sun: Floats
    """[3] direction of the middle of the sun."""
    options: RenderOptions


@dataclass(frozen=True, slots=True)
class Outlines:
    """Breaks between samples of different surfaces."""

    shows: NDArray[np.bool_]
    """[H, W] whether a sample shows the model."""
    breaks: tuple[Breaks, Breaks]

    def darken(self, shown: Floats, options: RenderOptions) -> Floats:
        """The samples [N, 3] with edges, depending on the options."""
        if not options.edges:
            return shown
        return shown * (1.0 - np.float32(options.look.edge) * edge_strength(self.shows, self.breaks).reshape(-1, 1))


def take(batch: TriangleBatch, camera: Camera, options: RenderOptions, *, for_rays: bool) -> Shot:
    """A batch of one model with at least one triangle, in front of a camera.

    Raises:
        UsageError: as `prepare`.
    """
    model = prepare(batch, for_rays=for_rays)
    sun = sun_direction(options.look, camera.axes)
    ground = ground_below(model.low, model.high, float(model.low[1]), sun, options.look)
    return Shot(model, camera.seen_from(model.origin, model.radius), ground, sun, options)


def ground_at(shot: Shot, rays: Samples, rows: Rows) -> tuple[Rows, Floats]:
    """Samples among `rows` that meet the ground where the model can darken it, and the points [K, 3]."""
    if not shot.options.ground:
        return rows[:0], np.zeros((0, 3), np.float32)
    met, points = shot.ground.meet(rays.origins[rows], rays.directions[rows])
    return rows[met], points


def outlines(shot: Shot, rays: Samples, on_model: Rows, seen: Surfaces) -> Outlines:
    """Outlines in a picture in which the samples `on_model` [K] show K surfaces."""
    shape = rays.shape
    shows = np.zeros(len(rays.origins), bool)
    points, normals = np.zeros((len(shows), 3), np.float32), np.zeros((len(shows), 3), np.float32)
    shows[on_model], points[on_model], normals[on_model] = True, seen.point, seen.normal
    shows = shows.reshape(shape)
    return Outlines(shows, find_breaks(shows, points.reshape(*shape, 3), normals.reshape(*shape, 3), _spacing(shot)))


def _spacing(shot: Shot) -> float:
    """Distance in model units between neighbouring samples at the middle of the model."""
    camera, options = shot.camera, shot.options
    reach = 1.0 if camera.parallel else float(np.linalg.norm(camera.position))
    return 2.0 * camera.half_height * reach / (options.height * options.samples)
