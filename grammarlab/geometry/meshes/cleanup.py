"""Meshes with fewer points and faces of nearly the same surface: CGA's ``cleanupGeometry``."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Flags, Floats, offsets_from_counts
from grammarlab.geometry.meshes.edges import Edges
from grammarlab.geometry.meshes.edges import edges as edge_table
from grammarlab.geometry.meshes.flat_patches import faces_within, loops_of
from grammarlab.geometry.meshes.measure import area_vectors, face_areas
from grammarlab.geometry.meshes.mesh import NUM_ROLES, Indices, Meshes, Soup
from grammarlab.geometry.meshes.ragged import next_in_row
from grammarlab.geometry.meshes.vectors import dot, norm, unit

Components = Literal["all", "edges", "faces", "vertices"]

SAME_POINT = 1e-6
"""Tolerance in metres: points up to this distance are one, so that faces that meet stay together."""
_MOST_METRES, _MOST_DEGREES = 1.0, 10.0
"""Distance of points that become one, and angle that counts as straight or flat, at the tolerance 1."""
_STRAIGHT = 1e-6
"""Angle in radians that counts as straight or flat at the tolerance 0."""


def cleaned(mesh: Meshes, components: Components, tolerance: float) -> Meshes:
    """A mesh without components that it does not need; the same one if nothing would be left.

    Args:
        mesh: a single mesh, points in metres.
        components: what is removed after near points are one: ``edges`` between flat faces (if both faces have the
            same tags, material and texture coordinates there), ``vertices`` on straight lines, ``faces`` without area
            and repeated ones, or ``all`` of these.
        tolerance: 0..1; at 1, points up to 1 m apart are one, and angles up to 10 degrees straight.
    """
    share = float(np.clip(tolerance, 0.0, 1.0))
    angle = max(_STRAIGHT, np.radians(share * _MOST_DEGREES))
    faces = Soup.of_faces(mesh, np.arange(mesh.num_faces))
    near = merged_points(mesh.points, max(SAME_POINT, share * _MOST_METRES))
    faces = replace(faces, rows=near[faces.rows]).without_repeats()
    if components in ("all", "faces"):
        faces = faces.where(_are_needed(faces, mesh.points, (share * _MOST_METRES) ** 2))
    if components in ("all", "edges"):
        faces = _without_flat_edges(faces, mesh.points, angle)
    if components in ("all", "vertices"):
        faces = _without_straight_corners(faces, mesh.points, angle)
    if len(faces) == 0:
        return mesh
    return faces.meshes(mesh.points, np.zeros(len(mesh.points), np.int64), 1)


def merged_points(points: Floats, distance: float) -> Indices:
    """[P] the first point that is not merged itself and at most this far away."""
    from scipy.spatial import KDTree  # noqa: PLC0415

    result = np.arange(len(points))
    tree = KDTree(points)
    is_merged = np.zeros(len(points), bool)
    # Points that stay are farther apart than the distance, so few balls overlap, however dense the points are.
    for point in np.flatnonzero(tree.query_ball_point(points, distance, return_length=True) > 1).tolist():
        if not is_merged[point]:
            others = np.array(tree.query_ball_point(points[point], distance))
            others = others[~is_merged[others] & (others > point)]
            result[others], is_merged[others] = point, True
    return result


def _are_needed(faces: Soup, points: Floats, area: float) -> Flags:
    """[F] whether faces have more area, in square metres, and are not on the corners of an earlier face."""
    flags = face_areas(faces.as_one_mesh(points)) > max(area, SAME_POINT**2)
    corners: set[frozenset[int]] = set()
    for number, (begin, end) in enumerate(zip(faces.offsets[:-1].tolist(), faces.offsets[1:].tolist(), strict=True)):
        key = frozenset(faces.rows[begin:end].tolist())
        flags[number] &= key not in corners
        corners.add(key)
    return flags


def _without_flat_edges(faces: Soup, points: Floats, angle: float) -> Soup:
    """Faces in which flat neighbours are one: at the place of the first, from its first corner on."""
    whole = faces.as_one_mesh(points)
    groups = _flat_groups(faces, whole, edge_table(whole), angle)
    following, normals = next_in_row(faces.offsets), area_vectors(whole)
    corners: list[list[int]] = []
    sources: list[int] = []
    for group in groups:
        own = [range(faces.offsets[face], faces.offsets[face + 1]) for face in group]
        if len(group) == 1:
            corners.append(list(own[0]))
            sources.append(group[0])
            continue
        leaving = {(int(faces.rows[c]), int(faces.rows[following[c]])): c for part in own for c in part}
        passing = {int(faces.rows[c]): c for part in reversed(own) for c in part}
        for outline in faces_within(points, loops_of(list(leaving)), normals[group].sum(axis=0)):
            ring = outline.tolist()
            ends = [*ring[1:], ring[0]]
            chosen = [leaving.get(edge, passing[edge[0]]) for edge in zip(ring, ends, strict=True)]
            start = chosen.index(own[0][0]) if own[0][0] in chosen else 0
            corners.append(chosen[start:] + chosen[:start])
            sources.append(group[0])
    where = np.array([corner for face in corners for corner in face], dtype=np.int64)
    source = np.array(sources, dtype=np.int64)
    merged = np.isin(source, [group[0] for group in groups if len(group) > 1])
    return Soup(
        rows=faces.rows[where],
        offsets=offsets_from_counts(np.array([len(face) for face in corners], dtype=np.int64)),
        mesh=faces.mesh[source],
        rank=faces.rank[source],
        tags=np.where(merged, faces.tags[source] // NUM_ROLES * NUM_ROLES, faces.tags[source]),
        data=faces.data and faces.data.take(where, source),
    )


def _flat_groups(faces: Soup, whole: Meshes, table: Edges, angle: float) -> list[list[int]]:
    """Faces that are connected by flat edges, ascending, groups in the order of their first faces."""
    parent = list(range(len(faces)))
    normals = area_vectors(whole)
    least = np.cos(angle)

    def root(face: int) -> int:
        while parent[face] != face:
            parent[face] = parent[parent[face]]
            face = parent[face]
        return face

    for first, second in table.faces[_are_removable(faces, whole, table)].tolist():
        one, other = sorted((root(first), root(second)))
        length = np.linalg.norm(normals[one]) * np.linalg.norm(normals[other])
        if one != other and length > 0.0 and normals[one] @ normals[other] >= least * length * (1.0 - 1e-12):
            parent[other] = one
            normals[one] += normals[other]
    groups: dict[int, list[int]] = defaultdict(list)
    for face in range(len(faces)):
        groups[root(face)].append(face)
    return list(groups.values())


def _are_removable(faces: Soup, whole: Meshes, table: Edges) -> NDArray[np.bool_]:
    """[E] whether edges are between two faces in opposite directions that nothing but their planes may distinguish."""
    first, second = table.faces.T
    names = faces.tags // NUM_ROLES
    flags = (table.num_faces == 2) & (names[first] == names[second])
    rows, following = whole.corner_points(), next_in_row(faces.offsets)
    other = np.full(len(table), -1)
    corner = np.flatnonzero(table.edge_of_corner >= 0)
    corner = corner[table.corner[table.edge_of_corner[corner]] != corner]
    other[table.edge_of_corner[corner]] = corner
    flags &= rows[other] == table.end
    if faces.data is not None:
        flags &= faces.data.slots[first] == faces.data.slots[second]
        coordinates = faces.data.values[:, 3:]
        for here, there in ((table.corner, following[other]), (following[table.corner], other)):
            flags &= np.isclose(coordinates[here], coordinates[there], atol=1e-6, equal_nan=True).all(axis=1)
    return flags


def _without_straight_corners(faces: Soup, points: Floats, angle: float) -> Soup:
    """Faces without points at which all their outlines, one or two, go straight on."""
    following = next_in_row(faces.offsets)
    before = np.empty(len(following), np.int64)
    before[following] = np.arange(len(following))
    here = points[faces.rows]
    arriving, leaving = unit(here - here[before]), unit(here[following] - here)
    is_straight = (dot(arriving, leaving) > 0.0) & (norm(np.cross(arriving, leaving)) <= np.sin(angle))
    uses = np.bincount(faces.rows, minlength=len(points))
    bends = np.bincount(faces.rows, ~is_straight, minlength=len(points))
    goes = ((uses <= 2) & (bends == 0.0))[faces.rows]
    # Of a face that would vanish, as of a fine circle, all corners stay.
    counts = np.add.reduceat(~goes, faces.offsets[:-1]) if len(faces) else goes
    stays = ~goes | np.repeat(counts < 3, np.diff(faces.offsets))
    kept = np.flatnonzero(stays)
    sizes = np.add.reduceat(stays, faces.offsets[:-1]) if len(faces) else counts
    return replace(
        faces,
        rows=faces.rows[kept],
        offsets=offsets_from_counts(sizes.astype(np.int64)),
        data=faces.data and faces.data.of_corners(kept),
    )
