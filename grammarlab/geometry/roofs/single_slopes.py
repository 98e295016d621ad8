"""Pyramid, shed and single-ridge roofs: formulas over the corners of all faces, without a skeleton."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts, take_rows
from grammarlab.geometry.meshes.mesh import Floats, Indices, Meshes
from grammarlab.geometry.meshes.planar import RELATIVE_TOLERANCE, Polygons, lay_flat, regroup, signed_areas, sums_by_row

_FEWEST_WITH_HOLE = 8
"""Corners of a triangle with a triangular hole and the bridge between them."""


@dataclass(frozen=True, slots=True)
class _Faces:
    """Faces to be, of equal numbers of corners or ragged."""

    polygon: Indices
    """[K] the polygon of each face."""
    rank: Indices
    """[K] its index among the faces over that polygon."""
    counts: Indices
    """[K] corners of each."""
    corners: Indices
    """[S] points of all corners, one face after the other."""


@dataclass(frozen=True, slots=True)
class _Rims:
    """Faces of a batch as the base of solids: corners at one place are one point, bridges are not edges."""

    polygons: Polygons
    place: Indices
    """[C] the first corner of the same face at the same place."""
    is_edge: NDArray[np.bool_]
    """[C] whether the edge that leaves a corner is a real one, with length, and no side of a bridge."""
    is_flat: NDArray[np.bool_]
    """[F] whether faces have no area; they do not change."""


def pyramids(meshes: Meshes, amount: Floats, is_height: bool, balanced: bool = False) -> Meshes:
    """See `grammarlab.geometry.roofs.kinds.roof_pyramid`.

    Args:
        meshes: M meshes.
        amount: [F] heights in metres, or slopes (rise over run) of the triangles over the first edges.
        is_height: whether `amount` has heights.
        balanced: whether the tip is over the centre of gravity, not over the mean of the corners.
    """
    rims = _rims(lay_flat(meshes))
    polygons, face = rims.polygons, rims.polygons.face_of_corner()
    count = np.maximum(polygons.counts, 1)
    tip = sums_by_row(face, len(polygons), polygons.xy) / count[:, None]
    if balanced:
        tip = _centres_of_gravity(polygons, tip)
    # The first edge lies on the x axis of the polygon's frame.
    height = amount if is_height else amount * np.abs(tip[:, 1])
    tips = polygons.lift(np.arange(len(polygons)), tip[:, None], height[:, None])[:, 0]
    edge = np.flatnonzero(rims.is_edge & ~rims.is_flat[face])
    over = len(polygons.xy) + face[edge]
    triangles = np.stack([rims.place[edge], rims.place[polygons.next_corner()[edge]], over], axis=1)
    sides = _Faces(face[edge], edge - polygons.offsets[face[edge]], np.full(len(edge), 3), triangles.ravel())
    points = np.concatenate([polygons.points, tips])
    owner = np.concatenate([face, np.arange(len(polygons))])
    return regroup(_solids(points, owner, len(polygons), [sides, _undersides(rims)]), meshes.mesh_faces)


def _centres_of_gravity(polygons: Polygons, inside: Floats) -> Floats:
    """[F, 2] centres of gravity of polygons, from a point [F, 2] near each; that point for those without area."""
    face = polygons.face_of_corner()
    here = polygons.xy - inside[face]
    there = here[polygons.next_corner()]
    twice = here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]
    area = 0.5 * sums_by_row(face, len(polygons), twice[:, None])
    moment = sums_by_row(face, len(polygons), (here + there) * twice[:, None]) / 6.0
    return inside + np.divide(moment, area, out=np.zeros_like(moment), where=area > 0.0)


def sheds(meshes: Meshes, amount: Floats, is_height: bool, index: Indices) -> Meshes:
    """See `grammarlab.geometry.roofs.kinds.roof_shed`.

    Args:
        meshes: M meshes.
        amount: [F] heights in metres, or slopes (rise over run); negative ones fall from the edge.
        is_height: whether `amount` has heights.
        index: [F] the edge from which the slope rises, counted cyclically.
    """
    rims = _rims(lay_flat(meshes))
    polygons, face = rims.polygons, rims.polygons.face_of_corner()
    count = np.maximum(polygons.counts, 1)
    lead = np.minimum(polygons.offsets[:-1] + index % count, max(len(polygons.xy) - 1, 0))
    start = polygons.xy[lead]
    along = polygons.xy[polygons.next_corner()[lead]] - start
    length = np.hypot(along[:, 0], along[:, 1])
    along = np.where((length > 0.0)[:, None], along, [1.0, 0.0]) / np.where(length > 0.0, length, 1.0)[:, None]
    relative = polygons.xy - start[face]
    ahead = along[face, 0] * relative[:, 1] - along[face, 1] * relative[:, 0]
    nearest, farthest = np.full(len(polygons), np.inf), np.full(len(polygons), -np.inf)
    np.minimum.at(nearest, face, ahead)
    np.maximum.at(farthest, face, ahead)
    depth = np.where(polygons.counts > 0, farthest - nearest, 0.0)
    solid = depth > 0.0
    slope = np.where(solid, amount / np.where(solid, depth, 1.0), 0.0) if is_height else amount
    rise = slope[face]
    height = np.where(rise >= 0.0, rise * (ahead - nearest[face]), rise * (ahead - farthest[face]))
    return regroup(_prisms(rims, height, lead), meshes.mesh_faces)


def _prisms(rims: _Rims, height: Floats, lead: Indices) -> Meshes:
    """Solids from each face up to a slope.

    Args:
        rims: the faces.
        height: [C] of the slope over each corner, in metres, 0 or more.
        lead: [F] the corner at which the slope begins.
    """
    polygons, face = rims.polygons, rims.polygons.face_of_corner()
    highest = np.zeros(len(polygons))
    np.maximum.at(highest, face, height)
    rises = height[rims.place] > RELATIVE_TOLERANCE * highest[face]
    top = np.where(rises, len(polygons.xy) + rims.place, rims.place)
    following = polygons.next_corner()
    faces = [_undersides(rims), _slopes(rims, top, lead)]
    wall = rims.is_edge & ~rims.is_flat[face]
    for first, second in ((True, True), (True, False), (False, True)):
        edge = np.flatnonzero(wall & (rises == first) & (rises[following] == second))
        ring = [rims.place[edge], rims.place[following[edge]]]
        ring += [top[following[edge]]] if second else []
        ring += [top[edge]] if first else []
        corners = np.stack(ring, axis=1)
        rank = edge - polygons.offsets[face[edge]]
        faces.append(_Faces(face[edge], rank, np.full(len(edge), len(ring)), corners.ravel()))
    tops = polygons.points + polygons.axes[face, 2] * height[:, None]
    points = np.concatenate([polygons.points, tops])
    return _solids(points, np.concatenate([face, face]), len(polygons), faces)


def _slopes(rims: _Rims, top: Indices, lead: Indices) -> _Faces:
    """The faces lifted to the points ``top`` [C], each beginning at its corner ``lead`` [F]; none for flat faces."""
    polygons = rims.polygons
    chosen = np.flatnonzero(~rims.is_flat)
    where, offsets = take_rows(polygons.offsets, chosen)
    of = np.repeat(chosen, np.diff(offsets))
    first, count = polygons.offsets[of], polygons.counts[of]
    turned = first + (where - first + lead[of] - first) % np.maximum(count, 1)
    return _Faces(chosen, np.full(len(chosen), -1), np.diff(offsets), top[turned])


def _undersides(rims: _Rims) -> _Faces:
    """The faces reversed, with the same first corner; flat faces do not change."""
    polygons, face = rims.polygons, rims.polygons.face_of_corner()
    first, count = polygons.offsets[face], polygons.counts[face]
    index = np.arange(len(face)) - first
    turned = np.where(rims.is_flat[face], index, -index % np.maximum(count, 1))
    return _Faces(np.arange(len(polygons)), polygons.counts, polygons.counts, rims.place[first + turned])


def _rims(polygons: Polygons) -> _Rims:
    face, following = polygons.face_of_corner(), polygons.next_corner()
    place = np.arange(len(face))
    if (polygons.counts >= _FEWEST_WITH_HOLE).any():
        _, first, inverse = np.unique(
            np.column_stack([face, polygons.points]), axis=0, return_index=True, return_inverse=True
        )
        place = first[inverse.ravel()]
    is_edge = place != place[following]
    if (place != np.arange(len(face))).any():
        size = max(len(face), 1)
        forth, back = place * size + place[following], place[following] * size + place
        is_edge &= ~np.isin(forth, back)
    extent = polygons.extents()
    is_flat = ~(signed_areas(polygons) > RELATIVE_TOLERANCE * extent * extent)
    return _Rims(polygons, place, is_edge, is_flat)


def _solids(points: Floats, owner: Indices, num_solids: int, parts: list[_Faces]) -> Meshes:
    """One mesh for each polygon from faces over common points.

    Args:
        points: [P, 3] points; those that no face uses are left out.
        owner: [P] the polygon that each belongs to.
        num_solids: number of polygons.
        parts: the faces, in any order.
    """
    polygon = np.concatenate([part.polygon for part in parts])
    order = np.lexsort((np.concatenate([part.rank for part in parts]), polygon))
    corners = np.concatenate([part.corners for part in parts])
    where, face_offsets = take_rows(offsets_from_counts(np.concatenate([part.counts for part in parts])), order)
    corners = corners[where]
    used = np.zeros(len(points), np.bool_)
    used[corners] = True
    kept = np.flatnonzero(used)
    kept = kept[np.argsort(owner[kept], kind="stable")]
    mesh_points = offsets_from_counts(np.bincount(owner[kept], minlength=num_solids))
    number = np.zeros(len(points), np.int64)
    number[kept] = np.arange(len(kept)) - mesh_points[owner[kept]]
    mesh_faces = offsets_from_counts(np.bincount(polygon, minlength=num_solids))
    tags = np.zeros(len(order), np.int8)
    return Meshes(points[kept], number[corners], face_offsets, mesh_faces, mesh_points, tags)
