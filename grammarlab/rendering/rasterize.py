"""OpenGL renderer, fast for large models and large pictures; shadows come from a depth map seen from the sun."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats
from grammarlab.errors import UsageError
from grammarlab.rendering.camera import Camera
from grammarlab.rendering.light.ground import ground_light
from grammarlab.rendering.light.lighting import Exposure, shade
from grammarlab.rendering.light.look import tone_map
from grammarlab.rendering.light.surfaces import SEE_THROUGH, Surfaces, side_of_viewer, sunward, unit
from grammarlab.rendering.light.textures import has_holes
from grammarlab.rendering.opengl import Buffers, painter
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import AbstractRenderer, RenderOptions
from grammarlab.rendering.shot import Rows, Samples, Shot, develop, ground_at, outlines, paper, pixels, samples, take
from grammarlab.scene import TriangleBatch

_SIDE = 1024
"""Samples along each side of the map."""
_LIFT = np.float32(4.0 / _SIDE)
"""Offset above a surface for shadow tests, in model units: two samples."""
_BIAS = np.float32(2.0 / _SIDE)
"""Largest distance behind the depth of the map at which a point is not in shadow."""
_BLUR = 1.5
"""Radius of look-ups in the map, in samples: softness of shadows."""
_LARGEST_SIDE = 8192
"""Largest number of samples along a side, supported by all current drivers."""


@final
@dataclass(frozen=True, slots=True)
class OpenGLRenderer(AbstractRenderer):
    """Sun, shadow, edges and ground as in the default renderer, without pictures, openness and mirror images.

    The default renderer draws models whose pictures have transparent parts.

    Only the nearest pane of glass in front of a solid surface is drawn.

    The picture is the same every time with one driver, and nearly the same with another.
    """

    platform: str
    """``egl`` or ``osmesa``; `grammarlab.rendering.choice` finds the one that works."""

    def render(self, batch: TriangleBatch, camera: Camera, options: RenderOptions) -> NDArray[np.uint8]:
        """See `AbstractRenderer.render`.

        Raises:
            UsageError: If pyrender is missing, or the picture is too large for OpenGL.
        """
        width, height = options.width * options.samples, options.height * options.samples
        if max(width, height) > _LARGEST_SIDE:
            raise UsageError(
                f"a picture of {options.width} x {options.height} pixels is too large for OpenGL: expected at most "
                f"{_LARGEST_SIDE // options.samples} along each side. Choose the renderer 'cast'."
            )
        behind = paper(options, 0, height)
        if len(batch.triangles) == 0:
            return develop(pixels(behind, options))
        has_images = batch.coordinates is None and bool(batch.materials.pictures)
        if has_images or has_holes(batch):
            # OpenGL's buffers have no pictures: a wall would be white, and a card with a picture of a tree no tree.
            return RaycastRenderer().render(batch, camera, options)
        shot = take(batch, camera, options, for_rays=False)
        opaque = shot.model.opacity[batch.group_material] >= SEE_THROUGH
        everything = np.ones_like(opaque)
        with painter(self.platform, batch, shot.model) as paint:
            solid = paint.buffers(shot.camera, width, height, opaque)
            front = solid if opaque.all() else paint.buffers(shot.camera, width, height, everything)
            from_sun = _sun_camera(shot.sun)
            shadows = _ShadowMap(from_sun, paint.depths(from_sun, _SIDE, opaque))
        radiance = _radiance(shot, samples(shot.camera, options, 0, height), solid, front, shadows, behind)
        return develop(pixels(radiance, options))


def _sun_camera(sun: AnyFloats) -> Camera:
    """A parallel camera in the direction of the sun [3] that sees the unit sphere."""
    back = sun.astype(np.float64) / np.linalg.norm(sun)
    right = np.cross((0.0, 1.0, 0.0) if abs(back[1]) < 0.99 else (1.0, 0.0, 0.0), back)
    right /= np.linalg.norm(right)
    return Camera(3.0 * back, np.stack([right, np.cross(back, right), back]), 1.0, parallel=True)


@dataclass(frozen=True, slots=True)
class _ShadowMap:
    """Depth map of a model in the unit sphere, seen from the sun."""

    camera: Camera
    depth: AnyFloats
    """[SIDE, SIDE] distance from the plane of the camera, 0 for nothing."""

    def visibility(self, points: AnyFloats, normals: AnyFloats, spot: AnyFloats) -> AnyFloats:
        """[N] 1 if the sun is visible from a point, otherwise 0.

        Args:
            points: [N, 3].
            normals: [N, 3] unit vectors.
            spot: [N] offset, in 0..1, of the look-up of each point.
        """
        right, up, back = self.camera.axes.astype(np.float32)
        lifted = points + _LIFT * normals
        angle = spot * np.float32(8 * np.pi)
        row = (1 - lifted @ up) * np.float32(_SIDE / 2) + _BLUR * np.sin(angle)
        column = (1 + lifted @ right) * np.float32(_SIDE / 2) + _BLUR * np.cos(angle)
        inside = (row >= 0) & (row < _SIDE) & (column >= 0) & (column < _SIDE)
        depth = self.depth[np.where(inside, row, 0).astype(int), np.where(inside, column, 0).astype(int)]
        distance = np.float32(self.camera.position @ self.camera.axes[2]) - lifted @ back
        blocked = inside & (depth > 0) & (depth < distance - _BIAS)
        return ((normals @ back > 0) & ~blocked).astype(np.float32)


def _radiance(
    shot: Shot, rays: Samples, solid: Buffers, front: Buffers, shadows: _ShadowMap, behind: AnyFloats
) -> AnyFloats:
    """[N, 3] colour of each sample, linear in 0..1: the paper, opaque surfaces, and the nearest glass in front."""
    look = shot.options.look
    on_model, visible = _surfaces(shot, rays, solid)
    on_ground, ground = ground_at(shot, rays, np.flatnonzero(solid.material.ravel() < 0))
    upward = np.broadcast_to(np.array([0, 1, 0], np.float32), ground.shape)
    radiance = behind.copy()
    radiance[on_ground] *= ground_light(look, _exposure(rays, on_ground, ground, upward, shadows))
    radiance[on_model] = tone_map(look, _light(shot, rays, on_model, visible, shadows)[0])
    if front is not solid:
        on_model, visible = _surfaces(shot, rays, front)
        glass = np.flatnonzero(shot.model.opacity[visible.material] < SEE_THROUGH)
        panes = Surfaces(visible.point[glass], visible.normal[glass], visible.flat[glass], visible.material[glass])
        rows = on_model[glass]
        light, through = _light(shot, rays, rows, panes, shadows)
        radiance[rows] = tone_map(look, light) + through[:, None] * radiance[rows]
    return outlines(shot, rays, on_model, visible).darken(radiance, shot.options)


def _surfaces(shot: Shot, rays: Samples, buffers: Buffers) -> tuple[Rows, Surfaces]:
    """Samples that show the model, and their surfaces."""
    material = buffers.material.ravel()
    rows = np.flatnonzero(material >= 0)
    directions = rays.directions[rows]
    forward = -shot.camera.axes[2].astype(np.float32)
    distance = buffers.depth.reshape(-1)[rows] / (directions @ forward)
    points = rays.origins[rows] + distance[:, None] * directions
    normals = unit(buffers.normal.reshape(-1, 3)[rows])
    normals *= side_of_viewer(normals, directions)
    return rows, Surfaces(points, normals, normals, material[rows])


def _exposure(rays: Samples, rows: Rows, points: AnyFloats, normals: AnyFloats, shadows: _ShadowMap) -> Exposure:
    """The light at points [K, 3] that belong to the samples `rows` [K]."""
    return Exposure(shadows.visibility(points, normals, rays.spot[rows]), np.ones(len(rows), np.float32))


def _light(
    shot: Shot, rays: Samples, rows: Rows, visible: Surfaces, shadows: _ShadowMap
) -> tuple[AnyFloats, AnyFloats]:
    """Result of `shade` for the surfaces of the samples `rows` [K]."""
    exposure = _exposure(rays, rows, visible.point, sunward(shot.model, visible, shot.sun), shadows)
    return shade(shot.model, visible, exposure, rays.directions[rows], shot.sun, shot.options.look)
