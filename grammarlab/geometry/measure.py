"""What can be measured on meshes: normals, areas, volumes, and whether they are closed, convex or rectangular."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grammarlab.geometry.mesh import Floats, Meshes
from grammarlab.geometry.ragged import all_rows, any_rows, next_in_row, sum_rows
from grammarlab.geometry.vectors import cross, dot, norm

Flags = NDArray[np.bool_]

DEGENERATE = 1e-12
"""A face whose area is below this share of its squared perimeter has no normal."""

STRAIGHT = 1e-9
"""Sine of the angle below which a corner counts as straight."""


def area_vectors(meshes: Meshes) -> Floats:
    """[F, 3] vector areas in square metres: direction of the normal, length of the area (Newell).

    Corners are taken relative to the first one of their face, so faces far from the origin lose no digits.
    """
    corners = meshes.points[meshes.corner_points()]
    face = meshes.face_of_corner()
    spokes = corners - corners[meshes.face_offsets[:-1][face]]
    products = cross(spokes, spokes[next_in_row(meshes.face_offsets)])
    return 0.5 * sum_rows(products, meshes.face_offsets)


def face_areas(meshes: Meshes) -> Floats:
    """[F] areas in square metres."""
    return norm(area_vectors(meshes))


def face_normals(meshes: Meshes) -> Floats:
    """[F, 3] unit normals, counter-clockwise corners seen from their tips; zero for faces without area."""
    vectors = area_vectors(meshes)
    lengths = norm(vectors)
    perimeters = sum_rows(norm(corner_edges(meshes)), meshes.face_offsets)
    solid = lengths > DEGENERATE * perimeters**2
    return np.where(solid[:, None], vectors / np.where(solid, lengths, 1.0)[:, None], 0.0)


def corner_edges(meshes: Meshes) -> Floats:
    """[C, 3] the vector from each corner to the next one of its face."""
    corners = meshes.points[meshes.corner_points()]
    return corners[next_in_row(meshes.face_offsets)] - corners


def areas(meshes: Meshes) -> Floats:
    """[M] summed areas of the faces in square metres."""
    return sum_rows(face_areas(meshes), meshes.mesh_faces)


def volumes(meshes: Meshes) -> Floats:
    """[M] signed volumes in cubic metres: positive for a closed mesh whose faces look outwards.

    Open meshes give the volume of the cone from their first point over the faces.
    """
    first_corner = meshes.corner_points()[np.minimum(meshes.face_offsets[:-1], max(len(meshes.corners) - 1, 0))]
    apex = meshes.points[meshes.mesh_points[:-1][meshes.mesh_of_face()]]
    heights = meshes.points[first_corner] - apex
    return sum_rows(dot(heights, area_vectors(meshes)), meshes.mesh_faces) / 3.0


def is_closed(meshes: Meshes) -> Flags:
    """[M] whether every edge is run through as often in one direction as in the other.

    A mesh without faces, or with a face of fewer than three corners, is not closed.
    """
    start = meshes.corner_points()
    end = start[next_in_row(meshes.face_offsets)]
    key = np.minimum(start, end) * len(meshes.points) + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1))
    balance = np.add.reduceat(np.sign(end - start)[order], first) if len(first) else np.zeros(0, np.int64)
    closed = np.diff(meshes.mesh_faces) > 0
    mesh_of_corner = meshes.mesh_of_face()[meshes.face_of_corner()]
    closed[mesh_of_corner[order[first[balance != 0]]]] = False
    closed[meshes.mesh_of_face()[np.diff(meshes.face_offsets) < 3]] = False
    return closed


def is_reflex(meshes: Meshes) -> Flags:
    """[C] whether a face turns to the right at this corner, or straight back."""
    edges = corner_edges(meshes)
    following = next_in_row(meshes.face_offsets)
    ahead = edges[following]
    normals = face_normals(meshes)[meshes.face_of_corner()]
    lengths = norm(edges)
    scale = lengths * lengths[following]
    left = dot(cross(edges, ahead), normals)
    onward = dot(edges, ahead)
    turns_well = (left > STRAIGHT * scale) | ((left >= -STRAIGHT * scale) & (onward >= 0.0))
    reflex = np.zeros(len(edges), bool)
    reflex[following] = ~turns_well
    return reflex


def is_convex(meshes: Meshes) -> Flags:
    """[F] whether a face has no reflex corner."""
    return ~any_rows(is_reflex(meshes), meshes.face_offsets)


def is_rectangular(meshes: Meshes, tolerance_degrees: float) -> Flags:
    """[M] whether there is a face, and all faces have four corners of 90 degrees give or take the tolerance."""
    edges = corner_edges(meshes)
    ahead = edges[next_in_row(meshes.face_offsets)]
    scale = norm(edges) * norm(ahead)
    cosine = np.abs(dot(edges, ahead))
    # The slack keeps a right angle right under tolerance 0 after a rotation of the whole shape.
    right = (cosine <= (np.sin(np.radians(tolerance_degrees)) + STRAIGHT) * scale) & (scale > 0.0)
    faces = all_rows(right, meshes.face_offsets) & (np.diff(meshes.face_offsets) == 4)
    return all_rows(faces, meshes.mesh_faces) & (np.diff(meshes.mesh_faces) > 0)


def is_planar(meshes: Meshes, tolerance_degrees: float) -> Flags:
    """[M] whether there is a face, and at no corner the local normal leaves the face normal by more than the angle."""
    edges = corner_edges(meshes)
    local = cross(edges, edges[next_in_row(meshes.face_offsets)])
    lengths = norm(local)
    normals = face_normals(meshes)[meshes.face_of_corner()]
    aligned = np.abs(dot(local, normals))
    flat = aligned >= (np.cos(np.radians(tolerance_degrees)) - STRAIGHT) * lengths
    faces = all_rows(flat, meshes.face_offsets)
    return all_rows(faces, meshes.mesh_faces) & (np.diff(meshes.mesh_faces) > 0)


def has_concave_face(meshes: Meshes) -> Flags:
    """[M] whether at least one face is concave."""
    return ~all_rows(is_convex(meshes), meshes.mesh_faces)


def num_faces(meshes: Meshes) -> NDArray[np.int64]:
    """[M] faces of each mesh."""
    return np.diff(meshes.mesh_faces)


def num_vertices(meshes: Meshes) -> NDArray[np.int64]:
    """[M] points of each mesh."""
    return np.diff(meshes.mesh_points)


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
    filled = np.diff(meshes.mesh_faces) > 0
    chosen = order[meshes.mesh_faces[:-1][filled]]
    result = np.zeros((2, len(meshes)))
    result[:, filled] = slope[chosen], azimuth[chosen]
    return result[0], result[1]
