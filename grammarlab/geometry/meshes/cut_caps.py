"""Faces that close the cuts of meshes, where the cut edges go around."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Flags, Floats, offsets_from_counts, row_of_value
from grammarlab.geometry.meshes.mesh import UNTAGGED, Indices, Soup
from grammarlab.geometry.meshes.ragged import cycles, next_in_row, sum_rows
from grammarlab.geometry.meshes.triangulate import contains, keyhole
from grammarlab.geometry.meshes.vectors import any_normal, cross, dot

_MEETING = 1e-6
"""Metres within which sheets meet on the plane of a cut."""


def caps(
    faces: Soup, points: Floats, is_on_plane: Flags, normals: Floats, rank: Indices, is_closed_mesh: Flags
) -> Soup:
    """Faces on a plane that close the cut edges of meshes, where these form closed lines.

    A cap begins at the edge of the first face that it closes. Holes of the section are joined to the outline by
    keyholes.

    Args:
        faces: the remaining faces of cut meshes.
        points: [P, 3] the table of points in metres.
        is_on_plane: [P] whether points lie on the plane that cut their mesh.
        normals: [M, 3] normal of the plane that cut each mesh, towards the kept side.
        rank: [M] `Soup.rank` of the caps of each mesh.
        is_closed_mesh: [M] whether each mesh was closed, so that all of its cut edges form closed lines.
    """
    rim = _closed_lines(_open_edges(_met(faces, points, is_on_plane, is_closed_mesh), is_on_plane), is_closed_mesh)
    if not len(rim.start):
        return faces.take(np.zeros(0, np.int64))
    plane = _plane_coordinates(points, rim, normals)
    order, offsets = cycles(_successors(rim, plane))
    mesh = rim.mesh[order[offsets[:-1]]]
    rows = rim.start[order]
    loops = Soup(rows, offsets, mesh, rank[mesh], np.full(len(mesh), UNTAGGED, np.int8))
    flat = plane[order]
    ahead = flat[next_in_row(offsets)]
    is_hole = sum_rows(flat[:, 0] * ahead[:, 1] - flat[:, 1] * ahead[:, 0], offsets) < 0.0
    return _with_holes(loops, flat, is_hole) if is_hole.any() else loops


def _met(faces: Soup, points: Floats, is_on_plane: Flags, is_closed_mesh: Flags) -> Soup:
    """Faces whose sheets, which have points of their own, share those on the plane where they meet there."""
    mesh = np.repeat(faces.mesh, np.diff(faces.offsets))
    corners = np.flatnonzero(is_on_plane[faces.rows] & ~is_closed_mesh[mesh])
    if not len(corners):
        return faces
    place = np.rint(points[faces.rows[corners]] / _MEETING)
    _, first, number = np.unique(
        np.column_stack((mesh[corners], place)), axis=0, return_index=True, return_inverse=True
    )
    rows = faces.rows.copy()
    rows[corners] = faces.rows[corners[first[number.ravel()]]]
    return replace(faces, rows=rows)


@dataclass(frozen=True, slots=True)
class _Rim:
    """E edges of caps, in the order of the faces that they close."""

    start: Indices
    """[E] row of the table of points."""
    end: Indices
    """[E] row of the table of points."""
    mesh: Indices
    """[E] the mesh of each edge."""


def _open_edges(faces: Soup, is_on_plane: Flags) -> _Rim:
    """Edges on the plane that faces pass more often in one direction than in the other, in the missing direction."""
    following = next_in_row(faces.offsets)
    on_plane = is_on_plane[faces.rows]
    corner = np.flatnonzero(on_plane & on_plane[following])
    start, end = faces.rows[corner], faces.rows[following[corner]]
    low, high = np.minimum(start, end), np.maximum(start, end)
    key = low * len(is_on_plane) + high
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1))
    balance = np.add.reduceat(np.sign(end - start)[order], first) if len(first) else first
    repeats = np.repeat(np.arange(len(first)), np.abs(balance))
    leader = order[first[repeats]]
    repeats, leader = repeats[np.argsort(leader, kind="stable")], np.sort(leader)
    upwards = balance[repeats] > 0
    mesh = faces.mesh[row_of_value(np.diff(faces.offsets))[corner[leader]]]
    low, high = low[leader], high[leader]
    return _Rim(np.where(upwards, high, low), np.where(upwards, low, high), mesh)


def _closed_lines(rim: _Rim, is_closed_mesh: Flags) -> _Rim:
    """The edges of closed meshes, and of open ones those of connected lines without ends."""
    is_open = ~is_closed_mesh[rim.mesh]
    if not is_open.any():
        return rim
    used, ends = np.unique(np.concatenate((rim.start, rim.end)), return_inverse=True)
    start, end = np.split(ends.ravel(), 2)
    has_end = np.bincount(start, minlength=len(used)) != np.bincount(end, minlength=len(used))
    if not has_end.any():
        return rim
    from scipy.sparse import csr_matrix  # noqa: PLC0415  # few grammars split open meshes
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    links = csr_matrix((np.ones(len(start)), (start, end)), shape=(len(used), len(used)))
    line = connected_components(links, directed=False)[1]
    is_broken = np.bincount(line[has_end], minlength=len(used)) > 0
    kept = ~(is_open & is_broken[line[start]])
    return _Rim(rim.start[kept], rim.end[kept], rim.mesh[kept])


def _plane_coordinates(points: Floats, rim: _Rim, normals: Floats) -> Floats:
    """[E, 2] the start of each edge in the plane, seen from outside the kept side."""
    outwards = -normals[rim.mesh]
    u = any_normal(outwards)
    start = points[rim.start]
    return np.stack((dot(start, u), dot(start, cross(outwards, u))), axis=1)


def _successors(rim: _Rim, plane: Floats) -> Indices:
    """[E] the edge that continues each edge, a permutation.

    Where two loops touch in a point, an edge is continued by the next one clockwise, so that loops do not cross.
    """
    count = len(rim.start)
    arriving, leaving = np.argsort(rim.end, kind="stable"), np.argsort(rim.start, kind="stable")
    successor = np.empty(count, np.int64)
    successor[arriving] = leaving
    touching = np.diff(rim.start[leaving]) == 0
    if not touching.any():
        return successor
    branches = np.unique(rim.start[leaving[1:][touching]])
    out = np.flatnonzero(np.isin(rim.start, branches))
    into = np.flatnonzero(np.isin(rim.end, branches))
    far = np.empty((count, 2))
    far[arriving] = plane[leaving]
    step = far - plane
    turn = np.concatenate((step[out], -step[into]))
    angle = np.arctan2(turn[:, 1], turn[:, 0])
    vertex = np.concatenate((rim.start[out], rim.end[into]))
    edge, is_out = np.concatenate((out, into)), np.arange(len(vertex)) < len(out)
    order = np.lexsort((is_out, angle, vertex))
    after = order[next_in_row(offsets_from_counts(np.unique(vertex, return_counts=True)[1]))]
    paired = is_out[order] & ~is_out[after]
    # Coincident edges can break the alternation of in and out: then any continuation keeps the mesh closed.
    if np.count_nonzero(paired) == len(out):
        successor[edge[after[paired]]] = edge[order[paired]]
    return successor


def _with_holes(loops: Soup, flat: Floats, is_hole: Flags) -> Soup:
    """Loops; clockwise ones are joined to the smallest loop around them."""
    rings = [flat[a:b] for a, b in zip(loops.offsets[:-1], loops.offsets[1:], strict=True)]
    rows = [loops.rows[a:b] for a, b in zip(loops.offsets[:-1], loops.offsets[1:], strict=True)]
    inside: dict[int, list[int]] = {}
    for mesh in np.unique(loops.mesh[is_hole]).tolist():
        outlines = np.flatnonzero((loops.mesh == mesh) & ~is_hole)
        for hole in np.flatnonzero((loops.mesh == mesh) & is_hole).tolist():
            around = [int(k) for k in outlines if contains(rings[k], rings[hole])]
            if around:
                smallest = min(around, key=lambda k: float(np.ptp(rings[k], axis=0).prod()))
                inside.setdefault(smallest, []).append(hole)
    for outline, holes in inside.items():
        members = [outline, *holes]
        path = keyhole([rings[k] for k in members])
        rows[outline] = np.concatenate([rows[k] for k in members])[path]
    joined = {hole for holes in inside.values() for hole in holes}
    selected = np.array([k for k in range(len(rows)) if k not in joined])
    counts = np.array([len(rows[k]) for k in selected])
    joined_rows = np.concatenate([rows[k] for k in selected])
    return Soup(
        joined_rows, offsets_from_counts(counts), loops.mesh[selected], loops.rank[selected], loops.tags[selected]
    )
