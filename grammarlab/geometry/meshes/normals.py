"""Normals of the corners of polygon meshes, and faces turned so that neighbours look to the same side."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, connected
from grammarlab.geometry.meshes.edges import Edges, edges
from grammarlab.geometry.meshes.measure import area_vectors, face_normals
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.planar import sums_by_row
from grammarlab.geometry.meshes.ragged import next_in_row
from grammarlab.geometry.meshes.vectors import unit

_SAME = 1e-12
"""Tolerance of the cosine of an angle between unit normals."""


def corner_normals(meshes: Meshes, angle: float) -> Floats:
    """[C, 3] unit normal of each corner: the mean of those of the faces around that it meets smoothly.

    Args:
        meshes: the meshes.
        angle: degrees; faces that meet at this angle or more meet at a hard edge. 0 gives the normals of the faces.
    """
    table, normals = edges(meshes), face_normals(meshes)
    shared = np.flatnonzero(table.num_faces == 2)
    one, other = table.faces[shared].T
    cosine = np.einsum("ij,ij->i", normals[one], normals[other])
    face = meshes.face_of_corner()
    smooth = shared[np.flatnonzero(cosine > np.cos(np.radians(angle)) + _SAME)]
    group = connected(len(meshes.corners), *_meeting_corners(meshes, table, smooth))
    mean = unit(sums_by_row(group, int(group.max(initial=-1)) + 1, normals[face]))[group]
    has_mean = np.count_nonzero(mean, axis=1) > 0
    return np.where(has_mean[:, None], mean, normals[face])


def _meeting_corners(meshes: Meshes, table: Edges, chosen: Indices) -> tuple[Indices, Indices]:
    """Pairs of corners of two faces at both ends of the chosen edges between them."""
    first, second = table.corner[chosen], _second_corners(meshes, table)[chosen]
    following, point = next_in_row(meshes.face_offsets), meshes.corner_points()
    runs_back = point[first] != point[second]
    at_start = np.where(runs_back, following[second], second)
    at_end = np.where(runs_back, second, following[second])
    return np.concatenate((first, following[first])), np.concatenate((at_start, at_end))


def _second_corners(meshes: Meshes, table: Edges) -> Indices:
    """[E] the corner from which the second face of each edge runs along it; without a meaning where there is none."""
    corners = np.flatnonzero(table.edge_of_corner >= 0)
    edge = table.edge_of_corner[corners]
    of_second = table.faces[edge, 1] == meshes.face_of_corner()[corners]
    result = np.zeros(len(table), np.int64)
    result[edge[of_second]] = corners[of_second]
    return result


def turned_faces(meshes: Meshes) -> NDArray[np.bool_]:
    """[F] faces to turn over so that neighbours look to the same side: out of closed parts, else upwards.

    Faces are neighbours where exactly two share an edge. Where a surface has one side only, such as a Möbius strip,
    some neighbours still differ.
    """
    from scipy.sparse import coo_array  # noqa: PLC0415  # few grammars need it
    from scipy.sparse.csgraph import breadth_first_order  # noqa: PLC0415

    table = edges(meshes)
    shared = np.flatnonzero(table.num_faces == 2)
    one, other = table.faces[shared].T
    point = meshes.corner_points()
    differs = point[table.corner[shared]] == point[_second_corners(meshes, table)[shared]]
    num = meshes.num_faces
    part = connected(num, one, other)
    # 1 between faces that agree and 2 between those that do not; of several edges between two faces the first counts.
    _, first = np.unique(np.minimum(one, other) * num + np.maximum(one, other), return_index=True)
    rows, columns, weight = one[first], other[first], differs[first] + 1
    graph = coo_array((weight, (rows, columns)), shape=(num, num)).tocsr()
    graph = graph + graph.T
    turned = np.zeros(num, bool)
    for start in np.unique(part, return_index=True)[1].tolist():
        order, before = breadth_first_order(graph, start, directed=False)
        for face in order[1:].tolist():
            turned[face] = turned[before[face]] ^ (graph[face, before[face]] == 2)
    return turned ^ _looks_in(meshes.reversed(turned), part)[part]


def _looks_in(meshes: Meshes, part: Indices) -> NDArray[np.bool_]:
    """[K] whether parts [K] of the faces look into what they enclose, or down where they enclose nothing."""
    count = int(part.max(initial=-1)) + 1
    table, areas = edges(meshes), area_vectors(meshes)
    is_open = np.zeros(count, bool)
    is_open[part[table.faces[table.num_faces != 2, 0]]] = True
    corner = meshes.points[meshes.corner_points()[meshes.face_offsets[:-1]]]
    middle = meshes.points.mean(axis=0)
    volume = np.bincount(part, np.einsum("ij,ij->i", corner - middle, areas), count)
    return np.where(is_open, np.bincount(part, areas[:, 1], count) < 0.0, volume < 0.0)
