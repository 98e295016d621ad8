"""Vertices and normals of all instances of a scene.

Meshes that many instances use (boxes, rectangles, cylinders) are placed column by column, each distinct point once. The
others share one ragged gather. Both add the same products in the same order, without libraries that might use another
order: an instance is the same to the last bit alone and in any batch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints, row_lengths, row_of_value, take_rows
from grammarlab.scene.instances import Scene
from grammarlab.scene.shading import ShadedMeshes

MANY_INSTANCES = 64
"""Smallest number of instances for which a mesh is placed with a template."""
MOST_TEMPLATES = 32
"""Largest number of templates, since each costs a few calls."""
LARGEST_TEMPLATE = 256
"""Largest number of vertices of a template; each costs a few calls, and for larger meshes a gather is as fast."""
BLOCK_ROWS = 700
"""Instances placed at a time, so that calls cost less than their work,"""
BLOCK_VALUES = 50_000
"""or more, if they are small: numbers that stay in the cache until they are stored."""
REST_VERTICES = 20_000
"""Vertices of other meshes that are placed at a time."""
SHORTEST = 1e-18
"""Smallest length of a normal with a direction; its square is still an exact 32-bit number."""


@dataclass(frozen=True, slots=True)
class PlacedTriangles:
    """Vertices and triangles of instances, one instance after the other."""

    vertices: NDArray[np.float32]
    """[V, 3] metres."""
    normals: NDArray[np.float32]
    """[V, 3] unit vectors."""
    triangles: NDArray[np.uint32]
    """[T, 3] rows of `vertices`."""


def place_instances(
    scene: Scene,
    shaded: ShadedMeshes,
    mesh: Ints,
    vertex_offsets: Ints,
    triangle_offsets: Ints,
) -> PlacedTriangles:
    """Place every instance of a scene.

    Args:
        scene: the instances, in the order of the result.
        shaded: the unique meshes.
        mesh: [I] the mesh of each instance, index into `shaded`.
        vertex_offsets: [I + 1] offsets of the vertices of each instance.
        triangle_offsets: [I + 1] offsets of the triangles of each instance.
    """
    placed = PlacedTriangles(
        np.empty((vertex_offsets[-1], 3), np.float32),
        np.empty((vertex_offsets[-1], 3), np.float32),
        np.empty((triangle_offsets[-1], 3), np.uint32),
    )
    most_used = _most_used(shaded, mesh)
    # By axis, then by coordinate: numbers that are computed in the same way are adjacent.
    axes = np.ascontiguousarray(scene.frames.T)
    templates = [_template(shaded, index, placed) for index in most_used.tolist()]
    by_kind, ends = _by_kind(most_used, shaded, mesh)
    for template, (first, end) in zip(templates, pairwise(ends), strict=True):
        _place_template(template, scene, axes, by_kind[first:end], vertex_offsets, triangle_offsets)
    for rest in _blocks(by_kind[ends[-1] :], np.diff(vertex_offsets)):
        _place_rest(placed, scene, shaded, axes, mesh, rest, vertex_offsets, triangle_offsets)
    return placed


def repeated_values(values: Floats, shaded: ShadedMeshes, mesh: Ints, vertex_offsets: Ints) -> NDArray[np.float32]:
    """[V, K] values of the vertices of every instance of a scene, equal to those of its mesh.

    Args:
        values: [W, K] values of the vertices of the meshes.
        shaded: the unique meshes.
        mesh: [I] the mesh of each instance, index into `shaded`.
        vertex_offsets: [I + 1] offsets of the vertices of each instance.
    """
    single = values.astype(np.float32)
    result = np.empty((vertex_offsets[-1], values.shape[1]), np.float32)
    most_used = _most_used(shaded, mesh)
    by_kind, ends = _by_kind(most_used, shaded, mesh)
    for index, (first, end) in zip(most_used.tolist(), pairwise(ends), strict=True):
        of_mesh = single[slice(*shaded.mesh_vertices[index : index + 2])]
        _windows(result, len(of_mesh))[vertex_offsets.take(by_kind[first:end])] = _items(of_mesh.reshape(1, -1))
    for rest in _blocks(by_kind[ends[-1] :], row_lengths(vertex_offsets)):
        source, _ = take_rows(shaded.mesh_vertices, mesh[rest])
        target, _ = take_rows(vertex_offsets, rest)
        result[target] = single.take(source, axis=0)
    return result


def _by_kind(most_used: Ints, shaded: ShadedMeshes, mesh: Ints) -> tuple[Ints, list[int]]:
    """Instances [I] by mesh, those of the most used ones [K] first, and the ends [K + 1] of these after a 0."""
    kind = np.full(len(shaded.mesh_vertices) - 1, len(most_used), np.int8)
    kind[most_used] = np.arange(len(most_used))
    kind_of_instance = kind[mesh]
    by_kind = np.argsort(kind_of_instance, kind="stable")
    return by_kind, np.searchsorted(kind_of_instance, np.arange(len(most_used) + 1), sorter=by_kind).tolist()


def _blocks(instances: Ints, num_vertices: Ints) -> Iterator[Ints]:
    """Consecutive instances whose vertices together stay in the cache, at least one in each block."""
    block = np.cumsum(num_vertices[instances]) // REST_VERTICES
    yield from np.split(instances, np.flatnonzero(np.diff(block)) + 1) if len(instances) else ()


def _most_used(shaded: ShadedMeshes, mesh: Ints) -> Ints:
    """Meshes used often enough for a template, most used first."""
    uses = np.bincount(mesh, minlength=len(shaded.mesh_vertices) - 1)
    num_vertices = np.diff(shaded.mesh_vertices)
    uses[(num_vertices > LARGEST_TEMPLATE) | (num_vertices == 0)] = 0
    most = np.argsort(-uses, kind="stable")[:MOST_TEMPLATES]
    return most[uses[most] >= MANY_INSTANCES]


class _Template(NamedTuple):
    """A mesh of V vertices and T triangles, with views of its possible destinations."""

    points: Floats
    """[P, 3] its distinct points."""
    point: Ints
    """[V] index of the point of each vertex."""
    directions: Floats
    """[D, 3] its distinct normals."""
    direction: Ints
    """[V] index of the normal of each vertex."""
    corners: NDArray[np.uint32]
    """[3 T] vertices, counted from the first of the mesh."""
    axis_aligned: bool
    vertices: NDArray[np.void]
    """[R] row i is the memory of V vertices from vertex i of the result: storing to it is one block copy."""
    normals: NDArray[np.void]
    """[R] the same for normals."""
    triangles: NDArray[np.void]
    """[S] the same for triangles."""


def _template(shaded: ShadedMeshes, mesh: int, placed: PlacedTriangles) -> _Template:
    vertices = slice(*shaded.mesh_vertices[mesh : mesh + 2])
    corners = shaded.triangles[slice(*shaded.mesh_triangles[mesh : mesh + 2])]
    points, point = _distinct(shaded.points[vertices])
    directions, direction = _distinct(shaded.normals[vertices])
    return _Template(
        points=points,
        point=point,
        directions=directions,
        direction=direction,
        corners=corners.astype(np.uint32).ravel(),
        axis_aligned=bool(shaded.axis_aligned[mesh]),
        vertices=_windows(placed.vertices, len(point)),
        normals=_windows(placed.normals, len(point)),
        triangles=_windows(placed.triangles, len(corners)),
    )


def _distinct(vectors: Floats) -> tuple[Floats, Ints]:
    """Distinct vectors [P, 3] of vectors [V, 3] in ascending order, and the index [V] of each among them."""
    order = np.lexsort(vectors.T[::-1])
    ascending = vectors[order]
    is_new = np.empty(len(order), dtype=bool)
    is_new[:1] = True
    np.any(ascending[1:] != ascending[:-1], axis=1, out=is_new[1:])
    index = np.empty_like(order)
    index[order] = np.cumsum(is_new) - 1
    return ascending[is_new], index


def _windows(rows: NDArray[Any], width: int) -> NDArray[np.void]:
    """Every `width` consecutive rows of an array [N, K] of 32-bit numbers as one item, sharing its memory."""
    size = rows.strides[0]
    return np.ndarray(max(len(rows) - width + 1, 0), f"V{size * width}", buffer=rows, strides=(size,))


def _items(block: NDArray[Any]) -> NDArray[np.void]:
    """[N] each row of a block [N, K] of 32-bit numbers as one item."""
    return block.view(f"V{4 * block.shape[1]}")[:, 0]


def _interleaved(vectors: Floats, chosen: Ints) -> NDArray[np.void]:
    """[N] as one item for each instance, the chosen [V] of its vectors [P, 3, N]."""
    columns = vectors.astype(np.float32).take(chosen, axis=0).reshape(3 * len(chosen), -1)
    return _items(np.ascontiguousarray(columns.T))


def _place_template(
    template: _Template, scene: Scene, axes: Floats, rows: Ints, vertex_offsets: Ints, triangle_offsets: Ints
) -> None:
    """Place the instances at `rows` [N], which all use the mesh of `template`; axes [3, 3, K] as for `_sums`."""
    by_frame = _by_frame(template, axes, scene.frame.take(rows))
    step = max(BLOCK_ROWS, BLOCK_VALUES // (3 * len(template.point)))
    for start in range(0, len(rows), step):
        block = rows[start : start + step]
        frame, size, vertex = scene.frame.take(block), _columns(scene.size, block), vertex_offsets.take(block)
        turned = axes.take(frame, axis=2)
        points = _sums(_columns(scene.position, block) + 0.0, turned * size[:, None], template.points)
        template.vertices[vertex] = _interleaved(points, template.point)
        template.normals[vertex] = _normals(template, turned, size) if by_frame is None else by_frame.take(frame)
        template.triangles[triangle_offsets.take(block)] = _items(template.corners + vertex.astype(np.uint32)[:, None])


def _by_frame(template: _Template, axes: Floats, frame: NDArray[np.integer]) -> NDArray[np.void] | None:
    """[K] normals of a mesh in each of the frames [N] of its instances; None if they also depend on size.

    It is None, too, if most instances have their own frame.
    """
    num_frames = axes.shape[2]
    if not template.axis_aligned or num_frames > len(frame):
        return None
    is_used = np.zeros(num_frames, dtype=bool)
    is_used[frame] = True
    used = np.flatnonzero(is_used)
    normals = np.empty(num_frames, template.normals.dtype)
    normals[used] = _normals(template, axes.take(used, axis=2), np.ones((3, 1)))
    return normals


def _normals(template: _Template, axes: Floats, size: Floats) -> NDArray[np.void]:
    """[N] the unit normals of a mesh of sizes [3, N] under axes [3, 3, N]."""
    start = np.zeros(axes.shape[1:])
    if template.axis_aligned:
        return _interleaved(_sums(start, axes, template.directions), template.direction)
    normals = _sums(start, axes * cofactors(size)[:, None], template.directions)
    return _interleaved(_unit_or(normals, axes[1]), template.direction)


def _columns(rows: Floats, chosen: Ints) -> Floats:
    """[3, N] selected rows [N] of an array [I, 3], coordinate by coordinate."""
    return np.ascontiguousarray(rows.take(chosen, axis=0).T)


def _sums(start: Floats, axes: Floats, weights: Floats) -> Floats:
    """[P, 3, N] a start [3, N], which has no -0, plus axes [3, 3, N] times weights [P, 3], one axis after the other.

    Consecutive rows of weights with equal beginnings share their partial sums.
    """
    sums = np.empty((len(weights), *start.shape))
    x = y = np.nan
    by_x = by_y = start
    columns = zip(axes, weights.T.tolist(), strict=True)
    products = [{weight: _times(axis, weight) for weight in set(column)} for axis, column in columns]
    for index, (first, second, third) in enumerate(weights.tolist()):
        if first != x:
            x, y, by_x = first, np.nan, start + products[0][first] if first else start
        if second != y:
            y, by_y = second, by_x + products[1][second] if second else by_x
        if third:
            np.add(by_y, products[2][third], out=sums[index])
        else:
            sums[index] = by_y
    return sums


def _times(axis: Floats, weight: float) -> Floats:
    return axis if weight == 1.0 else axis * weight


def _place_rest(
    placed: PlacedTriangles,
    scene: Scene,
    shaded: ShadedMeshes,
    axes: Floats,
    mesh_of_instance: Ints,
    rest: Ints,
    vertex_offsets: Ints,
    triangle_offsets: Ints,
) -> None:
    """Place the instances at `rest`, of any meshes."""
    mesh = mesh_of_instance[rest]
    source, _ = take_rows(shaded.mesh_vertices, mesh)
    target, _ = take_rows(vertex_offsets, rest)
    row = row_of_value(np.diff(shaded.mesh_vertices)[mesh])
    turned, size = axes.take(scene.frame[rest], axis=2), _columns(scene.size, rest)
    position = _columns(scene.position, rest) + 0.0
    placed.vertices[target] = _sums_by_row(position, turned * size[:, None], shaded.points[source], row).T

    stretch = np.where(shaded.axis_aligned[mesh], 1.0, cofactors(size))
    stretched = turned * stretch[:, None]
    normals = _sums_by_row(np.zeros_like(position), stretched, shaded.normals[source], row)
    slanted = np.flatnonzero(~shaded.axis_aligned[mesh][row])
    normals[:, slanted] = _unit_or(normals[:, slanted], turned[1].take(row[slanted], axis=1))
    placed.normals[target] = normals.T

    source, _ = take_rows(shaded.mesh_triangles, mesh)
    target, _ = take_rows(triangle_offsets, rest)
    first = vertex_offsets[rest][row_of_value(np.diff(shaded.mesh_triangles)[mesh])]
    placed.triangles[target] = shaded.triangles[source] + first[:, None]


def _sums_by_row(start: Floats, axes: Floats, weights: Floats, row: Ints) -> Floats:
    """[3, N] sums as in `_sums`, for weights [N, 3] with rows [N] of the start [3, R] and the axes [3, 3, R]."""
    sums = start.take(row, axis=1)
    for axis, weight in zip(axes, weights.T, strict=True):
        sums += axis.take(row, axis=1) * weight
    return sums


def cofactors(size: Floats) -> Floats:
    """[3, N] scale factors of area vectors for sizes [3, N], up to a common factor.

    Unlike division by the size, they are valid for shapes of thickness 0.
    """
    x, y, z = size
    largest = np.maximum(np.maximum(x, y), np.maximum(z, np.finfo(np.float32).tiny))
    x, y, z = x / largest, y / largest, z / largest
    return np.stack((y * z, z * x, x * y))


def _unit_or(vectors: Floats, otherwise: Floats) -> Floats:
    """The vectors [..., 3, N] at length one; those of `otherwise` [3, N] if there is no direction."""
    x, y, z = np.moveaxis(vectors, -2, 0)
    length = np.sqrt(x * x + y * y + z * z)[..., None, :]
    is_too_short = length < SHORTEST
    if not is_too_short.any():
        return vectors / length
    return np.where(is_too_short, otherwise, vectors / np.where(is_too_short, 1.0, length))
