"""Measures of meshes: normals, areas, volumes, and tests for closed, convex and rectangular meshes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, row_lengths
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.ragged import all_rows, any_rows, next_in_row, sum_rows
from grammarlab.geometry.meshes.vectors import cross, dot, norm

DEGENERATE = 1e-12
"""Smallest area of a face with a normal, as a share of the sum of its squared edges."""

STRAIGHT = 1e-9
"""Sine of the angle below which a corner counts as straight."""


def area_vectors(meshes: Meshes) -> Floats:
    """[F, 3] vector areas in square metres: direction of the normal, length of the area (Newell).

    Corners are taken relative to the first one of their face, so faces far from the origin lose no digits.
    """
    rows, face = meshes.corner_points(), meshes.face_of_corner()
    first = rows.take(meshes.face_offsets[:-1].take(face))
    following = next_in_row(meshes.face_offsets)
    x, y, z = (column.take(rows) - column.take(first) for column in meshes.points.T)
    u, v, w = (column.take(following) for column in (x, y, z))
    vectors = np.empty((meshes.num_faces, 3))
    for axis, product in enumerate((y * w - z * v, z * u - x * w, x * v - y * u)):
        vectors[:, axis] = 0.5 * sum_rows(product, meshes.face_offsets)
    return vectors


def face_areas(meshes: Meshes) -> Floats:
    """[F] areas in square metres."""
    return norm(area_vectors(meshes))


def face_normals(meshes: Meshes) -> Floats:
    """[F, 3] unit normals, counter-clockwise corners seen from their tips; zero for faces without area."""
    x, y, z = _edges(meshes)
    reach = sum_rows(x * x + y * y + z * z, meshes.face_offsets)
    vectors = area_vectors(meshes)
    lengths = norm(vectors)
    return vectors * np.divide(1.0, lengths, out=np.zeros_like(lengths), where=lengths > DEGENERATE * reach)[:, None]


def corner_edges(meshes: Meshes) -> Floats:
    """[C, 3] the vector from each corner to the next one of its face."""
    return np.stack(_edges(meshes), axis=1)


def _edges(meshes: Meshes) -> tuple[Floats, Floats, Floats]:
    """x, y and z of `corner_edges`. Gathering three columns is many times faster than gathering rows."""
    rows = meshes.corner_points()
    ahead = rows.take(next_in_row(meshes.face_offsets))
    x, y, z = (column.take(ahead) - column.take(rows) for column in meshes.points.T)
    return x, y, z


def areas(meshes: Meshes) -> Floats:
    """[M] summed areas of the faces in square metres."""
    return sum_rows(face_areas(meshes), meshes.mesh_faces)


def volumes(meshes: Meshes) -> Floats:
    """[M] signed volumes in cubic metres: positive for a closed mesh whose faces look outwards.

    For open meshes it is the volume of the cone from their first point over the faces.
    """
    first_corner = meshes.corner_points()[np.minimum(meshes.face_offsets[:-1], max(len(meshes.corners) - 1, 0))]
    apex = meshes.points[meshes.mesh_points[:-1][meshes.mesh_of_face()]]
    heights = meshes.points[first_corner] - apex
    return sum_rows(dot(heights, area_vectors(meshes)), meshes.mesh_faces) / 3.0


def is_closed(meshes: Meshes) -> Flags:
    """[M] whether faces pass every edge equally often in both directions.

    A mesh without faces, or with a face of fewer than three corners, is not closed.
    """
    start = meshes.corner_points()
    end = start.take(next_in_row(meshes.face_offsets))
    key = np.minimum(start, end) * len(meshes.points) + np.maximum(start, end)
    order = np.argsort(key)
    first = np.flatnonzero(np.diff(key.take(order), prepend=-1))
    balance = np.add.reduceat(np.sign(end - start).take(order), first) if len(first) else first
    closed = row_lengths(meshes.mesh_faces) > 0
    face_of_open_edge = meshes.face_of_corner()[order[first[balance != 0]]]
    mesh_of_face = meshes.mesh_of_face()
    closed[mesh_of_face[face_of_open_edge]] = False
    closed[mesh_of_face[row_lengths(meshes.face_offsets) < 3]] = False
    return closed


def is_reflex(meshes: Meshes) -> Flags:
    """[C] whether a face turns right or straight back at each corner; false on faces without area."""
    following = next_in_row(meshes.face_offsets)
    x, y, z = _edges(meshes)
    u, v, w = (column.take(following) for column in (x, y, z))
    face = meshes.face_of_corner()
    p, q, r = (column.take(face) for column in face_normals(meshes).T)
    turn = (y * w - z * v) * p + (z * u - x * w) * q + (x * v - y * u) * r
    lengths = np.sqrt(x * x + y * y + z * z)
    slack = STRAIGHT * lengths * lengths.take(following)
    turns_back = (x * u + y * v + z * w < 0.0) & (np.abs(turn) <= slack)
    reflex = np.zeros(len(x), bool)
    reflex[following] = ((turn < -slack) | turns_back) & ((p != 0.0) | (q != 0.0) | (r != 0.0))
    return reflex


def is_convex(meshes: Meshes) -> Flags:
    """[F] whether a face has no reflex corner."""
    return ~any_rows(is_reflex(meshes), meshes.face_offsets)


def is_rectangular(meshes: Meshes, tolerance_degrees: float) -> Flags:
    """[M] whether there is a face, and all faces have four corners of 90 degrees, up to the tolerance."""
    edges = corner_edges(meshes)
    ahead = edges.take(next_in_row(meshes.face_offsets), axis=0)
    scale = norm(edges) * norm(ahead)
    # The slack accepts right angles under tolerance 0 after a rotation of the whole shape.
    limit = (np.sin(np.radians(tolerance_degrees)) + STRAIGHT) * scale
    right = (np.abs(dot(edges, ahead)) <= limit) & (scale > 0.0)
    faces = all_rows(right, meshes.face_offsets) & (row_lengths(meshes.face_offsets) == 4)
    return all_rows(faces, meshes.mesh_faces) & (row_lengths(meshes.mesh_faces) > 0)


def is_planar(meshes: Meshes, tolerance_degrees: float) -> Flags:
    """[M] whether there is a face, and no normal at a corner differs from the face normal by more than the angle."""
    edges = corner_edges(meshes)
    local = cross(edges, edges.take(next_in_row(meshes.face_offsets), axis=0))
    normals = face_normals(meshes).take(meshes.face_of_corner(), axis=0)
    flat = np.abs(dot(local, normals)) >= (np.cos(np.radians(tolerance_degrees)) - STRAIGHT) * norm(local)
    faces = all_rows(flat, meshes.face_offsets)
    return all_rows(faces, meshes.mesh_faces) & (row_lengths(meshes.mesh_faces) > 0)


def has_concave_face(meshes: Meshes) -> Flags:
    """[M] whether at least one face is concave."""
    return ~all_rows(is_convex(meshes), meshes.mesh_faces)


def num_faces(meshes: Meshes) -> NDArray[np.int64]:
    """[M] faces of each mesh."""
    return row_lengths(meshes.mesh_faces)


def num_vertices(meshes: Meshes) -> NDArray[np.int64]:
    """[M] points of each mesh."""
    return row_lengths(meshes.mesh_points)


def steepest_slope(meshes: Meshes) -> tuple[Floats, Floats]:
    """Slope and direction of the steepest face, for meshes whose y axis points up and whose -z axis points north.

    Returns:
        [M] degrees between that face and the ground, 0..90, and [M] the compass direction in which it descends,
        clockwise from north, 0 <= azimuth < 360; both 0 for a mesh without a face that has an area.
    """
    normals = face_normals(meshes)
    upward = normals * np.where(normals[:, 1:2] < 0.0, -1.0, 1.0)
    slope = np.degrees(np.arctan2(np.hypot(upward[:, 0], upward[:, 2]), upward[:, 1]))
    azimuth = np.degrees(np.arctan2(upward[:, 0], -upward[:, 2])) % 360.0
    order = np.lexsort((-slope, meshes.mesh_of_face()))
    filled = row_lengths(meshes.mesh_faces) > 0
    chosen = order[meshes.mesh_faces[:-1][filled]]
    result = np.zeros((2, len(meshes)))
    result[:, filled] = slope[chosen], azimuth[chosen]
    return result[0], result[1]
