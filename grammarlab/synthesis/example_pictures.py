"""Pictures of examples and results: buildings, label arrays, and walls from the front."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw

from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.rendering.camera import View, frame
from grammarlab.rendering.light.look import Look
from grammarlab.rendering.raycast import RaycastRenderer
from grammarlab.rendering.renderer import RenderOptions
from grammarlab.scene import TriangleBatch
from grammarlab.synthesis.analysis.example import Example, Region
from grammarlab.synthesis.analysis.walls import depth_map
from grammarlab.synthesis.label_grid import LabelGrid
from grammarlab.synthesis.mesh.surface import Color, Surface
from grammarlab.synthesis.mesh.views import seen_from

_PIXELS = 400_000
"""Approximate number of pixels of a picture."""
_SKY = (236, 239, 242)
"""Color of empty pixels, 0 to 255."""
_HALF_BRIGHTNESS_DEPTH_M = 0.35
"""Depth behind the plane of the wall at which brightness is halved, metres."""
_VIEW = View(azimuth=28.0, elevation=16.0)
_LARGEST = 900
"""Largest side of a label picture, pixels."""


def wall_picture(example: Example, region: Region) -> Image.Image:
    """The wall between its lower left and upper right corner, in the colors of its materials; depth is dark."""
    corners = seen_from(region.side, example.surface.points)[example.surface.triangles]
    low, high = region.wall
    low_seen, high_seen = corners.min(axis=1), corners.max(axis=1)
    near = (high_seen[:, :2] > low).all(axis=1) & (low_seen[:, :2] < high).all(axis=1)
    near &= (high_seen[:, 2] >= region.back) & (low_seen[:, 2] <= region.front)
    rows = np.flatnonzero(near)
    wall_map = depth_map(corners[rows], _PIXELS)
    part = wall_map.rows(low[1], high[1]), wall_map.columns(low[0], high[0])
    triangle, depth = wall_map.triangle[part], wall_map.depth[part]
    colors = np.array(example.mesh.colors)[:, :3] * 255.0
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat = np.abs(facing[:, 2]) / np.maximum(np.linalg.norm(facing, axis=1), 1e-12)
    chosen = rows[np.maximum(triangle, 0)]
    behind = np.clip(region.plane - np.where(triangle >= 0, depth, region.plane), 0.0, 2.0)
    light = (0.55 + 0.45 * flat[chosen]) / (1.0 + behind / _HALF_BRIGHTNESS_DEPTH_M * 0.5)
    shaded = colors[example.surface.material[chosen]] * light[..., None]
    shaded[triangle < 0] = _SKY
    return Image.fromarray(np.clip(shaded[::-1], 0, 255).astype(np.uint8))


def label_picture(grid: LabelGrid, cell: int = 28) -> Image.Image:
    """Each cell in the color of its label, the lowest row at the bottom; a legend of labels beneath."""
    cell = max(4, min(cell, _LARGEST // max(grid.rows, grid.columns)))
    colors = np.array([_color(k) for k in range(len(grid.names))] + [(255, 255, 255)], dtype=np.uint8)
    cells = np.kron(colors[grid.labels[::-1]], np.ones((cell, cell, 1), dtype=np.uint8))
    if cell >= 8:
        cells[::cell], cells[:, ::cell] = 255, 255
    width = max(cells.shape[1], 120)
    page = Image.new("RGB", (width, cells.shape[0] + 8 + 16 * len(grid.names[:12])), "white")
    page.paste(Image.fromarray(cells), (0, 0))
    pen = ImageDraw.Draw(page)
    for number, name in enumerate(grid.names[:12]):
        top = cells.shape[0] + 8 + 16 * number
        pen.rectangle((0, top, 10, top + 10), fill=_color(number))
        pen.text((16, top - 1), name[:40], fill="black")
    return page


def building_picture(surface: Surface, colors: Sequence[Color], size: tuple[int, int] = (480, 400)) -> Image.Image:
    """A building from the front right."""
    batch = _triangle_batch(surface, colors)
    options = RenderOptions(
        width=size[0], height=size[1], samples=2, openness_rays=2, ground=True, view=_VIEW, look=Look()
    )
    camera = frame(batch.vertices, size[0] / size[1], _VIEW)
    return Image.fromarray(RaycastRenderer().render(batch, camera, options))


def _color(number: int) -> tuple[int, int, int]:
    # Steps by the golden ratio give well separated hues for any number of labels.
    red, green, blue = colorsys.hls_to_rgb((0.58 + 0.618034 * number) % 1.0, 0.62 - 0.12 * (number % 3 == 2), 0.5)
    return round(255 * red), round(255 * green), round(255 * blue)


def _triangle_batch(surface: Surface, colors: Sequence[Color]) -> TriangleBatch:
    """A surface for renderers: flat-shaded, sorted by material."""
    order = np.argsort(surface.material, kind="stable")
    corners = surface.corners()[order]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    used, counts = np.unique(surface.material, return_counts=True)
    ends = np.concatenate([[0], np.cumsum(counts)])
    channels = np.array([_channels(colors[material]) for material in used.tolist()])
    return TriangleBatch(
        num_models=1,
        materials=Materials(channels, ("",) * len(used)),
        vertices=corners.reshape(-1, 3).astype(np.float32),
        normals=np.repeat(normals, 3, axis=0).astype(np.float32),
        triangles=np.arange(3 * len(order), dtype=np.uint32).reshape(-1, 3),
        group_model=np.zeros(len(used), np.int32),
        group_material=np.arange(len(used), dtype=np.int32),
        group_vertices=3 * ends,
        group_triangles=ends,
        model_groups=np.array([0, len(used)]),
        texture_map=np.full(len(order), -1, np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=np.zeros((1, 3)),
    )


def _channels(color: Color) -> list[float]:
    red, green, blue, _ = color
    return list({**CHANNELS, "color.r": red, "color.g": green, "color.b": blue}.values())
