"""Vertices and normals of all instances of a scene.

Meshes that many instances use (boxes, rectangles, cylinders) are placed column by column, each distinct point once. The
others share one ragged gather. Both add the same products in the same order, and neither hands them to a library that
might not: an instance comes out the same to the last bit alone and in any batch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Ints, row_of_value, take_rows
from grammarlab.scene.instances import Scene
from grammarlab.scene.shading import ShadedMeshes

Floats = NDArray[np.float64]

MANY_INSTANCES = 64
"""From here on a mesh is placed by itself."""
MOST_TEMPLATES = 32
"""At most so many meshes are: each one costs a few calls."""
LARGEST_TEMPLATE = 256
"""Vertices; a mesh costs a few calls for each of them, and a long gather is as fast."""
BLOCK_VALUES = 180_000
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
    for template, (first, end) in zip(templates, pairwise(ends), strict=True):
        step = max(1, BLOCK_VALUES // (3 * len(template.point)))
        for start in range(first, end, step):
            rows = by_kind[start : min(start + step, end)]
            _place_template(template, scene, rows, vertex_offsets.take(rows), triangle_offsets.take(rows))
    rest = by_kind[ends[-1] :]
    if len(rest):
        _place_rest(placed, scene, shaded, mesh, rest, vertex_offsets, triangle_offsets)
    return placed


def _most_used(shaded: ShadedMeshes, mesh: Ints) -> Ints:
    """Meshes used often enough for a template, the most used first."""
    uses = np.bincount(mesh, minlength=len(shaded.mesh_vertices) - 1)
    num_vertices = np.diff(shaded.mesh_vertices)
    uses[(num_vertices > LARGEST_TEMPLATE) | (num_vertices == 0)] = 0
    most = np.argsort(-uses, kind="stable")[:MOST_TEMPLATES]
    return most[uses[most] >= MANY_INSTANCES]


class _Template(NamedTuple):
    """A mesh of V vertices and T triangles, and the places it may go to."""

    points: Floats
    """[P, 3] its distinct points."""
    point: Ints
    """[V] which of them each vertex is."""
    directions: Floats
    """[D, 3] its distinct normals."""
    direction: Ints
    """[V] which of them each vertex has."""
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
    points, point = np.unique(shaded.points[vertices], axis=0, return_inverse=True)
    directions, direction = np.unique(shaded.normals[vertices], axis=0, return_inverse=True)
    return _Template(
        points,
        point.ravel(),
        directions,
        direction.ravel(),
        corners.astype(np.uint32).ravel(),
        bool(shaded.axis_aligned[mesh]),
        _windows(placed.vertices, len(point)),
        _windows(placed.normals, len(point)),
        _windows(placed.triangles, len(corners)),
    )


def _windows(rows: NDArray[Any], width: int) -> NDArray[np.void]:
    """Every `width` consecutive rows of an array [N, 3] of 32-bit numbers as one item, sharing its memory."""
    return np.ndarray(max(len(rows) - width + 1, 0), f"V{12 * width}", buffer=rows, strides=(12,))


def _items(block: NDArray[Any]) -> NDArray[np.void]:
    """[N] each row of a block [N, K] of 32-bit numbers as one item."""
    return block.view(f"V{4 * block.shape[1]}")[:, 0]


def _interleaved(vectors: NDArray[np.float32], chosen: Ints) -> NDArray[np.void]:
    """[N] as one item for each instance, the chosen [V] of its vectors [P, N, 3]."""
    picked = vectors[chosen]
    block = np.empty((vectors.shape[1], len(chosen), 3), np.float32)
    # Coordinate by coordinate, since a copy of rows of three takes twice as long.
    for axis in range(3):
        block[:, :, axis] = picked[:, :, axis].T
    return _items(block.reshape(len(block), -1))


def _place_template(template: _Template, scene: Scene, rows: Ints, vertex: Ints, triangle: Ints) -> None:
    """Place the instances at `rows` [N], which all use the mesh of `template`, at vertices [N] and triangles [N]."""
    if len(template.corners) == 0:
        return
    position, size = scene.position.take(rows, axis=0) + 0.0, scene.size.take(rows, axis=0)
    axes = list(np.moveaxis(scene.frames.take(scene.frame.take(rows), axis=0), 2, 0).copy())
    stretched = [axis * size[:, j, None] for j, axis in enumerate(axes)]
    points = np.empty((len(template.points), len(rows), 3), np.float32)
    for index, point in enumerate(template.points.tolist()):
        points[index] = _combined(position, stretched, point)
    template.vertices[vertex] = _interleaved(points, template.point)

    if not template.axis_aligned:
        axes = [axis * stretch[:, None] for axis, stretch in zip(axes, cofactors(size).T, strict=True)]
    normals = np.empty((len(template.directions), len(rows), 3), np.float32)
    for index, direction in enumerate(template.directions.tolist()):
        normal = _combined(np.zeros_like(position), axes, direction)
        if not template.axis_aligned:
            normal = _unit_or_up(normal, scene.frames, scene.frame[rows])
        normals[index] = normal
    template.normals[vertex] = _interleaved(normals, template.direction)
    template.triangles[triangle] = _items(template.corners + vertex.astype(np.uint32)[:, None])


def _combined(start: Floats, axes: Sequence[Floats], weights: Sequence[float] | Sequence[Floats]) -> Floats:
    """[N, 3] a start, which has no -0, plus axes [N, 3] times a weight each, one after the other.

    A weight of 0 for all leaves out what would not change anything.
    """
    for axis, weight in zip(axes, weights, strict=True):
        if isinstance(weight, np.ndarray):
            start = start + axis * weight
        elif weight:
            start = start + (axis if weight == 1.0 else axis * weight)
    return start


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
    axes, size = np.moveaxis(scene.frames[scene.frame[rest]], 2, 0), scene.size[rest]
    position = scene.position[rest] + 0.0
    stretched = [(axis * size[:, j, None])[row] for j, axis in enumerate(axes)]
    placed.vertices[target] = _combined(position[row], stretched, np.hsplit(shaded.points[source], 3))

    stretch = np.where(shaded.axis_aligned[mesh][:, None], 1.0, cofactors(size))
    stretched = [(axis * stretch[:, j, None])[row] for j, axis in enumerate(axes)]
    normals = _combined(np.zeros((len(row), 3)), stretched, np.hsplit(shaded.normals[source], 3))
    slanted = np.flatnonzero(~shaded.axis_aligned[mesh][row])
    normals[slanted] = _unit_or_up(normals[slanted], scene.frames, scene.frame[rest][row[slanted]])
    placed.normals[target] = normals

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


def _unit_or_up(vectors: Floats, frames: Floats, frame: NDArray[np.integer]) -> Floats:
    """The vectors [N, 3] at length one; the y axis of their frames [N] where there is no direction."""
    x, y, z = vectors.T
    length = np.sqrt(x * x + y * y + z * z)
    lost = np.flatnonzero(length < SHORTEST)
    length[lost] = 1.0
    vectors = vectors / length[:, None]
    vectors[lost] = frames[frame[lost], :, 1]
    return vectors
