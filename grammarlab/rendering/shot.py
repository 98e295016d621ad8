"""Steps shared by all renderers: a model in front of the camera, ground, samples of a picture, edges and pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats
from grammarlab.assets.srgb import srgb_from_linear
from grammarlab.rendering.camera import Camera
from grammarlab.rendering.light.breaks import Breaks, edge_strength, find_breaks
from grammarlab.rendering.light.ground import Ground, ground_below
from grammarlab.rendering.light.look import background, sun_direction
from grammarlab.rendering.light.surfaces import ShadedModel, Surfaces, prepare
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.scene import TriangleBatch

Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Samples:
    """One ray per sample for rows of samples."""

    shape: tuple[int, int]
    """[H, W], with N = H * W."""
    origins: AnyFloats
    """[N, 3] in the camera's units."""
    directions: AnyFloats
    """[N, 3] unit vectors."""
    pattern: NDArray[np.int32]
    """[N] 0..15, repeating every 4 x 4 samples: selects openness rays."""
    spot: AnyFloats
    """[N] in 0..1, evenly spread within each pixel: selects a point of the sun."""


@dataclass(frozen=True, slots=True)
class Shot:
    """Inputs of a picture, in model units."""

    model: ShadedModel
    camera: Camera
    ground: Ground
    sun: AnyFloats
    """[3] direction of the middle of the sun."""
    options: RenderOptions


@dataclass(frozen=True, slots=True)
class Outlines:
    """Breaks between samples of different surfaces."""

    shows: NDArray[np.bool_]
    """[H, W] whether a sample shows the model."""
    breaks: tuple[Breaks, Breaks]
    bare: NDArray[np.bool_] | None = None
    """[N] samples without edges: leaves, of which there would be nothing but edges; None for none."""

    def darken(self, radiance: AnyFloats, options: RenderOptions) -> AnyFloats:
        """The samples [N, 3] with edges, depending on the options."""
        if not options.edges:
            return radiance
        strength = edge_strength(self.shows, self.breaks).reshape(-1, 1)
        if self.bare is not None:
            strength[self.bare] = 0.0
        return radiance * (1.0 - np.float32(options.look.edge) * strength)


def take(batch: TriangleBatch, camera: Camera, options: RenderOptions, *, for_rays: bool) -> Shot:
    """A batch of one model with at least one triangle, in front of a camera.

    Raises:
        UsageError: as `prepare`.
    """
    model = prepare(batch, for_rays=for_rays, spacing=_spacings(batch, camera, options))
    sun = sun_direction(options.look, camera.axes)
    ground = ground_below(model.low, model.high, float(model.low[1]), sun, options.look)
    return Shot(model, camera.seen_from(model.origin, model.radius), ground, sun, options)


def samples(camera: Camera, options: RenderOptions, start: int, stop: int) -> Samples:
    """The samples of the rows start..stop, which may lie outside the picture."""
    across = options.samples
    width = options.width * across
    row, column = np.arange(start, stop), np.arange(width)
    x = ((column + 0.5) / width * 2.0 - 1.0).astype(np.float32)
    origins, directions = camera.rays(x, _heights(options, start, stop), options.width / options.height)
    within_pixel = (row % across * across)[:, None] + column % across
    pattern = (row % 4 * 4)[:, None] + column % 4
    spot = (within_pixel.ravel().astype(np.float32) + np.float32(0.5)) / np.float32(across * across)
    return Samples((len(row), width), origins, directions, pattern.ravel().astype(np.int32), spot)


def ground_at(shot: Shot, rays: Samples, rows: Rows) -> tuple[Rows, AnyFloats]:
    """Samples among `rows` that meet the ground where the model can darken it, and the points [K, 3]."""
    if not shot.options.ground:
        return rows[:0], np.zeros((0, 3), np.float32)
    is_hit, points = shot.ground.meet(rays.origins[rows], rays.directions[rows])
    return rows[is_hit], points


def outlines(shot: Shot, rays: Samples, on_model: Rows, visible: Surfaces) -> Outlines:
    """Outlines in a picture in which the samples `on_model` [K] show K surfaces."""
    shape = rays.shape
    shows = np.zeros(len(rays.origins), bool)
    points, normals = np.zeros((len(shows), 3), np.float32), np.zeros((len(shows), 3), np.float32)
    shows[on_model], points[on_model], normals[on_model] = True, visible.point, visible.normal
    bare = None
    if shot.model.thin is not None:
        bare = np.zeros(len(shows), bool)
        bare[on_model] = shot.model.thin[visible.material]
    shows = shows.reshape(shape)
    breaks = find_breaks(shows, points.reshape(*shape, 3), normals.reshape(*shape, 3), _spacing(shot))
    return Outlines(shows, breaks, bare)


def paper(options: RenderOptions, start: int, stop: int) -> AnyFloats:
    """[N, 3] colours of the background for samples of rows, linear in 0..1."""
    colors = background(options.look, _heights(options, start, stop))
    return np.repeat(colors, options.width * options.samples, axis=0)


def pixels(radiance: AnyFloats, options: RenderOptions) -> AnyFloats:
    """[rows, width, 3] the means of the samples [N, 3] in each pixel of whole rows."""
    across = options.samples
    # One axis after the other is faster than a mean over both at once.
    lines = radiance.reshape(-1, across, options.width * across * 3).mean(axis=1)
    return lines.reshape(-1, options.width, across, 3).mean(axis=2)


def develop(light: AnyFloats) -> NDArray[np.uint8]:
    """[H, W, 3] sRGB from linear 0..1."""
    return np.rint(srgb_from_linear(light) * 255.0).astype(np.uint8)


def _heights(options: RenderOptions, start: int, stop: int) -> AnyFloats:
    """[stop - start] heights of rows of samples in the picture, 1 at the top to -1 at the bottom."""
    rows = np.arange(start, stop)
    return (1.0 - (rows + 0.5) / (options.height * options.samples) * 2.0).astype(np.float32)


def _spacings(batch: TriangleBatch, camera: Camera, options: RenderOptions) -> AnyFloats | float:
    """[T] metres between neighbouring samples on triangles that face the camera; 0 for models without pictures."""
    if not batch.materials.pictures:
        return 0.0
    step = 2.0 * camera.half_height / (options.height * options.samples)
    if camera.parallel:
        return step
    return step * np.linalg.norm(batch.vertices[batch.triangles[:, 0]] - camera.position, axis=1)


def _spacing(shot: Shot) -> float:
    """Distance in model units between neighbouring samples at the middle of the model."""
    camera, options = shot.camera, shot.options
    reach = 1.0 if camera.parallel else float(np.linalg.norm(camera.position))
    return 2.0 * camera.half_height * reach / (options.height * options.samples)
