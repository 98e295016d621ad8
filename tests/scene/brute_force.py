"""Triangles of a scene worked out slowly, one instance and one face at a time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from grammarlab.scene import Scene


def face_area_vectors(scene: Scene, instance: int) -> np.ndarray:
    """[F, 3] the outward normal of each face of an instance in the world, as long as its area (Newell's formula)."""
    meshes, mesh = scene.meshes, int(scene.mesh[instance])
    points = meshes.points[slice(*meshes.mesh_points[mesh : mesh + 2])]
    world = scene.position[instance] + (scene.size[instance] * points) @ scene.frames[scene.frame[instance]].T
    vectors = []
    for face in range(*meshes.mesh_faces[mesh : mesh + 2].tolist()):
        corners = world[meshes.corners[slice(*meshes.face_offsets[face : face + 2])]]
        vectors.append(sum(np.cross(a, b) for a, b in pairwise([*corners, corners[0]])) / 2)
    return np.array(vectors).reshape(-1, 3)


def areas(scene: Scene) -> dict[tuple[int, int], float]:
    """Square metres of each material of each model."""
    sums: dict[tuple[int, int], float] = {}
    for instance in range(len(scene)):
        key = int(scene.model[instance]), int(scene.material[instance])
        sums[key] = sums.get(key, 0.0) + float(np.linalg.norm(face_area_vectors(scene, instance), axis=1).sum())
    return sums


def bounds(scene: Scene, model: int) -> np.ndarray:
    """[2, 3] smallest and largest coordinates of a model."""
    world = []
    for instance in np.flatnonzero(scene.model == model):
        points = scene.meshes.points[slice(*scene.meshes.mesh_points[scene.mesh[instance] : scene.mesh[instance] + 2])]
        world.append(scene.position[instance] + (scene.size[instance] * points) @ scene.frames[scene.frame[instance]].T)
    stacked = np.concatenate(world)
    return np.array([stacked.min(axis=0), stacked.max(axis=0)])
