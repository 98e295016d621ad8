"""Parts of meshes between planes: what ``split`` and trim planes leave.

Closed meshes stay closed: where a plane cuts them they get a cap. A face in the plane of a cut goes to one side only:
to the one that it bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import row_of_value, take_rows
from grammarlab.geometry.caps import caps
from grammarlab.geometry.cut import cut
from grammarlab.geometry.measure import area_vectors, is_closed
from grammarlab.geometry.mesh import Floats, Indices, Meshes
from grammarlab.geometry.ragged import max_rows
from grammarlab.geometry.soup import Soup
from grammarlab.geometry.vectors import dot

Flags = NDArray[np.bool_]

TOLERANCE = 1e-9
"""Points this close to a plane, as a share of the size of their mesh, lie on it."""


@dataclass(frozen=True, slots=True)
class _Side:
    """One side of slabs: the low ends or the high ends."""

    level: Floats
    """[N] where the plane stands along the axis."""
    sign: float
    """1 where the kept side lies above the plane, -1 where below."""
    is_cut: Flags
    """[N] whether the mesh reaches beyond the plane."""
    lost_first: Flags
    """[N] whether the first face of the mesh lies beyond the plane."""


def slabs(meshes: Meshes, mesh: NDArray[np.integer], axis: int, low: Floats, high: Floats) -> Meshes:
    """The parts of meshes between two planes across an axis.

    Slabs that share a plane share nothing else: volumes of the parts of a closed mesh and areas of the parts of an open
    one add up to those of the whole. A face across the axis at the very end of a mesh belongs to the slab at that end.

    Args:
        meshes: where the parts come from.
        mesh: [N] the mesh that each part is cut from.
        axis: 0, 1 or 2, the axis that runs from `low` to `high`.
        low: [N] where each part begins, in metres.
        high: [N] where it ends, at least `low`.

    Returns:
        N meshes with their points where they were; some may be empty. Faces keep their order; caps come last, or
        first where the first face was cut away.
    """
    bottom, top = meshes.bounds()
    tolerance = TOLERANCE * (top - bottom).max(axis=1, initial=0.0)
    parts, sides = _culled(meshes, mesh, axis, (low, high), (bottom[:, axis], top[:, axis], tolerance))
    closed = np.zeros(len(meshes), bool)
    was_cut = np.zeros(len(meshes), bool)
    was_cut[mesh[sides[0].is_cut | sides[1].is_cut]] = True
    # One face alone is never closed: the common case needs no look at its edges.
    candidates = np.flatnonzero(was_cut & (np.diff(meshes.mesh_faces) > 1))
    closed[candidates] = is_closed(meshes.take(candidates))

    for side in sides:
        if not side.is_cut.any():
            continue
        of_point = parts.mesh_of_point()
        level = side.level[of_point]
        distance = side.sign * (parts.points[:, axis] - level)
        distance[~side.is_cut[of_point]] = np.inf
        on_plane = np.abs(distance) <= tolerance[mesh][of_point]
        distance[on_plane] = 0.0
        parts.points[on_plane, axis] = level[on_plane]
        normals = np.zeros((len(mesh), 3))
        normals[:, axis] = side.sign
        keep_flat = np.ones(parts.num_faces, bool)
        kept = _kept(parts, distance, normals, keep_flat, closed[mesh] & side.is_cut, side.lost_first)
        parts = kept.meshes
        # Interpolation misses the plane by a last bit; parts must end where their neighbours begin.
        parts.points[kept.is_new, axis] = side.level[parts.mesh_of_point()[kept.is_new]]
    return parts


def halfspace(meshes: Meshes, normals: Floats, offsets: Floats) -> Meshes:
    """The part of each mesh behind a plane: where ``normal . point <= offset``.

    A face in the plane stays when it looks along the normal.

    Args:
        meshes: M meshes.
        normals: [M, 3] unit normals of the planes, out of the side that is kept.
        offsets: [M] metres from the origin along the normals.
    """
    bottom, top = meshes.bounds()
    tolerance = TOLERANCE * (top - bottom).max(axis=1, initial=0.0)
    of_point = meshes.mesh_of_point()
    distance = offsets[of_point] - dot(meshes.points, normals[of_point])
    distance[np.abs(distance) <= tolerance[of_point]] = 0.0
    looks_out = dot(area_vectors(meshes), normals[meshes.mesh_of_face()]) > 0.0
    lost_first = np.zeros(len(meshes), bool)
    filled = np.diff(meshes.mesh_faces) > 0
    reach = max_rows(distance[meshes.corner_points()], meshes.face_offsets, -np.inf)
    lost_first[filled] = reach[meshes.mesh_faces[:-1][filled]] <= 0.0
    return _kept(meshes, distance, -normals, looks_out, is_closed(meshes), lost_first).meshes


def _culled(
    meshes: Meshes,
    mesh: NDArray[np.integer],
    axis: int,
    slab: tuple[Floats, Floats],
    extent: tuple[Floats, Floats, Floats],
) -> tuple[Meshes, tuple[_Side, _Side]]:
    """N meshes of the faces that reach into each slab, untouched, and what lies beyond either end.

    Args:
        meshes: as in `slabs`.
        mesh: as in `slabs`.
        axis: as in `slabs`.
        slab: [N] where each slab begins and ends.
        extent: [M] where each mesh begins and ends along the axis, and the tolerance.
    """
    height = meshes.points[meshes.corner_points(), axis]
    face_low = -max_rows(-height, meshes.face_offsets, -np.inf)
    face_high = max_rows(height, meshes.face_offsets, -np.inf)
    low, high = slab
    slack = extent[2][mesh]
    sides = []
    first = np.minimum(meshes.mesh_faces[:-1][mesh], max(meshes.num_faces - 1, 0))
    for level, sign, reach, face_reach in ((low, 1.0, extent[0], face_high), (high, -1.0, extent[1], face_low)):
        is_cut = sign * (level - reach[mesh]) > slack
        lost_first = is_cut & (sign * (face_reach[first] - level) <= slack) if meshes.num_faces else is_cut
        sides.append(_Side(level, sign, is_cut, lost_first))

    face, part_faces = take_rows(meshes.mesh_faces, mesh)
    part = row_of_value(np.diff(part_faces))
    at, of_mesh = slack[part], mesh[part]
    begins, ends = face_low[face], face_high[face]
    enters = (ends > low[part] + at) & (begins < high[part] - at) & (high - low > slack)[part]
    flat = np.flatnonzero(ends - begins <= at)
    if len(flat):
        rises = area_vectors(meshes)[face[flat], axis] < 0.0
        f, m, p = face[flat], of_mesh[flat], part[flat]
        enters[flat] = _owns_flat(face_low[f], rises, (low[p], high[p]), tuple(column[m] for column in extent))
    chosen = np.flatnonzero(enters)
    return _faces_of_parts(meshes, mesh, face[chosen], part[chosen]), (sides[0], sides[1])


def _owns_flat(height: Floats, rises: Flags, slab: tuple[Floats, Floats], extent: tuple[Floats, ...]) -> Flags:
    """[K] whether slabs own faces that lie across the axis.

    Args:
        height: [K] where the face lies.
        rises: [K] whether what the face bounds lies above it.
        slab: [K] where the slab begins and ends.
        extent: [K] where the mesh begins and ends, and the tolerance.
    """
    begin, end, slack = extent
    above = (height <= begin + slack) | (rises & (height < end - slack))
    at_low, at_high = np.abs(height - slab[0]) <= slack, np.abs(height - slab[1]) <= slack
    between = (height > slab[0]) & (height < slab[1]) & ~at_low & ~at_high
    return between | (at_low & above) | (at_high & ~above)


def _faces_of_parts(meshes: Meshes, mesh: NDArray[np.integer], face: Indices, part: Indices) -> Meshes:
    """N meshes, part i made of some faces of mesh ``mesh[i]``."""
    where, offsets = take_rows(meshes.face_offsets, face)
    part_of_corner = np.repeat(part, np.diff(offsets))
    candidates, candidate_offsets = take_rows(meshes.mesh_points, mesh)
    rows = meshes.corners[where] + candidate_offsets[part_of_corner]
    faces = Soup(rows, offsets, part, np.arange(len(face)), meshes.tags[face])
    return faces.meshes(meshes.points[candidates], row_of_value(np.diff(candidate_offsets)), len(mesh))[0]


@dataclass(frozen=True, slots=True)
class _Kept:
    meshes: Meshes
    is_new: Flags
    """[P] which of its points were made where edges pass the plane."""


def _kept(
    meshes: Meshes, distance: Floats, normals: Floats, keep_flat: Flags, capped: Flags, lost_first: Flags
) -> _Kept:
    """The parts of meshes where the distance is positive.

    Args:
        meshes: M meshes.
        distance: [P] of each point from the plane of its mesh, exactly zero on the plane.
        normals: [M, 3] of the planes, into the kept side.
        keep_flat: [F] whether a face stays if it lies in the plane.
        capped: [M] which meshes get caps where they are open at the plane.
        lost_first: [M] where the caps come first.
    """
    at_corner = distance[meshes.corner_points()]
    nearest = -max_rows(-at_corner, meshes.face_offsets, -np.inf)
    furthest = max_rows(at_corner, meshes.face_offsets, -np.inf)
    is_crossing = (nearest < 0.0) & (furthest > 0.0)
    stays = ((nearest >= 0.0) & (furthest > 0.0)) | ((nearest == 0.0) & (furthest == 0.0) & keep_flat)
    piece = cut(Soup.of_faces(meshes, np.flatnonzero(is_crossing)), meshes.points, distance, normals)
    faces = Soup.together([Soup.of_faces(meshes, np.flatnonzero(stays)), piece.faces])
    points = np.concatenate((meshes.points, piece.points))
    mesh_of_point = np.concatenate((meshes.mesh_of_point(), piece.mesh_of_point))
    if capped.any():
        on_plane = np.concatenate((distance == 0.0, np.ones(len(piece.points), bool)))
        place = np.where(lost_first, -1, meshes.num_faces)
        faces = Soup.together(
            [faces, caps(faces.take(np.flatnonzero(capped[faces.mesh])), points, on_plane, normals, place)]
        )
    result, used = faces.meshes(points, mesh_of_point, len(meshes))
    return _Kept(result, used >= len(meshes.points))
