"""Scenes of fewer triangles, for models seen from afar.

The shapes of a model lie in few planes: walls with their windows and sills, and roofs. Each becomes one polygon, and
the largest ones are kept. Where they do not reach the bounding box of the model, a side of a shape that does is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.export.tiles.block_file import polygon_scene
from grammarlab.export.tiles.covered import is_covered
from grammarlab.export.tiles.facets import facets
from grammarlab.export.tiles.plane_outlines import Outlines, outlines, within_budget
from grammarlab.export.tiles.planes import planes
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.instance_bounds import instance_bounds
from grammarlab.scene.instances import Scene
from grammarlab.scene.shading import linear_from_srgb, srgb_from_linear

PLAIN_TRIANGLES = 300
"""Most triangles of a model of level ``plain``."""
BLOCK_TRIANGLES = 30
"""Most triangles of a model of level ``block``."""
_TOLERANCE = 0.01
"""Largest distance from a side of the bounding box, as a share of its length."""
_SIDE_TRIANGLES = 2
_COLOR_STEPS = 63.0
"""Steps of sRGB, so that models share materials."""


def simplified(scene: Scene, budgets: Sequence[int] = (PLAIN_TRIANGLES, BLOCK_TRIANGLES)) -> tuple[Scene, ...]:
    """Each model of a scene as its largest walls and roofs, within its bounding box.

    Args:
        scene: B models.
        budgets: for each result, the largest number of triangles of a model, at least 24.

    Returns:
        Scenes of B models in one instance per wall or roof, each of the mean colour of what it replaces. The same for
        a model alone and in a batch.
    """
    light = linear_from_srgb(scene.materials.color).astype(np.float64)
    walls = planes(facets(scene))
    walls = walls.take(np.flatnonzero(~is_covered(walls, scene.num_models)))
    polygons = outlines(walls, light)
    bounds = instance_bounds(scene)
    scenes = []
    for budget in budgets:
        most = np.full(scene.num_models, budget - 6 * _SIDE_TRIANGLES)
        largest = within_budget(polygons, most, scene.num_models)
        scenes.append(_scene_of(largest.joined(_missing_sides(scene, bounds, largest, light)), scene))
    return tuple(scenes)


def _missing_sides(scene: Scene, bounds: tuple[Floats, Floats], polygons: Outlines, light: Floats) -> Outlines:
    """Rectangles of shapes that reach sides of the bounding boxes of models, where the polygons do not.

    Args:
        scene: I shapes.
        bounds: corners [I, 3] of their boxes.
        polygons: what is drawn otherwise.
        light: [K, 3] linear colours of the materials.
    """
    low, high = bounds
    starts = np.flatnonzero(np.diff(scene.model, prepend=-1))
    rectangles, rows = [np.zeros((0, 4, 3))], [np.zeros(0, dtype=np.int64)]
    if len(starts):
        corner_model = np.repeat(polygons.model, np.diff(polygons.offsets))
        extent = np.maximum.reduceat(high, starts) - np.minimum.reduceat(low, starts)
        for axis in range(3):
            for sign, reach in ((-1.0, -low[:, axis]), (1.0, high[:, axis])):
                farthest = np.maximum.reduceat(reach, starts)
                shown = np.full(scene.num_models, -np.inf)
                np.maximum.at(shown, corner_model, sign * polygons.points[:, axis])
                missing = farthest - shown[scene.model[starts]] > _TOLERANCE * extent[:, axis]
                spans = np.diff(np.append(starts, len(scene)))
                candidates = np.flatnonzero((reach == farthest.repeat(spans)) & missing.repeat(spans))
                row = candidates[np.flatnonzero(np.diff(scene.model[candidates], prepend=-1))]
                rows.append(row)
                rectangles.append(_sides(scene, row, axis, sign))
    row = np.concatenate(rows)
    return Outlines(
        np.concatenate(rectangles).reshape(-1, 3),
        4 * np.arange(len(row) + 1),
        scene.model[row].astype(np.int64),
        light[scene.material[row]],
        np.zeros(len(row)),
    )


def _sides(scene: Scene, rows: Ints, axis: int, sign: float) -> Floats:
    """[n, 4, 3] the largest side of the box of shapes at the corner that is farthest along an axis."""
    mesh_low, mesh_high = scene.meshes.bounds()
    mesh, size, frame = scene.mesh[rows], scene.size[rows], scene.frames[scene.frame[rows]]
    low, high = mesh_low[mesh] * size, mesh_high[mesh] * size
    near = np.where(sign * frame[:, axis, :] < 0.0, low, high)
    far = low + high - near
    flat = np.argmin(np.abs(high - low), axis=1)
    first, second = (flat + 1) % 3, (flat + 2) % 3
    number = np.arange(len(rows))
    corners = np.repeat(near[:, None], 4, axis=1)
    corners[number, 1, first] = corners[number, 2, first] = far[number, first]
    corners[number, 2, second] = corners[number, 3, second] = far[number, second]
    return scene.position[rows][:, None] + np.einsum("nij,nkj->nki", frame, corners)


def _scene_of(polygons: Outlines, scene: Scene) -> Scene:
    """A scene of polygons, in place of the instances of a scene."""
    polygons = polygons.take(np.argsort(polygons.model, kind="stable"))
    color = np.rint(srgb_from_linear(polygons.color) * _COLOR_STEPS) / _COLOR_STEPS
    meshes = Meshes.from_polygons(polygons.points, np.diff(polygons.offsets))
    return replace(polygon_scene(meshes, polygons.model, color, scene.num_models), origins=scene.origins)
