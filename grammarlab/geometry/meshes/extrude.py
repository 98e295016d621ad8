"""Prisms over the faces of meshes: CGA's ``extrude``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grammarlab.arrays import Flags, Floats, offsets_from_counts, row_lengths, take_rows
from grammarlab.geometry.meshes.edges import edges, in_rings
from grammarlab.geometry.meshes.measure import area_vectors, face_normals
from grammarlab.geometry.meshes.mesh import BOTTOM, INNER_WALL, OUTER_WALL, TOP, Indices, Meshes, Soup
from grammarlab.geometry.meshes.ragged import any_rows, next_in_row, sum_rows
from grammarlab.geometry.meshes.vectors import dot, has_length, unit

SAME_DIRECTION = 1e-9
"""Largest difference of unit normals of faces that are extruded together."""


def extrude(meshes: Meshes, heights: Floats, directions: Floats | None = None, roles: bool = False) -> Meshes:
    """Every face moved along a direction, with walls between its old and new place.

    The faces of a result are, face by face as in CityEngine: the original face, the moved face, the walls in the order
    of the face's edges. A face that is turned over begins with its first edge. A wall's first edge is its edge on the
    face, and all faces point outwards for both signs of the height.

    Args:
        meshes: M meshes. If all faces of a mesh move in the same way, an edge between two of them gets no wall.
        heights: [M] metres, signed. A mesh of height 0 does not change.
        directions: [M, 3] unit vectors; each face's own normal by default.
        roles: whether the faces get the roles `BOTTOM`, `TOP`, `OUTER_WALL` and `INNER_WALL` (along holes).
    """
    normals = face_normals(meshes)
    if directions is None:
        together = _moves_as_one(meshes, normals)
        along = normals
    else:
        together = np.ones(len(meshes), bool)
        along = directions[meshes.mesh_of_face()]
    loose = meshes if together.all() else _with_own_points(meshes, ~together)
    shift = np.zeros_like(loose.points)
    face = loose.face_of_corner()
    shift[loose.corner_points()] = (along * heights[loose.mesh_of_face()][:, None])[face]
    return _prisms(loose, shift, heights != 0.0, roles)


def extrude_along_vertex_normals(meshes: Meshes, heights: Floats, roles: bool = False) -> Meshes:
    """Every vertex moved along the mean normal of its faces, with walls along boundary edges.

    Args:
        meshes: M meshes.
        heights: [M] metres, signed. A mesh of height 0 does not change.
        roles: as for `extrude`.
    """
    mean = np.zeros_like(meshes.points)
    np.add.at(mean, meshes.corner_points(), face_normals(meshes)[meshes.face_of_corner()])
    return _prisms(meshes, unit(mean) * heights[meshes.mesh_of_point()][:, None], heights != 0.0, roles)


def extrude_to_level(meshes: Meshes, heights: Floats, up: Floats, roles: bool = False) -> Meshes:
    """Every vertex moved along a direction to one level per mesh: CGA's ``world.up.flatTop``.

    A height >= 0 counts from the lowest vertex and the level is at least that of the highest one; a negative height
    counts from the highest vertex and the level is at most that of the lowest one.

    Args:
        meshes: M meshes.
        heights: [M] metres, signed.
        up: [M, 3] unit vectors.
        roles: as for `extrude`.
    """
    of_point = meshes.mesh_of_point()
    level = dot(meshes.points, up[of_point])
    low, high = np.full(len(meshes), np.inf), np.full(len(meshes), -np.inf)
    np.minimum.at(low, of_point, level)
    np.maximum.at(high, of_point, level)
    target = np.where(heights >= 0.0, np.maximum(low + heights, high), np.minimum(high + heights, low))
    rise = target[of_point] - level
    moves = np.zeros(len(meshes), bool)
    moves[of_point[rise != 0.0]] = True
    return _prisms(meshes, up[of_point] * rise[:, None], moves, roles)


def extrude_edges(meshes: Meshes, shift: Floats) -> Meshes:
    """Edges, as faces of two corners, swept to rectangles that begin with them.

    Args:
        meshes: M meshes of faces of two corners.
        shift: [M, 3] metres.
    """
    ends = meshes.points[meshes.corner_points()].reshape(-1, 2, 3)
    moved = ends + shift[meshes.mesh_of_face()][:, None]
    corners = np.concatenate((ends, moved[:, ::-1]), axis=1)
    return Meshes.from_polygons(corners.reshape(-1, 3), np.full(len(ends), 4), row_lengths(meshes.mesh_faces))


def are_edges(meshes: Meshes) -> Flags:
    """[M] whether meshes have only faces of two corners."""
    is_area = row_lengths(meshes.face_offsets) != 2
    has_area = np.bincount(meshes.mesh_of_face()[is_area], minlength=len(meshes)) > 0
    return ~has_area & (row_lengths(meshes.mesh_faces) > 0)


def _moves_as_one(meshes: Meshes, normals: Floats) -> Flags:
    """[M] whether all faces of a mesh have one normal."""
    filled = row_lengths(meshes.mesh_faces) > 0
    first = np.zeros((len(meshes), 3))
    first[filled] = normals[meshes.mesh_faces[:-1][filled]]
    of_face = meshes.mesh_of_face()
    differs = np.abs(normals - first[of_face]).max(axis=1, initial=0.0) > SAME_DIRECTION
    return np.bincount(of_face[differs], minlength=len(meshes)) == 0


def _with_own_points(meshes: Meshes, chosen: Flags) -> Meshes:
    """Meshes in which the faces of the chosen ones share no points, and no face repeats a point."""
    corners_per_mesh = row_lengths(meshes.face_offsets[meshes.mesh_faces])
    points_per_mesh = np.where(chosen, corners_per_mesh, row_lengths(meshes.mesh_points))
    mesh_points = offsets_from_counts(points_per_mesh)
    chosen_corner = np.repeat(chosen, corners_per_mesh)
    corner_index = np.arange(len(meshes.corners)) - np.repeat(
        meshes.face_offsets[meshes.mesh_faces[:-1]], corners_per_mesh
    )
    corners = np.where(chosen_corner, corner_index, meshes.corners)
    points = np.empty((mesh_points[-1], 3))
    is_unchanged = np.repeat(~chosen, row_lengths(meshes.mesh_points))
    old, _ = take_rows(mesh_points, np.flatnonzero(~chosen))
    points[old] = meshes.points[is_unchanged]
    own_points = corner_index + np.repeat(mesh_points[:-1], corners_per_mesh)
    points[own_points[chosen_corner]] = meshes.points[meshes.corner_points()[chosen_corner]]
    return Meshes(
        points=points,
        corners=corners,
        face_offsets=meshes.face_offsets,
        mesh_faces=meshes.mesh_faces,
        mesh_points=mesh_points,
        tags=meshes.tags,
        data=meshes.data,
    )


def _prisms(meshes: Meshes, shift: Floats, moves: Flags, roles: bool) -> Meshes:
    """Original faces, moved faces and walls of the meshes that move; the others unchanged."""
    table = edges(meshes)
    face, following = meshes.face_of_corner(), next_in_row(meshes.face_offsets)
    of_face, here = meshes.mesh_of_face(), meshes.corner_points()
    # A point that stays is the same above and below, so that walls there end in an edge.
    is_lifted = has_length(shift)[:, 0]
    above = np.where(is_lifted, len(meshes.points) + np.arange(len(shift)), np.arange(len(shift)))[here]
    outwards = dot(shift.take(here, axis=0), area_vectors(meshes).take(face, axis=0))
    inwards = sum_rows(outwards, meshes.face_offsets) < 0.0

    moving = moves[of_face]
    corner, of_hole = in_rings(meshes, table.edge_of_corner)
    has_wall = moving[face[corner]] & table.is_boundary[table.edge_of_corner[corner]]
    corner, of_hole = corner[has_wall], of_hole[has_wall]
    walls = np.column_stack((here, here[following], above[following], above))[corner]
    # A reversed wall still begins with its edge on the face.
    turned = inwards[face[corner]]
    walls[turned] = walls[turned][:, [1, 0, 3, 2]]
    walls_of = of_face[face[corner]]

    forwards = np.arange(len(here))
    begin = meshes.face_offsets[:-1][face]
    # Turned over, a face begins with its first edge.
    backwards = begin + (1 + begin - forwards) % row_lengths(meshes.face_offsets)[face]
    towards_top, towards_bottom = (
        np.where(inwards[face], backwards, forwards),
        np.where(inwards[face], forwards, backwards),
    )
    solid = moving & any_rows(is_lifted[here], meshes.face_offsets)
    whole = Soup.of_faces(meshes, np.arange(meshes.num_faces))
    names = meshes.tags - meshes.roles
    wall_tags = names[face[corner]]
    if roles:
        wall_tags = wall_tags + np.where(of_hole, INNER_WALL, OUTER_WALL)
    parts = [
        replace(_reordered(whole, here, towards_bottom), tags=names + (BOTTOM if roles else 0)).where(solid),
        replace(_reordered(whole, above, towards_top), tags=names + (TOP if roles else 0)).where(solid),
        Soup(walls.ravel(), 4 * np.arange(len(walls) + 1), walls_of, face[corner], wall_tags),
        whole.where(~moving),
    ]
    faces = Soup.concatenate(parts)
    if not is_lifted[moves[meshes.mesh_of_point()]].all():
        faces = faces.without_repeats()
    points = np.concatenate((meshes.points, meshes.points + shift))
    return faces.meshes(points, np.tile(meshes.mesh_of_point(), 2), len(meshes))


def _reordered(faces: Soup, rows: Indices, corners: Indices) -> Soup:
    """Faces over other rows [C] of points, with their corners in another order, without the normals of a file."""
    data = faces.data and faces.data.without_normals().of_corners(corners)
    return replace(faces, rows=rows[corners], data=data)
