"""Patches: results of an operation on one polygon, computed once and copied to all equal polygons.

Operations on polygons come in two forms. If a formula gives the points (rectangles), all polygons of one topology
are one array. Otherwise an algorithm runs once for each distinct polygon and returns a `Patch`.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, offsets_from_counts
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.planar import Polygons
from grammarlab.geometry.meshes.triangulate import contains, keyhole
from grammarlab.geometry.outlines.straight_skeleton import Loop, loop_area, trace

T = TypeVar("T", bound=Hashable)


@dataclass(frozen=True, slots=True)
class Patch:
    """Faces over the plane of a polygon."""

    xy: Floats
    """[N, 2] nodes in the frame of the polygon, in metres."""
    height: Floats
    """[N] height of the nodes over the polygon, in metres."""
    corner: tuple[int, ...]
    """The corner of the polygon at each of the first nodes; the rest are new."""
    faces: tuple[Loop, ...]
    tags: tuple[int, ...]
    """Tags, one per face."""


def stamp(
    polygons: Polygons,
    rows: NDArray[np.integer],
    xy: Floats,
    height: Floats,
    corner: Sequence[int],
    faces: Sequence[Sequence[int]],
    tags: Sequence[int],
) -> Meshes:
    """K meshes of the same faces, on the polygons ``rows`` [K]. Nodes that no face uses are left out.

    Args:
        polygons: the polygons in their planes.
        rows: [K] the chosen polygons.
        xy: [K, N, 2] nodes in the frames of the polygons.
        height: [K, N] heights of the nodes over them.
        corner: the corner of the polygon at each of the first nodes, which have its exact position.
        faces: nodes of each face.
        tags: one for each face.
    """
    flat = [node for face in faces for node in face]
    used, renumbered = np.unique(np.array(flat, np.int64), return_inverse=True)
    points = polygons.lift(rows, xy[:, used], height[:, used])
    is_corner = used < len(corner)
    original = polygons.offsets[rows][:, None] + np.array(corner, np.int64)[used[is_corner]]
    points[:, is_corner] = polygons.points[original]
    count = len(rows)
    lengths = np.array([len(face) for face in faces], np.int64)
    return Meshes(
        points=points.reshape(-1, 3),
        corners=np.tile(renumbered, count),
        face_offsets=offsets_from_counts(np.tile(lengths, count)),
        mesh_faces=np.arange(count + 1, dtype=np.int64) * len(faces),
        mesh_points=np.arange(count + 1, dtype=np.int64) * len(used),
        tags=np.tile(np.array(tags, np.int8), count),
    )


def stamp_patch(polygons: Polygons, rows: Indices, patch: Patch) -> Meshes:
    """K meshes: a patch on the polygons ``rows`` [K], which are all equal."""
    xy = np.broadcast_to(patch.xy, (len(rows), *patch.xy.shape))
    height = np.broadcast_to(patch.height, (len(rows), *patch.height.shape))
    return stamp(polygons, rows, xy, height, patch.corner, patch.faces, patch.tags)


def alike(polygons: Polygons, rows: Indices, parameters: Sequence[T]) -> list[tuple[Indices, Floats, T]]:
    """Polygons grouped by equal patches.

    Args:
        polygons: the polygons in their planes.
        rows: [K] the chosen polygons.
        parameters: K values on which the patch depends besides the corners.

    Returns:
        For each distinct polygon and parameter the rows, the corners [n, 2] and the parameter.
    """
    groups: dict[tuple[bytes, T], list[int]] = {}
    for row, parameter in zip(rows.tolist(), parameters, strict=True):
        xy = polygons.xy[polygons.offsets[row] : polygons.offsets[row + 1]]
        groups.setdefault((xy.tobytes(), parameter), []).append(row)
    return [
        (np.array(group, np.int64), polygons.xy[polygons.offsets[group[0]] : polygons.offsets[group[0] + 1]], parameter)
        for (_, parameter), group in groups.items()
    ]


def in_order(batches: Sequence[Meshes], rows: Sequence[NDArray[np.integer]]) -> Meshes:
    """All meshes of several batches, sorted by the row [K] that each belongs to (each row once)."""
    if len(batches) == 1 and bool((np.diff(rows[0]) > 0).all()):
        return batches[0]
    return Meshes.concatenate(batches).take(np.argsort(np.concatenate(rows), kind="stable"))


def rings(xy: Floats) -> list[list[int]]:
    """Outline and holes of a polygon as corner indices, without the doubled edges of keyholes."""
    corner_at: dict[tuple[float, float], int] = {}
    first = [corner_at.setdefault((x, y), i) for i, (x, y) in enumerate(xy.tolist())]
    if len(corner_at) == len(first):
        return [first]
    arcs = list(zip(first, first[1:] + first[:1], strict=True))
    leaving = {arc: i for i, arc in enumerate(arcs)}
    loops = trace([arc for arc in arcs if arc[0] != arc[1]])
    # The corner at the beginning of a ring's edge: of two corners at one place, only one is.
    real = [[leaving[arc] for arc in zip(loop, loop[1:] + loop[:1], strict=True)] for loop in loops]
    return sorted(real, key=lambda ring: -loop_area(xy, ring))


def fill(xy: Floats, loops: Sequence[Loop]) -> list[Loop]:
    """Faces from outlines (counter-clockwise) and holes (clockwise), each hole joined to its outline by a keyhole."""
    outlines = [loop for loop in loops if loop_area(xy, loop) > 0.0]
    holes = [loop for loop in loops if loop_area(xy, loop) < 0.0]
    faces = []
    for outline in sorted(outlines, key=lambda loop: loop_area(xy, loop)):
        own_holes = [hole for hole in holes if len(outlines) == 1 or contains(xy[list(outline)], xy[list(hole)])]
        holes = [hole for hole in holes if hole not in own_holes]
        nodes = [node for ring in (outline, *own_holes) for node in ring]
        walk = keyhole([xy[list(ring)] for ring in (outline, *own_holes)]) if own_holes else range(len(outline))
        faces.append((outlines.index(outline), tuple(nodes[i] for i in walk)))
    return [face for _, face in sorted(faces)]
