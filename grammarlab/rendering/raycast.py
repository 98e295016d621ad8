"""Default renderer: ray casting, the same picture on every machine."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats
from grammarlab.rendering.camera import Camera
from grammarlab.rendering.light.breaks import smooth
from grammarlab.rendering.light.ground import ground_light
from grammarlab.rendering.light.lighting import Exposure, openness, shade, sun_visibility
from grammarlab.rendering.light.look import tone_map
from grammarlab.rendering.light.rays import Hits
from grammarlab.rendering.light.surfaces import Surfaces, sunward, surfaces
from grammarlab.rendering.renderer import AbstractRenderer, RenderOptions
from grammarlab.rendering.shot import Samples, Shot, develop, ground_at, outlines, paper, pixels, samples, take
from grammarlab.scene import TriangleBatch

BAND_SAMPLES = 250_000
"""Approximate number of samples processed at a time, which bounds the memory."""
BORDER = 3
"""Rows of samples shared by bands, so that edges and smoothing continue from one to the next."""
MOST_LAYERS = 4
"""Largest number of transparent surfaces along a ray."""
VISIBLE = 0.01
"""Smallest share of transmitted light for which surfaces behind glass are traced."""


@final
class RaycastRenderer(AbstractRenderer):
    """Ray casting with sun shadow, openness (ambient occlusion), mirror images, glass and drawn edges."""

    def render(self, batch: TriangleBatch, camera: Camera, options: RenderOptions) -> NDArray[np.uint8]:
        """See `AbstractRenderer.render`; about 0.1 s for 20,000 triangles at 160 x 160 pixels."""
        shot = take(batch, camera, options, for_rays=True) if len(batch.triangles) else None
        rows_per_band = max(1, BAND_SAMPLES // (options.width * options.samples**2))
        bands = [
            _band(shot, options, first, min(first + rows_per_band, options.height))
            for first in range(0, options.height, rows_per_band)
        ]
        return develop(np.concatenate(bands))

    def cut_out(self, batch: TriangleBatch, camera: Camera, options: RenderOptions) -> NDArray[np.uint8]:
        """The picture [height, width, 4] of a batch of one model with at least one triangle, with transparent ground.

        The last channel is the share of a pixel that shows the model. There are no edges and no ground. Colours are
        those of the model, and elsewhere those of pixels nearby, so that smaller sizes of the picture have no seam.
        """
        options = replace(options, edges=False, ground=False)
        shot = take(batch, camera, options, for_rays=True)
        rows_per_band = max(1, BAND_SAMPLES // (options.width * options.samples**2))
        bands = [
            _cut_out_band(shot, options, first, min(first + rows_per_band, options.height))
            for first in range(0, options.height, rows_per_band)
        ]
        light, coverage = (np.concatenate(parts) for parts in zip(*bands, strict=True))
        colors = develop(_spread(light, coverage))
        return np.concatenate([colors, np.rint(coverage[:, :, None] * 255.0).astype(np.uint8)], axis=2)


def _cut_out_band(shot: Shot, options: RenderOptions, first: int, last: int) -> tuple[AnyFloats, AnyFloats]:
    """Light [rows, width, 3] of the model in pixel rows first..last, and its share [rows, width] of each pixel."""
    rays = samples(shot.camera, options, first * options.samples, last * options.samples)
    light = _radiance(shot, rays, np.zeros((len(rays.origins), 3), np.float32))
    is_hit = shot.model.tracer.first_hit(rays.origins, rays.directions).triangle >= 0
    coverage = pixels(np.repeat(is_hit[:, None], 3, axis=1).astype(np.float32), options)[:, :, 0]
    return pixels(light * is_hit[:, None], options) / np.maximum(coverage, 1e-6)[:, :, None], coverage


def _spread(light: AnyFloats, coverage: AnyFloats) -> AnyFloats:
    """Light [H, W, 3], where there is none that of the mean of wider and wider neighbourhoods."""
    # Imported here, since most pictures have no transparent ground.
    from scipy.ndimage import uniform_filter  # noqa: PLC0415

    spread, empty = light.copy(), coverage <= 0.0
    weight = (~empty).astype(np.float32)
    width = 3
    while empty.any() and not empty.all():
        share = uniform_filter(weight, width, mode="constant")
        reached = empty & (share > 1e-6)
        for channel in range(3):
            mean = uniform_filter(light[:, :, channel] * weight, width, mode="constant")
            spread[reached, channel] = mean[reached] / share[reached]
        empty &= ~reached
        width = 2 * width + 1
    return spread


def _band(shot: Shot | None, options: RenderOptions, first: int, last: int) -> AnyFloats:
    """Pixel rows first..last of the picture, linear [rows, width, 3]."""
    start, stop = first * options.samples - BORDER, last * options.samples + BORDER
    radiance = paper(options, start, stop)
    if shot is not None:
        radiance = _radiance(shot, samples(shot.camera, options, start, stop), radiance)
    border = BORDER * options.width * options.samples
    return pixels(radiance[border:-border], options)


def _radiance(shot: Shot, rays: Samples, behind: AnyFloats) -> AnyFloats:
    """[N, 3] colour of each sample, linear in 0..1."""
    hits = shot.model.tracer.first_hit(rays.origins, rays.directions)
    is_hit = hits.triangle >= 0
    on_model = np.flatnonzero(is_hit)
    origins, directions = rays.origins.take(on_model, axis=0), rays.directions.take(on_model, axis=0)
    visible = surfaces(shot.model, origins, directions, _hits_of(hits, on_model))
    on_ground, ground = ground_at(shot, rays, np.flatnonzero(~is_hit))

    drawn = outlines(shot, rays, on_model, visible)
    points, normals = np.concatenate([visible.point, ground]), np.concatenate([visible.flat, _upward(ground)])
    sides = np.concatenate([sunward(shot.model, visible, shot.sun), _upward(ground)])
    surface = np.concatenate([on_model, on_ground])
    light = _exposure(shot, rays, surface, points, normals, sides)
    free = np.ones(len(behind), np.float32)
    free[surface] = light.free
    free = smooth(free.reshape(rays.shape), drawn.breaks).ravel()
    lit_model, lit_ground = np.split(light.sun, [len(on_model)])
    radiance = behind.copy()
    radiance[on_ground] *= ground_light(shot.options.look, Exposure(lit_ground, free[on_ground]))
    exposure = Exposure(lit_model, free[on_model])
    radiance[on_model] = _looked_through(shot, rays, on_model, visible, exposure, behind.take(on_model, axis=0))
    return drawn.darken(radiance, shot.options)


def _exposure(
    shot: Shot, rays: Samples, rows: NDArray[np.int64], points: AnyFloats, normals: AnyFloats, sides: AnyFloats
) -> Exposure:
    """The light at points [K, 3] that belong to the samples `rows` [K].

    Args:
        shot: the picture.
        rays: its samples.
        rows: [K] samples.
        points: [K, 3].
        normals: [K, 3] unit normals.
        sides: [K, 3] unit normals of the sides that the sun lights.
    """
    blockers, options = shot.model.blockers, shot.options
    lit = sun_visibility(blockers, points, sides, shot.sun, options.look, rays.spot[rows])
    free = np.ones(len(rows), np.float32)
    if options.openness_rays:
        near = np.flatnonzero(shot.ground.is_near(points[:, 0], points[:, 2]))
        points, normals = points.take(near, axis=0), normals.take(near, axis=0)
        free[near] = openness(blockers, points, normals, rays.pattern[rows[near]], options.openness_rays)
    return Exposure(lit, free)


def _looked_through(
    shot: Shot, rays: Samples, rows: NDArray[np.int64], visible: Surfaces, exposure: Exposure, behind: AnyFloats
) -> AnyFloats:
    """[K, 3] colours of the samples `rows` [K]: surfaces from front to back, then `behind` [K, 3]."""
    model, look = shot.model, shot.options.look
    light, remaining = np.zeros_like(behind), np.ones(len(rows), np.float32)
    active = np.arange(len(rows))
    for layer in range(MOST_LAYERS):
        directions = rays.directions.take(rows[active], axis=0)
        reflected, through = shade(model, visible, exposure, directions, shot.sun, look)
        # The light on surfaces behind glass has also passed the glass.
        light[active] += (remaining[active] ** (1 if layer == 0 else 2))[:, None] * reflected
        remaining[active] *= through if layer < MOST_LAYERS - 1 else 0.0
        on = np.flatnonzero(remaining[active] > VISIBLE)
        active, directions = active[on], directions[on]
        start = visible.point[on] + np.float32(1e-4) * directions
        hits = model.tracer.first_hit(start, directions)
        hit_rows = np.flatnonzero(hits.triangle >= 0)
        rays_to_ground = active[hits.triangle < 0]
        behind[rays_to_ground] *= _ground_behind(shot, rays, rows[rays_to_ground])
        active, hits = active[hit_rows], _hits_of(hits, hit_rows)
        if len(active) == 0:
            break
        visible = surfaces(model, start[hit_rows], directions[hit_rows], hits)
        sides = sunward(model, visible, shot.sun)
        exposure = _exposure(shot, rays, rows[active], visible.point, visible.flat, sides)
    return tone_map(look, light) + remaining[:, None] * behind


def _hits_of(hits: Hits, rows: NDArray[np.int64]) -> Hits:
    return Hits(hits.triangle[rows], hits.distance[rows], hits.u[rows], hits.v[rows])


def _ground_behind(shot: Shot, rays: Samples, rows: NDArray[np.int64]) -> AnyFloats:
    """[K, 3] shadow factor of the paper at samples `rows` [K] that see the ground through glass."""
    factor = np.ones((len(rows), 3), np.float32)
    on_ground, points = ground_at(shot, rays, rows)
    upward = _upward(points)
    light = ground_light(shot.options.look, _exposure(shot, rays, on_ground, points, upward, upward))
    factor[np.searchsorted(rows, on_ground)] = light
    return factor


def _upward(points: AnyFloats) -> AnyFloats:
    """[N, 3] the normals of level ground."""
    return np.broadcast_to(np.array([0, 1, 0], np.float32), points.shape)
