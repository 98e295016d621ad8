"""Triangles of a scene with their texture coordinates, for files and pictures, for a whole batch at once.

Texture coordinates come from maps, or are projected along the world's axes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, offsets_from_counts, row_of_value, take_rows
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.materials import Materials
from grammarlab.geometry.meshes.triangulate import triangulate
from grammarlab.scene.instances import Scene, chosen, leaf_order, realize, require_finite, stable_order
from grammarlab.scene.placement import place_instances, repeated_values
from grammarlab.scene.shading import shaded_meshes

CREASE_ANGLE = math.radians(30.0)
"""Largest angle between faces that are shaded as one curved surface: a cylinder of more than 12 sides is smooth."""
LARGEST_COORDINATE = 1e9
"""Largest texture coordinate; larger ones are clipped so that they fit 32 bits, since no image is visible there."""
MANY_REPEATS = 1024.0
"""Largest number of repeats of an image; beyond it, whole repeats are removed to keep the fraction in 32 bits."""


@dataclass(frozen=True, slots=True)
class TriangleBatch:
    """The merged triangles of `num_models` models, world y up, metres from the origin of each model.

    Rows are ordered by model, then by material, then by symbol; a group is one symbol in one material within one model.
    So one model, or one material of one model, is a slice of every array. Each side of a leaf is modelled once: files
    mark every material as double-sided and pictures turn normals towards the viewer, so a free-standing rectangle is
    seen from behind.
    """

    num_models: int
    materials: Materials
    vertices: NDArray[np.float32]
    """[V, 3] positions in metres from the origin of the model."""
    normals: NDArray[np.float32]
    """[V, 3] unit vectors."""
    triangles: NDArray[np.uint32]
    """[T, 3] rows of `vertices`, counter-clockwise seen from outside."""
    group_model: NDArray[np.int32]
    """[G] ascending."""
    group_material: NDArray[np.int32]
    """[G] index into `materials`, ascending within a model."""
    group_vertices: Ints
    """[G + 1] into `vertices`."""
    group_triangles: Ints
    """[G + 1] into `triangles`."""
    model_groups: Ints
    """[num_models + 1] into groups."""
    texture_map: NDArray[np.int32]
    """[T] index into `texture_maps`, -1 for triangles without texture coordinates."""
    texture_maps: NDArray[np.float64]
    """[K, 2, 4] u and v of a vertex are rows times (x, y, z, 1), v upwards."""
    origins: NDArray[np.float64]
    """[num_models, 3] origin of each model's vertices, in world metres."""
    coordinates: NDArray[np.float32] | None = None
    """[V, 2] u and v of the vertices, v upwards, in place of texture maps; None if they follow from these."""
    corner_coordinates: NDArray[np.float32] | None = None
    """[V, 2] u and v that files of meshes gave the vertices, v upwards, NaN for none; triangles without texture maps
    have them. None if no file gave any."""
    group_symbol: NDArray[np.int32] | None = None
    """[G] index into the symbols of the scene; None if it has no labels: a group is then one material."""

    def model(self, index: int) -> TriangleBatch:
        """Model `index` alone, as a batch of one (arrays are views where they can be)."""
        if not 0 <= index < self.num_models:
            raise IndexError(f"model {index} of a batch of {self.num_models}")
        first, last = (int(g) for g in self.model_groups[index : index + 2])
        vertices = slice(*self.group_vertices[[first, last]])
        triangles = slice(*self.group_triangles[[first, last]])
        return TriangleBatch(
            num_models=1,
            materials=self.materials,
            vertices=self.vertices[vertices],
            normals=self.normals[vertices],
            triangles=self.triangles[triangles] - np.uint32(vertices.start),
            group_model=np.zeros(last - first, np.int32),
            group_material=self.group_material[first:last],
            group_vertices=self.group_vertices[first : last + 1] - vertices.start,
            group_triangles=self.group_triangles[first : last + 1] - triangles.start,
            model_groups=np.array([0, last - first], dtype=np.int64),
            texture_map=self.texture_map[triangles],
            texture_maps=self.texture_maps,
            origins=self.origins[index : index + 1],
            coordinates=None if self.coordinates is None else self.coordinates[vertices],
            corner_coordinates=None if self.corner_coordinates is None else self.corner_coordinates[vertices],
            group_symbol=None if self.group_symbol is None else self.group_symbol[first:last],
        )

    def of_groups(self, groups: Ints) -> TriangleBatch:
        """Triangles of selected groups [K], ascending, as a batch with the same number of models."""
        vertex, group_vertices = take_rows(self.group_vertices, groups)
        triangle, group_triangles = take_rows(self.group_triangles, groups)
        moved = np.repeat(group_vertices[:-1] - self.group_vertices[groups], np.diff(group_triangles))
        return TriangleBatch(
            num_models=self.num_models,
            materials=self.materials,
            vertices=self.vertices[vertex],
            normals=self.normals[vertex],
            triangles=(self.triangles[triangle] + moved[:, None]).astype(np.uint32),
            group_model=self.group_model[groups],
            group_material=self.group_material[groups],
            group_vertices=group_vertices,
            group_triangles=group_triangles,
            model_groups=np.searchsorted(self.group_model[groups], np.arange(self.num_models + 1)),
            texture_map=self.texture_map[triangle],
            texture_maps=self.texture_maps,
            origins=self.origins,
            coordinates=None if self.coordinates is None else self.coordinates[vertex],
            corner_coordinates=None if self.corner_coordinates is None else self.corner_coordinates[vertex],
            group_symbol=None if self.group_symbol is None else self.group_symbol[groups],
        )

    def by_material(self) -> TriangleBatch:
        """The same triangles in groups of one material each, whatever their symbols."""
        if self.group_symbol is None:
            return self
        model, material = self.group_model, self.group_material
        is_first = np.ones(len(model), dtype=bool)
        is_first[1:] = (model[1:] != model[:-1]) | (material[1:] != material[:-1])
        starts = np.flatnonzero(is_first)
        ends = np.append(starts, len(model))
        return replace(
            self,
            group_model=model[starts],
            group_material=material[starts],
            group_vertices=self.group_vertices[ends],
            group_triangles=self.group_triangles[ends],
            model_groups=np.searchsorted(model[starts], np.arange(self.num_models + 1)),
            group_symbol=None,
        )

    def material_of_triangle(self) -> NDArray[np.int32]:
        """[T] index into `materials`."""
        return self.group_material[row_of_value(np.diff(self.group_triangles))]

    def triangles_per_model(self) -> Ints:
        """[num_models] triangles of each model."""
        return np.diff(self.group_triangles[self.model_groups])


def triangles(scene: Scene, crease_angle: float = CREASE_ANGLE) -> TriangleBatch:
    """The merged triangles of a scene.

    Normals are computed once for each unique mesh and corrected for the size of each instance. An instance of size 0
    in some direction keeps its triangles, and its normals stay unit vectors.

    Args:
        scene: a scene of at most 2**32 vertices.
        crease_angle: radians; edges within one mesh that turn by less are smooth. Measured in the unit cube.

    Raises:
        DerivationError: If a coordinate is not finite, or beyond a million kilometres.
    """
    require_finite(scene)
    used = np.bincount(scene.mesh, minlength=len(scene.meshes)) > 0
    shaded = shaded_meshes(scene, np.flatnonzero(used), crease_angle)
    place_of_mesh = np.cumsum(used) - 1
    scene = in_groups(scene, (np.diff(shaded.mesh_triangles) > 0)[place_of_mesh[scene.mesh]])
    mesh = place_of_mesh[scene.mesh]
    is_first = np.empty(len(scene), dtype=bool)
    is_first[:1] = True
    is_first[1:] = (scene.model[1:] != scene.model[:-1]) | (scene.material[1:] != scene.material[:-1])
    if scene.labels is not None:
        is_first[1:] |= scene.labels.symbol[1:] != scene.labels.symbol[:-1]
    starts = np.flatnonzero(is_first)
    vertex_offsets = offsets_from_counts(np.diff(shaded.mesh_vertices)[mesh])
    triangle_offsets = offsets_from_counts(np.diff(shaded.mesh_triangles)[mesh])
    placed = place_instances(scene, shaded, mesh, vertex_offsets, triangle_offsets)

    def of_vertices(values: Floats | None) -> NDArray[np.float32] | None:
        return None if values is None else repeated_values(values, shaded, mesh, vertex_offsets)

    ends = np.append(starts, len(scene))
    group_model = scene.model[starts]
    return TriangleBatch(
        num_models=scene.num_models,
        materials=scene.materials,
        vertices=placed.vertices,
        normals=placed.normals,
        triangles=placed.triangles,
        group_model=group_model,
        group_material=scene.material[starts],
        group_vertices=vertex_offsets[ends],
        group_triangles=triangle_offsets[ends],
        model_groups=np.searchsorted(group_model, np.arange(scene.num_models + 1)),
        texture_map=_texture_map(scene, triangle_offsets),
        texture_maps=scene.texture_maps,
        origins=scene.origins,
        coordinates=of_vertices(shaded.coordinates),
        corner_coordinates=of_vertices(shaded.corner_coordinates),
        group_symbol=None if scene.labels is None else scene.labels.symbol[starts],
    )


def count_triangles(scene: Scene) -> Ints:
    """[num_models] number of triangles of each model, without placing them."""
    used, mesh = np.unique(scene.mesh, return_inverse=True)
    meshes = scene.meshes.take(used)
    _, face = triangulate(meshes)
    per_mesh = np.bincount(meshes.mesh_of_face()[face], minlength=len(meshes))
    return np.bincount(scene.model, weights=per_mesh[mesh], minlength=scene.num_models).astype(np.int64)


def leaf_of_triangle(forest: Forest) -> Ints:
    """[T] leaf of each triangle of ``triangles(realize(forest))``, a row of `Forest.leaves`."""
    scene = realize(forest)
    alone = replace(scene, num_models=len(scene), model=np.arange(len(scene), dtype=np.int32))
    return leaf_order(forest).repeat(count_triangles(alone))


def texture_coordinates(batch: TriangleBatch, triangles: slice) -> NDArray[np.float32]:
    """U and v of the corners of selected triangles [T] of a batch: from maps, from files of meshes, or in metres.

    Returns:
        [T, 3, 2] with v downwards, as in glTF; up to `MANY_REPEATS` whole repeats are kept.
    """
    if batch.coordinates is not None:
        return downwards(batch.coordinates)[batch.triangles[triangles]]
    corners, chosen = batch.vertices[batch.triangles[triangles]], batch.texture_map[triangles]
    coordinates = _planar_coordinates(corners).astype(np.float64)
    if batch.corner_coordinates is not None:
        of_file = batch.corner_coordinates[batch.triangles[triangles]].astype(np.float64)
        own = np.flatnonzero((chosen < 0) & np.isfinite(of_file).all(axis=(1, 2)))
        coordinates[own] = of_file[own] * (1.0, -1.0) + (0.0, 1.0)
    mapped = np.flatnonzero(chosen >= 0)
    if len(mapped):
        rows = batch.texture_maps[chosen[mapped]]
        values = np.einsum("tij,tcj->tci", rows[:, :, :3], corners[mapped]) + rows[:, None, :, 3]
        coordinates[mapped] = np.clip(np.nan_to_num(values), -LARGEST_COORDINATE, LARGEST_COORDINATE) * (1.0, -1.0)
    first = coordinates.min(axis=1, keepdims=True)
    return (coordinates - np.where(np.abs(first) > MANY_REPEATS, np.floor(first), 0.0)).astype(np.float32)


def downwards(coordinates: NDArray[np.floating]) -> NDArray[np.float32]:
    """Texture coordinates [V, 2] with v downwards from the top of the picture, as in glTF."""
    return (coordinates * (1.0, -1.0) + (0.0, 1.0)).astype(np.float32)


def in_groups(scene: Scene, has_triangles: NDArray[np.bool_]) -> Scene:
    """The instances with triangles, ordered by model, then by material, then by symbol if they have labels."""
    model, material = scene.model, scene.material.astype(np.int64)
    if scene.labels is not None:
        material = material * len(scene.labels.symbols) + scene.labels.symbol
    ordered = (model[1:] > model[:-1]) | ((model[1:] == model[:-1]) & (material[1:] >= material[:-1]))
    if ordered.all():
        return scene if has_triangles.all() else chosen(scene, has_triangles)
    order = stable_order(model, material)
    return chosen(scene, order[has_triangles[order]])


def _texture_map(scene: Scene, triangle_offsets: Ints) -> NDArray[np.int32]:
    """[T] the map of each triangle; without maps a single number broadcast to T."""
    if len(scene.texture_maps) == 0:
        return np.broadcast_to(np.int32(-1), triangle_offsets[-1:])
    return scene.texture_map.repeat(np.diff(triangle_offsets))


def _planar_coordinates(corners: NDArray[np.floating]) -> NDArray[np.float32]:
    """Texture coordinates in metres, projected along the axis that each triangle faces most.

    Read from outside, u runs to the right and v down a wall, so that no image is mirrored or upside down.

    Args:
        corners: [T, 3, 3] the corners of each triangle.

    Returns:
        [T, 3, 2] with v downwards, as in glTF.
    """
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(axis=1)
    outward = np.where(np.take_along_axis(normal, axis[:, None], axis=1) < 0, -1.0, 1.0)
    x, y, z = corners[..., 0], corners[..., 1], corners[..., 2]
    along_x, along_y = (axis == 0)[:, None], (axis == 1)[:, None]
    u = np.where(along_x, -outward * z, np.where(along_y, x, outward * x))
    v = np.where(along_y, outward * z, -y)
    return np.stack([u, v], axis=-1).astype(np.float32)
