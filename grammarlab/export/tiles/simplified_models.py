"""Scenes of fewer triangles, for models seen from afar.

The shapes of a model lie in few planes: walls with their windows and sills, and roofs. Each becomes one polygon, and
the largest ones are kept. If these are not nearly all, the model becomes a stack of slabs. Where they do not reach the
bounding box of the model, a side of a shape that does is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.assets.srgb import linear_from_srgb, srgb_from_linear
from grammarlab.export.tiles.covered import is_covered
from grammarlab.export.tiles.facets import facets
from grammarlab.export.tiles.plane_outlines import Outlines, outlines, significant, within_budget
from grammarlab.export.tiles.planes import planes
from grammarlab.export.tiles.polygon_scene import polygon_scene
from grammarlab.export.tiles.slabs import slabs
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.instance_bounds import instance_bounds
from grammarlab.scene.instances import Scene

PLAIN_TRIANGLES = 300
"""Most triangles of a model of level ``plain``."""
BLOCK_TRIANGLES = 30
"""Most triangles of a model of level ``block``."""
_TOLERANCE = 0.01
"""Largest distance from a side of the bounding box, as a share of its length."""
_SIDE_TRIANGLES, _MAX_SIDES = 2, 5
"""Triangles of a side that reaches the bounding box, and the largest number of these: those that are farthest off."""
_MIN_COVERED = 0.95
"""Smallest share of the area of walls and roofs that a model of polygons has."""
_FEW_TRIANGLES = 100
"""Budget below which slabs have four corners instead of eight."""
_BOX_SIDES = tuple((axis, sign) for axis in range(3) for sign in (-1.0, 1.0))
"""Axes and directions of the sides of a box."""
_SHORTEST = 5.0
"""Smallest side of a box in metres that distances are compared with: 5 cm do not matter."""
_COLOR_STEPS = 63.0
"""Steps of sRGB, so that models share materials."""


def simplified(
    scene: Scene, budgets: Sequence[int] = (PLAIN_TRIANGLES, BLOCK_TRIANGLES), light: Floats | None = None
) -> tuple[Scene, ...]:
    """Each model of a scene as its largest walls and roofs, within its bounding box.

    Args:
        scene: B models.
        budgets: for each result, the largest number of triangles of a model, at least 24.
        light: [K, 3] linear colours of the materials (`TextureColors.light`); by default without their textures.

    Returns:
        Scenes of B models in one instance per wall or roof, each of the mean colour of what it replaces. The same for
        a model alone and in a batch.
    """
    if light is None:
        light = linear_from_srgb(scene.materials.color).astype(np.float64)
    walls = planes(facets(scene))
    walls = walls.take(np.flatnonzero(~is_covered(walls, scene.num_models)))
    bounds = instance_bounds(scene)
    polygons = _clipped(significant(outlines(walls, light), scene.num_models), scene, bounds)
    scenes = []
    for budget in budgets:
        massing = _massing(polygons, budget - _MAX_SIDES * _SIDE_TRIANGLES, scene.num_models)
        sides = _missing_sides(scene, bounds, massing, light)
        scenes.append(_scene_of(massing.joined(sides), scene))
    return tuple(scenes)


def _clipped(polygons: Outlines, scene: Scene, bounds: tuple[Floats, Floats]) -> Outlines:
    """Polygons within the boxes of their models: facets that are moved into one plane may stick out."""
    if not len(polygons):
        return polygons
    starts = np.flatnonzero(np.diff(scene.model, prepend=-1))
    owner = np.searchsorted(scene.model[starts], polygons.model).repeat(np.diff(polygons.offsets))
    low, high = np.minimum.reduceat(bounds[0], starts), np.maximum.reduceat(bounds[1], starts)
    return replace(polygons, points=np.clip(polygons.points, low[owner], high[owner]))


def _massing(polygons: Outlines, most_triangles: int, num_models: int) -> Outlines:
    """The largest polygons of each model, or slabs where these would leave much open."""
    chosen = within_budget(polygons, most_triangles, num_models)
    total, covered = (np.bincount(part.model, part.area, num_models) for part in (polygons, chosen))
    is_open = covered < _MIN_COVERED * total
    directions = 4 if most_triangles < _FEW_TRIANGLES else 8
    num_slabs = max(1, most_triangles // (3 * directions - 2))
    massive = slabs(polygons.take(np.flatnonzero(is_open[polygons.model])), directions, num_slabs)
    return chosen.take(np.flatnonzero(~is_open[chosen.model])).joined(massive)


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
    models = scene.model[starts]
    spans = np.diff(np.append(starts, len(scene)))
    corner_model = np.repeat(polygons.model, np.diff(polygons.offsets))
    missing = np.zeros((6, len(starts)))
    row = np.zeros((6, len(starts)), dtype=np.int64)
    for side, (axis, sign) in enumerate(_BOX_SIDES):
        reach = high[:, axis] if sign > 0.0 else -low[:, axis]
        if not len(starts):
            break
        farthest = np.maximum.reduceat(reach, starts)
        opposite = np.maximum.reduceat(-low[:, axis] if sign > 0.0 else high[:, axis], starts)
        shown = np.full(scene.num_models, -np.inf)
        np.maximum.at(shown, corner_model, sign * polygons.points[:, axis])
        missing[side] = (farthest - shown[models]) / np.maximum(farthest + opposite, _SHORTEST)
        candidates = np.flatnonzero(reach == farthest.repeat(spans))
        row[side] = candidates[np.flatnonzero(np.diff(scene.model[candidates], prepend=-1))]
    rank = np.argsort(np.argsort(-missing, axis=0, kind="stable"), axis=0)
    side, number = np.nonzero((missing > _TOLERANCE) & (rank < _MAX_SIDES))
    rows = row[side, number]
    return Outlines(
        _sides(scene, rows, side).reshape(-1, 3),
        4 * np.arange(len(rows) + 1),
        scene.model[rows].astype(np.int64),
        light[scene.material[rows]],
        np.zeros(len(rows)),
    )


def _sides(scene: Scene, rows: Ints, side: Ints) -> Floats:
    """[n, 4, 3] the largest side of the box of shapes [n] at the corner that is farthest in directions [n]."""
    mesh_low, mesh_high = scene.meshes.bounds()
    mesh, size, frame = scene.mesh[rows], scene.size[rows], scene.frames[scene.frame[rows]]
    low, high = mesh_low[mesh] * size, mesh_high[mesh] * size
    axis, sign = (np.array(column)[side] for column in zip(*_BOX_SIDES, strict=True))
    near = np.where(sign[:, None] * frame[np.arange(len(rows)), axis] < 0.0, low, high)
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
