"""Vertices and normals of all instances of a scene.

Meshes that many instances use (boxes, rectangles, cylinders) are placed by one matrix product each: an instance is a
row of 12 numbers, its mesh a matrix from these to all its coordinates. The others share one ragged gather.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Ints, row_of_value, take_rows
from grammarlab.scene.instances import Scene
from grammarlab.scene.shading import ShadedMeshes

MANY_INSTANCES = 64
"""From here on a mesh earns a matrix product of its own."""
MOST_TEMPLATES = 32
"""At most so many meshes do: each one costs a pass over the instances."""
LARGEST_TEMPLATE = 256
"""Vertices; the matrix of a mesh grows with them, and a long gather is as fast."""
BLOCK_VALUES = 200_000
"""Numbers computed at a time, so that they stay in the cache until they are stored."""
SHORTEST = 1e-18
"""Shorter normals have no direction; the square of this length is still an exact 32-bit number."""


@dataclass(frozen=True, slots=True)
class Placed:
    """Vertices and triangles of instances, one instance after the other."""

    vertices: NDArray[np.float32]
    """[V, 3] metres."""
    normals: NDArray[np.float32]
    """[V, 3] unit vectors."""
    triangles: NDArray[np.uint32]
    """[T, 3] rows of `vertices`."""


def place(
    scene: Scene,
    shaded: ShadedMeshes,
    mesh: Ints,
    order: Ints,
    vertex_offsets: Ints,
    triangle_offsets: Ints,
) -> Placed:
    """Place every instance of a scene.

    Args:
        scene: the instances.
        shaded: the unique meshes.
        mesh: [I] the mesh of each instance, index into `shaded`.
        order: [I] the instances in the order of the result.
        vertex_offsets: [I + 1] where the vertices of each instance go, in that order.
        triangle_offsets: [I + 1] likewise for triangles.
    """
    placed = Placed(
        np.empty((vertex_offsets[-1], 3), np.float32),
        np.empty((vertex_offsets[-1], 3), np.float32),
        np.empty((triangle_offsets[-1], 3), np.uint32),
    )
    mesh_in_order = mesh[order]
    templates = _templates(shaded, mesh)
    kind = np.full(len(shaded.mesh_vertices) - 1, -1, np.int8)
    kind[templates] = np.arange(len(templates))
    kind_in_order = kind[mesh_in_order]
    # Products of so few columns are ten times slower when BLAS spreads them over two threads.
    with threadpool_limits(limits=1, user_api="blas"):
        for index, template in enumerate(templates):
            rows = np.flatnonzero(kind_in_order == index)
            _place_template(placed, scene, shaded, int(template), order, rows, vertex_offsets, triangle_offsets)
    rest = np.flatnonzero(kind_in_order == -1)
    if len(rest):
        _place_rest(placed, scene, shaded, mesh_in_order, order, rest, vertex_offsets, triangle_offsets)
    return placed


def _templates(shaded: ShadedMeshes, mesh: Ints) -> Ints:
    """Meshes used often enough, the most used first."""
    uses = np.bincount(mesh, minlength=len(shaded.mesh_vertices) - 1)
    uses[np.diff(shaded.mesh_vertices) > LARGEST_TEMPLATE] = 0
    most = np.argsort(-uses, kind="stable")[:MOST_TEMPLATES]
    return most[uses[most] >= MANY_INSTANCES]


def _place_template(
    placed: Placed,
    scene: Scene,
    shaded: ShadedMeshes,
    template: int,
    order: Ints,
    rows: Ints,
    vertex_offsets: Ints,
    triangle_offsets: Ints,
) -> None:
    """Place the instances at `rows` of the order, which all use mesh `template`."""
    vertices = slice(*shaded.mesh_vertices[template : template + 2])
    corners = shaded.triangles[slice(*shaded.mesh_triangles[template : template + 2])].astype(np.uint32).ravel()
    to_points = _coordinates_matrix(shaded.points[vertices], with_position=True)
    to_normals = _coordinates_matrix(shaded.normals[vertices], with_position=False)
    width = to_points.shape[1]
    if width == 0 or len(corners) == 0:
        return
    # Row i of a window view is the stretch of memory that starts at number i: storing to it is one block copy.
    vertex_windows = sliding_window_view(placed.vertices.reshape(-1), width, writeable=True)
    normal_windows = sliding_window_view(placed.normals.reshape(-1), width, writeable=True)
    triangle_windows = sliding_window_view(placed.triangles.reshape(-1), len(corners), writeable=True)
    aligned = bool(shaded.axis_aligned[template])
    step = max(1, BLOCK_VALUES // width)
    for start in range(0, len(rows), step):
        block = rows[start : start + step]
        instance = order[block]
        rotation = scene.rotation[instance].astype(np.float32)
        size = scene.size[instance].astype(np.float32)
        axes = (rotation * size[:, None, :]).reshape(-1, 9)
        place_and_axes = np.concatenate([axes, scene.position[instance].astype(np.float32)], axis=1)
        first = vertex_offsets[block]
        vertex_windows[3 * first] = place_and_axes @ to_points
        if aligned:
            normal_windows[3 * first] = rotation.reshape(-1, 9) @ to_normals
        else:
            turned = (rotation * cofactors(size)[:, None, :]).reshape(-1, 9) @ to_normals
            normal_windows[3 * first] = unit_or(turned.reshape(-1, 3), rotation[:, :, 1], width // 3).reshape(-1, width)
        triangle_windows[3 * triangle_offsets[block]] = corners + first.astype(np.uint32)[:, None]


def _coordinates_matrix(vectors: NDArray[np.float64], with_position: bool) -> NDArray[np.float32]:
    """[9 or 12, 3 V] from an instance's axes (row by row), and its position, to the coordinates of all vectors."""
    blocks = np.einsum("ik,vj->ijvk", np.eye(3), vectors).reshape(9, -1)
    if with_position:
        blocks = np.concatenate([blocks, np.tile(np.eye(3), len(vectors))])
    return blocks.astype(np.float32)


def _place_rest(
    placed: Placed,
    scene: Scene,
    shaded: ShadedMeshes,
    mesh_in_order: Ints,
    order: Ints,
    rest: Ints,
    vertex_offsets: Ints,
    triangle_offsets: Ints,
) -> None:
    """Place the instances at `rest` of the order, whatever their meshes."""
    mesh, instance = mesh_in_order[rest], order[rest]
    source, _ = take_rows(shaded.mesh_vertices, mesh)
    target, _ = take_rows(vertex_offsets, rest)
    row = row_of_value(np.diff(shaded.mesh_vertices)[mesh])
    rotation, size = scene.rotation[instance], scene.size[instance]
    offset = np.einsum("nij,nj->ni", rotation[row], size[row] * shaded.points[source])
    placed.vertices[target] = scene.position[instance][row] + offset

    scaled = np.where(shaded.axis_aligned[mesh][:, None], 1.0, cofactors(size))[row] * shaded.normals[source]
    turned = np.einsum("nij,nj->ni", rotation[row], scaled)
    placed.normals[target] = unit_or(turned, rotation[row][:, :, 1], 1)

    source, _ = take_rows(shaded.mesh_triangles, mesh)
    target, _ = take_rows(triangle_offsets, rest)
    first = vertex_offsets[rest][row_of_value(np.diff(shaded.mesh_triangles)[mesh])]
    placed.triangles[target] = shaded.triangles[source] + first[:, None]


def cofactors(size: NDArray[np.floating]) -> NDArray[np.floating]:
    """[N, 3] how a size stretches area vectors, up to a common factor.

    Unlike dividing by the size, it holds for shapes without thickness.
    """
    relative = size / np.maximum(size.max(axis=1, keepdims=True), np.finfo(np.float32).tiny)
    return np.stack(
        [relative[:, 1] * relative[:, 2], relative[:, 2] * relative[:, 0], relative[:, 0] * relative[:, 1]], axis=1
    )


def unit_or(vectors: NDArray[np.floating], otherwise: NDArray[np.floating], repeats: int) -> NDArray[np.floating]:
    """The vectors [N, 3] at length one; rows of `otherwise` [N / repeats, 3] where there is no direction."""
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    lost = length < SHORTEST
    result = vectors / np.where(lost, 1, length)[:, None]
    if lost.any():
        result[lost] = otherwise[np.flatnonzero(lost) // repeats]
    return result
