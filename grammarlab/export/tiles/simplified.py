"""Scenes of fewer triangles, for models seen from afar.

The shapes of a model lie in few planes: walls with their windows and sills, and roofs. Each becomes one polygon, and
the largest ones are kept. Where they do not reach the bounding box of the model, a side of a shape that does is added.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.export.tiles.covered import is_covered
from grammarlab.export.tiles.facets import facets
from grammarlab.export.tiles.outlines import Outlines, outlines, within_budget
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


def simplified(scene: Scene, most_triangles: int) -> Scene:
    """Each model of a scene as its largest walls and roofs, within its bounding box.

    Args:
        scene: B models.
        most_triangles: largest number of triangles of a model, at least 24.

    Returns:
        B models in one instance per wall or roof, each of the mean colour of what it replaces. The same for a model
        alone and in a batch.
    """
    light = linear_from_srgb(scene.materials.color)
    walls = planes(facets(scene))
    walls = walls.take(np.flatnonzero(~is_covered(walls, scene.num_models)))
    polygons = outlines(walls, light)
    reserved = _SIDE_TRIANGLES * 6
    budget = np.full(scene.num_models, most_triangles - reserved)
    polygons = within_budget(polygons, budget, scene.num_models)
    sides = _missing_sides(scene, polygons, light)
    return _scene_of(polygons.joined(sides), scene)


def _missing_sides(scene: Scene, polygons: Outlines, light: Floats) -> Outlines:
    """Rectangles of shapes that reach sides of the bounding boxes of models, where the polygons do not."""
    low, high = instance_bounds(scene)
    num_models = scene.num_models
    starts = np.flatnonzero(np.diff(scene.model, prepend=-1))
    filled = scene.model[starts]
    rectangles, rows = [np.zeros((0, 4, 3))], [np.zeros(0, dtype=np.int64)]
    for axis in range(3):
        extent = np.zeros(num_models)
        if len(starts):
            extent[filled] = np.maximum.reduceat(high[:, axis], starts) - np.minimum.reduceat(low[:, axis], starts)
        for sign, reach in ((-1.0, -low[:, axis]), (1.0, high[:, axis])):
            model, row = _farthest(scene.model.astype(np.int64), reach)
            shown = np.full(num_models, -np.inf)
            corner_model = np.repeat(polygons.model, np.diff(polygons.offsets))
            np.maximum.at(shown, corner_model, sign * polygons.points[:, axis])
            missing = reach[row] - shown[model] > _TOLERANCE * extent[model]
            rows.append(row[missing])
            rectangles.append(_sides(scene, row[missing], axis, sign))
    row = np.concatenate(rows)
    points = np.concatenate(rectangles)
    return Outlines(
        points.reshape(-1, 3),
        4 * np.arange(len(row) + 1),
        scene.model[row].astype(np.int64),
        light[scene.material[row]],
        np.zeros(len(row)),
    )


def _farthest(group: Ints, reach: Floats) -> tuple[Ints, Ints]:
    """The groups, and the first row of the largest number of each."""
    order = np.lexsort((-reach, group))
    first = order[np.flatnonzero(np.diff(group[order], prepend=-1))]
    return group[first], first


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
    order = np.argsort(polygons.model, kind="stable")
    polygons = polygons.take(order)
    color = np.rint(srgb_from_linear(polygons.color) * _COLOR_STEPS) / _COLOR_STEPS
    different, material = np.unique(color, axis=0, return_inverse=True)
    channels = np.tile(list(CHANNELS.values()), (len(different), 1))
    channels[:, :3] = different
    num = len(polygons)
    return replace(
        scene,
        meshes=Meshes.from_polygons(polygons.points, np.diff(polygons.offsets)),
        materials=Materials(channels, ("",) * len(different)),
        model=polygons.model.astype(np.int32),
        mesh=np.arange(num, dtype=np.int32),
        material=material.ravel().astype(np.int32),
        position=np.zeros((num, 3)),
        size=np.ones((num, 3)),
        frame=np.zeros(num, dtype=np.int32),
        frames=np.eye(3)[None],
        texture_map=np.full(num, -1, dtype=np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        surface=None,
    )
