"""Patches: flat parts of a mesh that its file keeps apart from their neighbours.

Programs that draw buildings write a wall as one polygon with holes, and the panes and frames in its holes as others.
Triangles of one polygon share points of the file; those of different polygons, or of different materials, often do not,
even where they lie in one plane.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from grammarlab.arrays import Flags, Floats, Ints

_FLAT_M = 0.005
"""Largest distance of a point of a triangle from the plane of its neighbour in the same patch, metres."""


def patches_of(points: Floats, triangles: Ints, material: Ints) -> Ints:
    """[T] number of the patch of each triangle, from 0: connected, flat, and of one material.

    Args:
        points: [P, 3] points of the file, metres.
        triangles: [T, 3] rows of `points`. If no two of them share a point, equal points are one.
        material: [T] numbers of materials.

    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> halves = np.array([[0, 1, 2], [0, 2, 3]])
    >>> [len(set(patches_of(square, halves, np.array([0, color])).tolist())) for color in (0, 1)]
    [1, 2]
    """
    placed = np.unique(points[triangles].reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 3)
    if len(np.unique(triangles)) == triangles.size:
        triangles = placed
    # What is there twice, as one.
    _, once, index = np.unique(np.sort(placed, axis=1), axis=0, return_index=True, return_inverse=True)
    return _patches(points[triangles][once], triangles[once], material[once])[index.reshape(-1)]


def _patches(corners: Floats, triangles: Ints, material: Ints) -> Ints:
    """[T] number of the patch of each triangle, no two of which are at one place."""
    # Flat polygons are patches, though slivers of their triangles seem to be tilted by rounded coordinates.
    polygon = _polygons(triangles, material)
    first, second = _neighbours(triangles)
    joined = (material[first] == material[second]) & _are_level(corners, first, second)
    patch = _connected(first[joined], second[joined], len(triangles))
    is_polygon = _are_flat(corners, polygon)[polygon]
    return np.unique(np.where(is_polygon, polygon, len(triangles) + patch), return_inverse=True)[1].astype(np.int64)


def _polygons(triangles: Ints, material: Ints) -> Ints:
    """[T] number of the set of triangles of one material that are connected by points."""
    num = len(triangles)
    point = triangles * (int(material.max(initial=0)) + 1) + material[:, None]
    shared = np.unique(point, return_inverse=True)[1].reshape(-1)
    return _connected(np.repeat(np.arange(num), 3), num + shared, num + int(shared.max(initial=-1)) + 1)[:num]


def _connected(first: Ints, second: Ints, num: int) -> Ints:
    """[num] number of the connected component of each item, for pairs."""
    graph = coo_matrix((np.ones(len(first)), (first, second)), shape=(num, num))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _neighbours(triangles: Ints) -> tuple[Ints, Ints]:
    """Pairs of triangles that share a side."""
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    key = ends[:, 0] * (int(triangles.max(initial=0)) + 1) + ends[:, 1]
    order = np.argsort(key, kind="stable")
    shared = np.flatnonzero(np.diff(key[order]) == 0)
    return order[shared] // 3, order[shared + 1] // 3


def _normals(corners: Floats) -> Floats:
    """[T, 3] normals, twice as long as the area of each triangle."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _are_flat(corners: Floats, polygon: Ints) -> Flags:
    """[K] whether all corners of a polygon lie in the plane of its mean normal."""
    num = int(polygon.max(initial=-1)) + 1
    normal, centre = np.zeros((num, 3)), np.zeros((num, 3))
    np.add.at(normal, polygon, _normals(corners))
    np.add.at(centre, polygon, corners.mean(axis=1))
    length = np.linalg.norm(normal, axis=1)
    centre /= np.bincount(polygon, minlength=num)[:, None]
    height = np.einsum("kij,kj->ki", corners - centre[polygon][:, None], normal[polygon])
    low, high = np.full(num, np.inf), np.full(num, -np.inf)
    np.minimum.at(low, polygon, height.min(axis=1))
    np.maximum.at(high, polygon, height.max(axis=1))
    return (high - low <= 2.0 * _FLAT_M * length) & (length > 0.0)


def _are_level(corners: Floats, first: Ints, second: Ints) -> Flags:
    """Whether the smaller triangle of each pair lies in the plane of the larger one: normals of slivers say little."""
    normal = _normals(corners)
    length = np.linalg.norm(normal, axis=1)
    swapped = length[first] < length[second]
    large, small = np.where(swapped, second, first), np.where(swapped, first, second)
    away = corners[small] - corners[large][:, :1]
    distance = np.abs(np.einsum("kij,kj->ki", away, normal[large])).max(axis=1, initial=0.0)
    return distance <= _FLAT_M * length[large]
