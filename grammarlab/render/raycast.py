"""The default renderer: rays against triangles, the same picture on every machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from grammarlab.render.camera import Camera
from grammarlab.render.edges import edge_strength
from grammarlab.render.lighting import openness, shade, sun_visibility
from grammarlab.render.look import background, sun_direction, tone_map
from grammarlab.render.rays import Hits
from grammarlab.render.renderer import AbstractRenderer, RenderOptions
from grammarlab.render.surfaces import Model, prepare, surfaces
from grammarlab.scene import TriangleBatch
from grammarlab.scene.color import srgb_from_linear

Floats = NDArray[np.float32]

BAND_SAMPLES = 250_000
"""About how many samples are worked on at a time: what large pictures need in memory."""
MOST_LAYERS = 4
"""How many see-through surfaces one behind the other are looked through."""
GROUND_REACH = 3.5
"""How far from the model the ground can be dimmed by it, in model units."""
GROUND_NORMAL = np.array([0.0, 1.0, 0.0], np.float32)


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
    sample: NDArray[np.int64]
    """[N] 0..15, which of the patterns of shadow and openness rays to use."""


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
    # One more row of samples on each side lets edges run on across bands.
    start, stop = first * samples - 1, last * samples + 1
    rays = _rays(model, camera, options, start, stop)
    paper = background(options.look, rays.height)
    shown = paper if model is None else _shown(model, camera, options, rays, paper)
    inner = shown.reshape(*rays.shape, 3)[1:-1]
    return inner.reshape(last - first, samples, options.width, samples, 3).mean(axis=(1, 3))


def _rays(model: Model | None, camera: Camera, options: RenderOptions, start: int, stop: int) -> _Rays:
    width, height = options.width * options.samples, options.height * options.samples
    row, column = np.mgrid[start:stop, 0:width].reshape(2, -1)
    x, y = (column + 0.5) / width * 2.0 - 1.0, 1.0 - (row + 0.5) / height * 2.0
    origins, directions = camera.rays(x, y, options.width / options.height)
    if model is not None:
        origins = ((origins - model.origin) / model.radius).astype(np.float32)
    sample = (row % 4) * 4 + (column + row // 4) % 4
    return _Rays((stop - start, width), origins, directions, y.astype(np.float32), sample)


def _shown(model: Model, camera: Camera, options: RenderOptions, rays: _Rays, paper: Floats) -> Floats:
    """[N, 3] what each sample shows, linear in 0..1."""
    sun = sun_direction(options.look, camera.axes)
    if options.ground:
        paper = paper * _ground_light(model, options, rays, sun)
    hits = model.tracer.first_hit(rays.origins, rays.directions)
    shown = _looked_through(model, options, rays, hits, sun, paper)
    if options.edges:
        shown *= (1.0 - options.look.edge * _edges(model, camera, options, rays, hits))[:, None]
    return shown


def _looked_through(
    model: Model, options: RenderOptions, rays: _Rays, hits: Hits, sun: Floats, paper: Floats
) -> Floats:
    """Front to back through see-through surfaces, onto the paper."""
    look = options.look
    light = np.zeros_like(paper)
    remaining = np.ones(len(paper), np.float32)
    active = np.flatnonzero(hits.triangle >= 0)
    origins, directions = rays.origins, rays.directions
    hits = _at(hits, active)
    is_covered = np.zeros(len(paper), bool)
    is_covered[active] = True
    for _ in range(MOST_LAYERS):
        if len(active) == 0:
            break
        seen = surfaces(model, origins[active], directions[active], hits)
        sent, through = shade(model, seen, directions[active], sun, look, rays.sample[active], options.openness_rays)
        light[active] += remaining[active, None] * sent
        remaining[active] *= through
        on = through > 0.01
        active = active[on]
        ahead = seen.point[on] + np.float32(1e-4) * directions[active]
        hits = model.tracer.first_hit(ahead, directions[active])
        met = hits.triangle >= 0
        active, hits = active[met], _at(hits, np.flatnonzero(met))
        origins = origins.copy()
        origins[active] = ahead[met]
    shown = tone_map(look, light)
    behind = np.where(is_covered, remaining, 1.0)
    behind[active] = 0.0
    return shown + behind[:, None] * paper


def _at(hits: Hits, rows: NDArray[np.int64]) -> Hits:
    return Hits(hits.triangle[rows], hits.distance[rows], hits.u[rows], hits.v[rows])


def _ground_light(model: Model, options: RenderOptions, rays: _Rays, sun: Floats) -> Floats:
    """[N, 3] what the model's shadow leaves of the paper that it stands on."""
    look = options.look
    left = np.ones((len(rays.origins), 3), np.float32)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (model.ground - rays.origins[:, 1]) / rays.directions[:, 1]
    points = rays.origins + np.nan_to_num(distance, posinf=0.0, neginf=0.0)[:, None] * rays.directions
    away = np.hypot(points[:, 0], points[:, 2])
    on_ground = np.flatnonzero((distance > 0) & (away < GROUND_REACH))
    points = points[on_ground]
    normals = np.broadcast_to(GROUND_NORMAL, points.shape)
    sample = rays.sample[on_ground]
    dark = 1.0 - sun_visibility(model.blockers, points, normals, sun, look, sample)
    left[on_ground] -= dark[:, None] * (1.0 - np.array(look.shadow, np.float32))
    near = away[on_ground] < 1.6
    if options.openness_rays:
        closed = 1.0 - openness(model.blockers, points[near], normals[near], sample[near], options.openness_rays)
        left[on_ground[near]] *= 1.0 - closed[:, None] * (1.0 - np.array(look.contact, np.float32))
    return left


def _edges(model: Model, camera: Camera, options: RenderOptions, rays: _Rays, hits: Hits) -> Floats:
    """[N] strength of the drawn edge at each sample."""
    hit = hits.triangle >= 0
    rows = np.flatnonzero(hit)
    seen = surfaces(model, rays.origins[rows], rays.directions[rows], _at(hits, rows))
    points, normals = np.zeros((len(hit), 3), np.float32), np.zeros((len(hit), 3), np.float32)
    points[rows], normals[rows] = seen.point, seen.normal
    away = np.median(hits.distance[rows]) if len(rows) and not camera.parallel else 1.0
    reach = 1.0 / model.radius if camera.parallel else float(away)
    spacing = 2.0 * camera.half_height * reach / (options.height * options.samples)
    shape = rays.shape
    return edge_strength(hit.reshape(shape), points.reshape(*shape, 3), normals.reshape(*shape, 3), spacing).ravel()
