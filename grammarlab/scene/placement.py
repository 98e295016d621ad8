"""Vertices and normals of all instances of a scene.

Meshes that many instances use (boxes, rectangles, cylinders) are placed by one matrix product each: an instance is a
row of 12 numbers, its mesh a matrix from these to all its coordinates. The others share one ragged gather.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Ints, row_of_value, take_rows
from grammarlab.scene.instances import Scene
from grammarlab.scene.shading import ShadedMeshes

MANY_INSTANCES = 64
"""From here on a mesh earns a matrix product of its own."""
MOST_TEMPLATES = 32
"""At most so many meshes do: each one costs a few calls."""
LARGEST_TEMPLATE = 256
"""Vertices; the matrix of a mesh grows with them, and a long gather is as fast."""
BLOCK_VALUES = 60_000
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
    vertex_offsets: Ints,
    triangle_offsets: Ints,
) -> Placed:
    """Place every instance of a scene.

    Args:
        scene: the instances, in the order of the result.
        shaded: the unique meshes.
        mesh: [I] the mesh of each instance, index into `shaded`.
        vertex_offsets: [I + 1] where the vertices of each instance go.
        triangle_offsets: [I + 1] likewise for triangles.
    """
    placed = Placed(
        np.empty((vertex_offsets[-1], 3), np.float32),
        np.empty((vertex_offsets[-1], 3), np.float32),
        np.empty((triangle_offsets[-1], 3), np.uint32),
    )
    most_used = _most_used(shaded, mesh)
    templates = [_template(shaded, index, placed) for index in most_used.tolist()]
    kind = np.full(len(shaded.mesh_vertices) - 1, len(templates), np.int8)
    kind[most_used] = np.arange(len(templates))
    kind_of_instance = kind[mesh]
    by_kind = np.argsort(kind_of_instance, kind="stable")
    ends = np.searchsorted(kind_of_instance, np.arange(len(templates) + 1), sorter=by_kind).tolist()
    columns = _columns(scene, by_kind[: ends[-1]], vertex_offsets, triangle_offsets)
    # Products of so few columns are ten times slower when BLAS spreads them over two threads.
    with threadpool_limits(limits=1, user_api="blas"):
        for template, (first, end) in zip(templates, pairwise(ends), strict=True):
            _place_template(template, columns, first, end)
    rest = by_kind[ends[-1] :]
    if len(rest):
        _place_rest(placed, scene, shaded, mesh, rest, vertex_offsets, triangle_offsets)
    return placed


def _most_used(shaded: ShadedMeshes, mesh: Ints) -> Ints:
    """Meshes used often enough for a template, the most used first."""
    uses = np.bincount(mesh, minlength=len(shaded.mesh_vertices) - 1)
    uses[np.diff(shaded.mesh_vertices) > LARGEST_TEMPLATE] = 0
    most = np.argsort(-uses, kind="stable")[:MOST_TEMPLATES]
    return most[uses[most] >= MANY_INSTANCES]


class _Template(NamedTuple):
    """A mesh of V vertices and T triangles, and the places it may go to."""

    to_points: NDArray[np.float32]
    """[12, 3 V] from an instance's axes and position to the coordinates of its vertices."""
    to_normals: NDArray[np.float32]
    """[9, 3 V] from an instance's axes to its normals."""
    to_squares: NDArray[np.float32]
    """[3, 3 V] from the squares of what stretches each axis to the squared length of its normals, once a coordinate."""
    corners: NDArray[np.uint32]
    """[3 T] vertices, counted from the first of the mesh."""
    axis_aligned: bool
    vertices: NDArray[np.void]
    """[R] row i is the memory of V vertices from vertex i of the result: storing to it is one block copy."""
    normals: NDArray[np.void]
    """[R] likewise for normals."""
    triangles: NDArray[np.void]
    """[S] likewise for triangles."""


def _template(shaded: ShadedMeshes, mesh: int, placed: Placed) -> _Template:
    vertices = slice(*shaded.mesh_vertices[mesh : mesh + 2])
    corners = shaded.triangles[slice(*shaded.mesh_triangles[mesh : mesh + 2])]
    num_vertices = len(shaded.points[vertices])
    return _Template(
        _coordinates_matrix(shaded.points[vertices], with_position=True),
        _coordinates_matrix(shaded.normals[vertices], with_position=False),
        np.repeat(shaded.normals[vertices].T ** 2, 3, axis=1).astype(np.float32),
        corners.astype(np.uint32).ravel(),
        bool(shaded.axis_aligned[mesh]),
        _windows(placed.vertices, num_vertices),
        _windows(placed.normals, num_vertices),
        _windows(placed.triangles, len(corners)),
    )


def _windows(rows: NDArray[Any], width: int) -> NDArray[np.void]:
    """Every `width` consecutive rows of an array [N, 3] of 32-bit numbers as one item, sharing its memory."""
    return np.ndarray(max(len(rows) - width + 1, 0), f"V{12 * width}", buffer=rows, strides=(12,))


def _items(block: NDArray[Any]) -> NDArray[np.void]:
    """[N] each row of a block [N, K] of 32-bit numbers as one item."""
    return block.view(f"V{4 * block.shape[1]}")[:, 0]


class _Columns(NamedTuple):
    """N instances, those of one mesh after those of another."""

    axes_and_position: NDArray[np.float32]
    """[N, 12] the axes as long as the size, row by row of the matrix, then the position."""
    rotation: NDArray[np.float32]
    """[N, 3, 3] proper rotations."""
    size: NDArray[np.float32]
    """[N, 3] metres."""
    vertex: Ints
    """[N] where the vertices of each go."""
    triangle: Ints
    """[N] where its triangles go."""


def _columns(scene: Scene, rows: Ints, vertex_offsets: Ints, triangle_offsets: Ints) -> _Columns:
    rotation = scene.frames.astype(np.float32).take(scene.frame.take(rows), axis=0)
    size = scene.size.take(rows, axis=0).astype(np.float32)
    columns = np.empty((len(size), 12), np.float32)
    # Three times the size beside each other, since products of rows of nine are far faster than those of rows of three.
    thrice = _items(size).repeat(3).view(np.float32).reshape(-1, 9)
    np.multiply(rotation.reshape(-1, 9), thrice, out=columns[:, :9])
    columns[:, 9:] = scene.position.take(rows, axis=0)
    return _Columns(columns, rotation, size, vertex_offsets.take(rows), triangle_offsets.take(rows))


def _place_template(template: _Template, columns: _Columns, first: int, end: int) -> None:
    """Place the instances from `first` to `end` of the columns, which all use the mesh of `template`."""
    width = template.to_points.shape[1]
    if width == 0 or len(template.corners) == 0:
        return
    step = max(1, BLOCK_VALUES // width)
    for start in range(first, end, step):
        block = slice(start, min(start + step, end))
        rotation, vertex = columns.rotation[block], columns.vertex[block]
        template.vertices[vertex] = _items(columns.axes_and_position[block] @ template.to_points)
        if template.axis_aligned:
            normals = rotation.reshape(-1, 9) @ template.to_normals
        else:
            normals = _stretched_normals(template, rotation, cofactors(columns.size[block]))
        template.normals[vertex] = _items(normals)
        template.triangles[columns.triangle[block]] = _items(template.corners + vertex.astype(np.uint32)[:, None])


def _stretched_normals(
    template: _Template, rotation: NDArray[np.float32], stretch: NDArray[np.floating]
) -> NDArray[np.floating]:
    """[N, 3 V] normals of a mesh under rotations [N, 3, 3] and factors [N, 3] along its axes."""
    normals = (rotation * stretch[:, None, :]).reshape(-1, 9) @ template.to_normals
    length = np.sqrt(stretch * stretch @ template.to_squares)
    lost = length < SHORTEST
    if lost.any():
        length[lost] = 1.0
        up = np.broadcast_to(rotation[:, None, :, 1], (len(normals), normals.shape[1] // 3, 3))
        normals[lost] = up.reshape(normals.shape)[lost]
    normals /= length
    return normals


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
    mesh_of_instance: Ints,
    rest: Ints,
    vertex_offsets: Ints,
    triangle_offsets: Ints,
) -> None:
    """Place the instances at `rest`, whatever their meshes."""
    mesh = mesh_of_instance[rest]
    source, _ = take_rows(shaded.mesh_vertices, mesh)
    target, _ = take_rows(vertex_offsets, rest)
    row = row_of_value(np.diff(shaded.mesh_vertices)[mesh])
    rotation, size = scene.frames[scene.frame[rest]], scene.size[rest]
    offset = np.einsum("nij,nj->ni", rotation[row], size[row] * shaded.points[source])
    placed.vertices[target] = scene.position[rest][row] + offset

    scaled = np.where(shaded.axis_aligned[mesh][:, None], 1.0, cofactors(size))[row] * shaded.normals[source]
    turned = np.einsum("nij,nj->ni", rotation[row], scaled)
    placed.normals[target] = _unit_or(turned, rotation[row][:, :, 1])

    source, _ = take_rows(shaded.mesh_triangles, mesh)
    target, _ = take_rows(triangle_offsets, rest)
    first = vertex_offsets[rest][row_of_value(np.diff(shaded.mesh_triangles)[mesh])]
    placed.triangles[target] = shaded.triangles[source] + first[:, None]


def cofactors(size: NDArray[np.floating]) -> NDArray[np.floating]:
    """[N, 3] how a size stretches area vectors, up to a common factor.

    Unlike dividing by the size, it holds for shapes without thickness.
    """
    x, y, z = size.T
    largest = np.maximum(np.maximum(x, y), np.maximum(z, np.finfo(np.float32).tiny))
    x, y, z = x / largest, y / largest, z / largest
    return np.stack((y * z, z * x, x * y), axis=1)


def _unit_or(vectors: NDArray[np.float64], otherwise: NDArray[np.float64]) -> NDArray[np.float64]:
    """The vectors [N, 3] at length one; rows of `otherwise` [N, 3] where there is no direction."""
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    lost = length < SHORTEST
    return np.where(lost[:, None], otherwise, vectors / np.where(lost, 1, length)[:, None])
