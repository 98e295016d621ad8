"""The default renderer: rays against triangles, the same picture on every machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from grammarlab.render.camera import Camera
from grammarlab.render.edges import GROUND, MODEL, NOTHING, edge_strength, find_breaks, smooth
from grammarlab.render.lighting import Exposure, openness, shade, sun_visibility
from grammarlab.render.look import background, sun_direction, tone_map
from grammarlab.render.rays import Hits
from grammarlab.render.renderer import AbstractRenderer, RenderOptions
from grammarlab.render.surfaces import Model, Surfaces, prepare, surfaces
from grammarlab.scene import TriangleBatch
from grammarlab.scene.color import srgb_from_linear

Floats = NDArray[np.floating]

BAND_SAMPLES = 250_000
"""About how many samples are worked on at a time: what large pictures need in memory."""
BORDER = 3
"""Rows of samples that bands share, so that edges and smoothing run on from one to the next."""
MOST_LAYERS = 4
"""How many see-through surfaces one behind the other are looked through."""
GROUND_REACH = 3.5
"""How far from the model its shadow is looked for, in model units."""
CONTACT_REACH = 1.6
"""How far from the model the ground can be less open, in model units."""


@dataclass(frozen=True, slots=True)
class _Rays:
    """One ray a sample for some rows of samples."""

    shape: tuple[int, int]
    origins: Floats
    """[N, 3] in model units."""
    directions: Floats
    """[N, 3] unit vectors."""
    height: Floats
    """[N] place in the picture, -1 at the bottom to 1 at the top."""
    pattern: NDArray[np.int32]
    """[N] 0..15, repeating every 4 x 4 samples: which of the openness rays to use."""
    spot: Floats
    """[N] in 0..1, evenly spread within each pixel: which spot of the sun to look at."""


@final
class RaycastRenderer(AbstractRenderer):
    """Ray casting with sun shadow, openness (ambient occlusion), mirror images, glass and drawn edges."""

    def render(self, batch: TriangleBatch, camera: Camera, options: RenderOptions) -> NDArray[np.uint8]:
        """As `AbstractRenderer.render`; about 0.1 s for 20,000 triangles at 160 x 160 pixels."""
        model = prepare(batch) if len(batch.triangles) else None
        rows_per_band = max(1, BAND_SAMPLES // (options.width * options.samples**2))
        bands = [
            _band(model, camera, options, first, min(first + rows_per_band, options.height))
            for first in range(0, options.height, rows_per_band)
        ]
        return np.rint(srgb_from_linear(np.concatenate(bands)) * 255.0).astype(np.uint8)


def _band(model: Model | None, camera: Camera, options: RenderOptions, first: int, last: int) -> Floats:
    """Pixel rows first..last of the picture, linear [rows, width, 3]."""
    samples = options.samples
    rays = _rays(model, camera, options, first * samples - BORDER, last * samples + BORDER)
    paper = background(options.look, rays.height)
    shown = paper if model is None else _shown(model, camera, options, rays, paper)
    inner = shown.reshape(*rays.shape, 3)[BORDER:-BORDER]
    return inner.reshape(last - first, samples, options.width, samples, 3).mean(axis=(1, 3))


def _rays(model: Model | None, camera: Camera, options: RenderOptions, start: int, stop: int) -> _Rays:
    width, height = options.width * options.samples, options.height * options.samples
    row, column = np.arange(start, stop), np.arange(width)
    x = np.tile(((column + 0.5) / width * 2.0 - 1.0).astype(np.float32), len(row))
    y = np.repeat((1.0 - (row + 0.5) / height * 2.0).astype(np.float32), width)
    origins, directions = camera.rays(x, y, options.width / options.height)
    if model is not None:
        origins = ((origins - model.origin.astype(np.float32)) / np.float32(model.radius)).astype(np.float32)
    across = options.samples
    within_pixel = (row % across * across)[:, None] + column % across
    pattern = (row % 4 * 4)[:, None] + column % 4
    spot = (within_pixel.ravel().astype(np.float32) + np.float32(0.5)) / np.float32(across * across)
    return _Rays((len(row), width), origins, directions, y, pattern.ravel().astype(np.int32), spot)


def _shown(model: Model, camera: Camera, options: RenderOptions, rays: _Rays, paper: Floats) -> Floats:
    """[N, 3] what each sample shows, linear in 0..1."""
    look = options.look
    sun = sun_direction(look, camera.axes)
    hits = model.tracer.first_hit(rays.origins, rays.directions)
    on_model = np.flatnonzero(hits.triangle >= 0)
    seen = surfaces(model, rays.origins[on_model], rays.directions[on_model], _at(hits, on_model))
    on_ground, ground = _ground_points(model, options, rays, hits.triangle < 0)

    num = len(rays.origins)
    shows = np.full(num, NOTHING, np.int8)
    points, normals = np.zeros((num, 3), np.float32), np.zeros((num, 3), np.float32)
    shows[on_ground], points[on_ground], normals[on_ground] = GROUND, ground, (0.0, 1.0, 0.0)
    shows[on_model], points[on_model], normals[on_model] = MODEL, seen.point, seen.normal
    shape = rays.shape
    spacing = _spacing(model, camera, options)
    breaks = find_breaks(shows.reshape(shape), points.reshape(*shape, 3), normals.reshape(*shape, 3), spacing)

    normals[on_model] = seen.flat
    surface = np.flatnonzero(shows != NOTHING)
    light = _exposure(model, options, rays, sun, surface, points[surface], normals[surface])
    free, lit = np.ones(num, np.float32), np.ones(num, np.float32)
    free[surface], lit[surface] = light.free, light.sun
    free = smooth(free.reshape(shape), breaks).ravel()
    shown = paper.copy()
    shown[on_ground] *= _ground_light(options, Exposure(lit[on_ground], free[on_ground]))
    shown[on_model] = _looked_through(
        model, options, rays, on_model, seen, Exposure(lit[on_model], free[on_model]), sun, paper[on_model]
    )
    if options.edges:
        shown *= 1.0 - np.float32(look.edge) * edge_strength(shows.reshape(shape), breaks).reshape(-1, 1)
    return shown


def _exposure(
    model: Model,
    options: RenderOptions,
    rays: _Rays,
    sun: Floats,
    rows: NDArray[np.int64],
    points: Floats,
    normals: Floats,
) -> Exposure:
    """The light at points [K, 3] that belong to the samples `rows` [K]."""
    blockers = model.blockers
    lit = sun_visibility(blockers, points, normals, sun, options.look, rays.spot[rows])
    free = np.ones(len(rows), np.float32)
    if options.openness_rays:
        near = np.flatnonzero(np.einsum("ij,ij->i", points, points) < CONTACT_REACH**2)
        free[near] = openness(blockers, points[near], normals[near], rays.pattern[rows[near]], options.openness_rays)
    return Exposure(lit, free)


def _looked_through(
    model: Model,
    options: RenderOptions,
    rays: _Rays,
    rows: NDArray[np.int64],
    seen: Surfaces,
    exposure: Exposure,
    sun: Floats,
    paper: Floats,
) -> Floats:
    """[K, 3] what the samples `rows` [K] show: surfaces from front to back, then the paper [K, 3]."""
    light, remaining = np.zeros_like(paper), np.ones(len(rows), np.float32)
    active = np.arange(len(rows))
    for layer in range(MOST_LAYERS):
        directions = rays.directions[rows[active]]
        sent, through = shade(model, seen, exposure, directions, sun, options.look)
        # The light on what stands behind glass has come through it, too.
        light[active] += (remaining[active] ** (1 if layer == 0 else 2))[:, None] * sent
        remaining[active] *= through if layer < MOST_LAYERS - 1 else 0.0
        on = np.flatnonzero(remaining[active] > 0.01)
        active, directions = active[on], directions[on]
        start = seen.point[on] + np.float32(1e-4) * directions
        hits = model.tracer.first_hit(start, directions)
        met = np.flatnonzero(hits.triangle >= 0)
        missed = active[hits.triangle < 0]
        paper[missed] *= _ground_behind(model, options, rays, rows[missed], sun)
        active, hits = active[met], _at(hits, met)
        if len(active) == 0:
            break
        seen = surfaces(model, start[met], directions[met], hits)
        exposure = _exposure(model, options, rays, sun, rows[active], seen.point, seen.flat)
    return tone_map(options.look, light) + remaining[:, None] * paper


def _at(hits: Hits, rows: NDArray[np.int64]) -> Hits:
    return Hits(hits.triangle[rows], hits.distance[rows], hits.u[rows], hits.v[rows])


def _ground_points(
    model: Model, options: RenderOptions, rays: _Rays, candidates: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], Floats]:
    """Which of the candidate samples [N] meet the ground near the model, and where [K, 3]."""
    down = candidates & (rays.directions[:, 1] < -1e-6) & options.ground
    rows = np.flatnonzero(down)
    origins, directions = rays.origins[rows], rays.directions[rows]
    distance = (np.float32(model.ground) - origins[:, 1]) / directions[:, 1]
    points = origins + distance[:, None] * directions
    near = (distance > 0) & (points[:, 0] ** 2 + points[:, 2] ** 2 < GROUND_REACH**2)
    return rows[near], points[near]


def _ground_behind(model: Model, options: RenderOptions, rays: _Rays, rows: NDArray[np.int64], sun: Floats) -> Floats:
    """[K, 3] what shadows leave of the paper at samples `rows` [K] that look through glass at the ground."""
    left = np.ones((len(rows), 3), np.float32)
    wanted = np.zeros(len(rays.origins), bool)
    wanted[rows] = True
    on_ground, points = _ground_points(model, options, rays, wanted)
    normals = np.broadcast_to(np.array([0, 1, 0], np.float32), points.shape)
    light = _ground_light(options, _exposure(model, options, rays, sun, on_ground, points, normals))
    left[np.searchsorted(rows, on_ground)] = light
    return left


def _ground_light(options: RenderOptions, exposure: Exposure) -> Floats:
    """[K, 3] what the model's shadow and nearness leave of the paper that it stands on."""
    shadow, contact = np.array(options.look.shadow, np.float32), np.array(options.look.contact, np.float32)
    in_shadow = 1.0 - (1.0 - exposure.sun)[:, None] * (1.0 - shadow)
    return in_shadow * (1.0 - (1.0 - exposure.free)[:, None] * (1.0 - contact))


def _spacing(model: Model, camera: Camera, options: RenderOptions) -> float:
    """Distance in model units between neighbouring samples at the middle of the model."""
    if camera.parallel:
        reach = 1.0 / model.radius
    else:
        reach = float(np.linalg.norm(camera.position - model.origin)) / model.radius
    return 2.0 * camera.half_height * reach / (options.height * options.samples)
