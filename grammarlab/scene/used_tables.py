"""Scenes whose tables have only what their instances use: part of a large batch costs what it needs alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grammarlab.arrays import Ints, take_rows
from grammarlab.derivation.materials import Materials
from grammarlab.scene.instances import PointSurface, Scene


def with_used_tables(scene: Scene) -> Scene:
    """The same instances, with tables of the meshes, materials, rotations and texture maps that they use, in order."""
    meshes, mesh = np.unique(scene.mesh, return_inverse=True)
    materials, material = np.unique(scene.material, return_inverse=True)
    frames, frame = np.unique(scene.frame, return_inverse=True)
    mapped = scene.texture_map >= 0
    maps, used = np.unique(scene.texture_map[mapped], return_inverse=True)
    texture_map = np.full(len(scene), -1, dtype=np.int32)
    texture_map[mapped] = used
    surface = scene.surface
    if surface is not None:
        points, _ = take_rows(scene.meshes.mesh_points, meshes)
        surface = PointSurface(surface.normals[points], surface.coordinates[points])
    return replace(
        scene,
        meshes=scene.meshes.take(meshes),
        materials=_taken(scene.materials, materials.astype(np.int64)),
        mesh=mesh.astype(np.int32),
        material=material.astype(np.int32),
        frame=frame.astype(np.int32),
        frames=scene.frames[frames],
        texture_map=texture_map,
        texture_maps=scene.texture_maps[maps],
        surface=surface,
    )


def _taken(table: Materials, rows: Ints) -> Materials:
    """The materials at these rows, ascending."""
    thin = frozenset(number for number, row in enumerate(rows.tolist()) if row in table.thin)
    textures = tuple(table.textures[row] for row in rows.tolist())
    pictures = {name: content for name, content in table.pictures.items() if name in textures}
    return Materials(table.channels[rows], textures, pictures, table.cut_out.intersection(textures), thin)
