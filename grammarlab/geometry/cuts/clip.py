"""Parts of meshes between planes, for ``split`` and trim planes.

Closed meshes stay closed: a cap closes each cut. A face in the plane of a cut goes to one side only:
to the side that it bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import row_of_value, take_rows
from grammarlab.geometry.cuts.caps import caps
from grammarlab.geometry.cuts.cut import cut
from grammarlab.geometry.meshes.measure import area_vectors, is_closed
from grammarlab.geometry.meshes.mesh import Floats, Indices, Meshes
from grammarlab.geometry.meshes.ragged import max_rows
from grammarlab.geometry.meshes.soup import Soup

Flags = NDArray[np.bool_]

TOLERANCE = 1e-9
"""Largest distance of points on a plane, as a share of the largest coordinate of their mesh."""


@dataclass(frozen=True, slots=True)
class _Extent:
    """Beginnings and ends of faces and meshes along an axis."""

    face_low: Floats
    """[F]"""
    face_high: Floats
    """[F]"""
    low: Floats
    """[M]"""
    high: Floats
    """[M]"""
    slack: Floats
    """[M] distance below which points lie on a plane."""


@dataclass(frozen=True, slots=True)
class _Side:
    """One side of slabs: their low ends or their high ends."""

    level: Floats
    """[N] position of the plane along the axis."""
    sign: float
    """1 where the kept side lies above the plane, -1 where below."""
    is_cut: Flags
    """[N] whether the mesh reaches beyond the plane."""
    crosses: Flags
    """[K] whether faces that reach into the slabs reach beyond the plane."""
    lost_first: Flags
    """[N] whether the first face of the mesh lies beyond the plane."""


def slabs(meshes: Meshes, mesh: NDArray[np.integer], axis: int, low: Floats, high: Floats) -> Meshes:
    """The parts of meshes between two planes across an axis.

    Parts do not overlap: volumes of the parts of a closed mesh, and areas of the parts of an open
    one, add up to those of the whole. A face across the axis at the end of a mesh belongs to the slab at that end.

    Args:
        meshes: the meshes to cut.
        mesh: [N] the mesh that each part is cut from.
        axis: 0, 1 or 2, the axis that runs from `low` to `high`.
        low: [N] beginning of each part, in metres.
        high: [N] end of each part, at least `low`.

    Returns:
        N meshes with unmoved points; some may be empty. Faces keep their order; caps come last, or
        first if the first face was cut away.
    """
    extent = _extent(meshes, axis)
    face, part = _faces_within(meshes, mesh, axis, low, high, extent)
    sides = [_side(meshes, mesh, extent, face, part, level, sign) for level, sign in ((low, 1.0), (high, -1.0))]
    faces, points, owner = _gathered(meshes, mesh, face, part)
    capped = _closed_ones(meshes, mesh, sides[0].is_cut | sides[1].is_cut)

    cuts = []
    for side in sides:
        if not side.is_cut.any():
            continue
        distance = side.sign * (points[:, axis] - side.level.take(owner))
        on_plane = np.abs(distance) <= extent.slack[mesh].take(owner)
        distance[on_plane] = 0.0
        points[on_plane, axis] = side.level.take(owner[on_plane])
        normals = np.zeros((len(mesh), 3))
        normals[:, axis] = side.sign
        # `place` is still the number of the face within the slabs that a piece was cut from.
        is_crossing = side.crosses.take(faces.place)
        result = cut(faces.where(is_crossing), points, distance, normals)
        # Interpolation can differ from the plane in the last bit, but parts must end where their neighbours begin.
        result.points[:, axis] = side.level.take(result.mesh_of_point)
        points, owner = np.concatenate((points, result.points)), np.concatenate((owner, result.mesh_of_point))
        faces = Soup.together([faces.where(~is_crossing), result.faces])
        cuts.append((side, np.append(on_plane, np.ones(len(result.points), bool)), normals))

    closing = []
    for side, on_plane, normals in cuts:
        needs_cap = capped & side.is_cut
        if needs_cap.any():
            flags = np.append(on_plane, np.zeros(len(points) - len(on_plane), bool))
            place = np.where(side.lost_first, -1, len(face))
            closing.append(caps(faces.where(needs_cap.take(faces.mesh)), points, flags, normals, place))
    return Soup.together([faces, *closing]).meshes(points, owner, len(mesh))


def _slack(meshes: Meshes) -> Floats:
    """[M] distance below which points of a mesh lie on a plane."""
    x, y, z = np.abs(meshes.points.T)
    return TOLERANCE * max_rows(np.maximum(np.maximum(x, y), z), meshes.mesh_points, 0.0)


def _extent(meshes: Meshes, axis: int) -> _Extent:
    height = meshes.points[:, axis].take(meshes.corner_points())
    face_low = -max_rows(-height, meshes.face_offsets, -np.inf)
    face_high = max_rows(height, meshes.face_offsets, -np.inf)
    low = -max_rows(-face_low, meshes.mesh_faces, -np.inf)
    high = max_rows(face_high, meshes.mesh_faces, -np.inf)
    return _Extent(face_low, face_high, low, high, _slack(meshes))


def _faces_within(
    meshes: Meshes, mesh: NDArray[np.integer], axis: int, low: Floats, high: Floats, extent: _Extent
) -> tuple[Indices, Indices]:
    """Faces [K] that reach into slabs, and the slab of each, ascending."""
    face, part_faces = take_rows(meshes.mesh_faces, mesh)
    part = row_of_value(np.diff(part_faces))
    begin, end = extent.face_low.take(face), extent.face_high.take(face)
    slack = extent.slack[mesh]
    is_thick = high - low > slack
    # A slab of thickness 0 has no inside.
    first, last = np.where(is_thick, low + slack, np.inf), np.where(is_thick, high - slack, -np.inf)
    within = (end > first.take(part)) & (begin < last.take(part))
    flat = np.flatnonzero(end - begin <= slack.take(part))
    if len(flat):
        rises = area_vectors(meshes)[face[flat], axis] < 0.0
        within[flat] = _owns_flat(begin[flat], rises, mesh[part[flat]], low[part[flat]], high[part[flat]], extent)
    chosen = np.flatnonzero(within)
    return face.take(chosen), part.take(chosen)


def _owns_flat(
    height: Floats, rises: Flags, mesh: NDArray[np.integer], low: Floats, high: Floats, extent: _Extent
) -> Flags:
    """[K] whether slabs own faces that lie across the axis.

    Args:
        height: [K] position of the face.
        rises: [K] whether the face bounds the region above it.
        mesh: [K] the mesh of the face.
        low: [K] beginning of the slab.
        high: [K] end of the slab.
        extent: extent of the meshes.
    """
    slack = extent.slack[mesh]
    above = (height <= extent.low[mesh] + slack) | (rises & (height < extent.high[mesh] - slack))
    at_low, at_high = np.abs(height - low) <= slack, np.abs(height - high) <= slack
    between = (height > low) & (height < high) & ~at_low & ~at_high
    return between | (at_low & above) | (at_high & ~above)


def _side(
    meshes: Meshes,
    mesh: NDArray[np.integer],
    extent: _Extent,
    face: Indices,
    part: Indices,
    level: Floats,
    sign: float,
) -> _Side:
    """The side beyond the low (sign 1) or high (sign -1) ends of slabs."""
    near, far = (extent.face_low, extent.face_high) if sign > 0.0 else (extent.face_high, extent.face_low)
    reach = extent.low if sign > 0.0 else extent.high
    slack = extent.slack[mesh]
    is_cut = sign * (level - reach[mesh]) > slack
    is_flat = extent.face_high - extent.face_low <= extent.slack[meshes.mesh_of_face()]
    crosses = (sign * (level.take(part) - near.take(face)) > slack.take(part)) & ~is_flat.take(face)
    lost_first = is_cut.copy()
    filled = np.flatnonzero(np.diff(meshes.mesh_faces)[mesh] > 0)
    first = meshes.mesh_faces[:-1][mesh[filled]]
    lost_first[filled] &= sign * (far[first] - level[filled]) <= slack[filled]
    return _Side(level, sign, is_cut, crosses, lost_first)


def _gathered(meshes: Meshes, mesh: NDArray[np.integer], face: Indices, part: Indices) -> tuple[Soup, Floats, Indices]:
    """Faces of parts over a table in which every part has its own copy of the points, and the owners of those points.

    The place of each face is its number in `face`.
    """
    where, offsets = take_rows(meshes.face_offsets, face)
    candidates, candidate_offsets = take_rows(meshes.mesh_points, mesh)
    base = candidate_offsets[:-1].take(part)
    rows = meshes.corners.take(where) + np.repeat(base, np.diff(offsets))
    soup = Soup(rows, offsets, part, np.arange(len(face)), meshes.tags.take(face))
    return soup, meshes.points.take(candidates, axis=0), row_of_value(np.diff(candidate_offsets))


def _closed_ones(meshes: Meshes, mesh: NDArray[np.integer], is_cut: Flags) -> Flags:
    """[N] whether a part is cut from a closed mesh; false for uncut parts."""
    is_candidate = np.zeros(len(meshes), bool)
    is_candidate[mesh[is_cut]] = True
    # A single face is never closed: this common case does not need its edges.
    candidates = np.flatnonzero(is_candidate & (np.diff(meshes.mesh_faces) > 1))
    closed = np.zeros(len(meshes), bool)
    closed[candidates] = is_closed(meshes.take(candidates))
    return closed[mesh]
