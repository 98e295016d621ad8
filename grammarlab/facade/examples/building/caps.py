"""Faces on the planes where unlike units meet: what one has there and the other has not is closed.

The open edges of one seam plane, and pieces of the lines where it crosses others, form closed walks; every part of the
plane is covered as often as they wind around it. On a line there is one way to join given ends, so what two planes add
to their common line cancels: what was closed is closed again.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import mapbox_earcut
import numpy as np
import shapely
from scipy.spatial import cKDTree

from grammarlab.facade.examples.analysis.views import Plane
from grammarlab.facade.examples.building.surface import Floats, Ints, Surface, naked_edges, without_empty

_MOST_EDGES = 200_000
"""Of one plane."""


class _Walk(NamedTuple):
    """Directed segments of a plane."""

    start: Floats
    """[S, 2]"""
    end: Floats
    """[S, 2]"""
    times: Ints
    """[S] how often each is run along."""


def capped(surface: Surface, planes: Sequence[Plane], tolerance: float) -> Surface:
    """The surface with faces where seams are open.

    Args:
        surface: welded, without T-junctions.
        planes: of the seams.
        tolerance: metres within which a point lies on a plane.
    """
    places = {axis: np.unique([each.at for each in planes if each.axis == axis]) for axis in range(3)}
    for plane in planes:
        edges, times = naked_edges(surface)
        on = (np.abs(surface.points[:, plane.axis] - plane.at) <= tolerance)[edges].all(axis=1)
        if not on.any() or on.sum() > _MOST_EDGES:
            continue
        axes = [(plane.axis + 1) % 3, (plane.axis + 2) % 3]
        flat = surface.points[:, axes]
        walk = _closed(flat, edges[on], times[on], [places[axis] for axis in axes], tolerance)
        surface = _filled(surface, plane, walk, tolerance)
    return surface


def _closed(points: Floats, edges: Ints, times: Ints, lines: Sequence[Floats], tolerance: float) -> _Walk:
    """Open edges of a plane, with pieces of lines between their loose ends where these add up."""
    start, end, count = [points[edges[:, 0]]], [points[edges[:, 1]]], [times]
    loose = np.zeros(len(points), dtype=np.int64)
    np.add.at(loose, edges[:, 1], times)
    np.subtract.at(loose, edges[:, 0], times)
    for axis in (0, 1):
        ends = np.flatnonzero(loose)
        for at in lines[axis] if len(ends) else ():
            on = ends[np.abs(points[ends, axis] - at) <= tolerance]
            on = on[loose[on] != 0]
            if len(on) < 2 or loose[on].sum() != 0:
                continue
            on = on[np.argsort(points[on, 1 - axis], kind="stable")]
            # What is loose before a piece must flow along it.
            flow = np.cumsum(loose[on])[:-1]
            first, last = np.where(flow > 0, on[:-1], on[1:]), np.where(flow > 0, on[1:], on[:-1])
            used = flow != 0
            start.append(points[first[used]])
            end.append(points[last[used]])
            count.append(np.abs(flow[used]))
            loose[on] = 0
    return _Walk(np.concatenate(start), np.concatenate(end), np.concatenate(count))


def _filled(surface: Surface, plane: Plane, walk: _Walk, tolerance: float) -> Surface:
    faces = _faces(walk)
    winding = [_winding(shapely.get_coordinates(face.representative_point())[0], walk) for face in faces]
    corners, rows = [], []
    first = 0
    for face, turns in zip(faces, winding, strict=True):
        if turns == 0:
            continue
        rings = [shapely.get_coordinates(ring)[:-1] for ring in (face.exterior, *face.interiors)]
        flat = np.concatenate(rings)
        ends = np.cumsum([len(ring) for ring in rings]).astype(np.uint32)
        cut = mapbox_earcut.triangulate_float64(flat, ends).reshape(-1, 3).astype(np.int64)
        corner = flat[cut]
        ab, ac = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        anticlockwise = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0] > 0.0
        cut = np.where((anticlockwise == (turns < 0))[:, None], cut, cut[:, ::-1])
        corners.append(flat)
        rows += [cut + first] * abs(turns)
        first += len(flat)
    if not rows:
        return surface
    return _with_faces(surface, plane, np.concatenate(corners), np.concatenate(rows), tolerance)


def _faces(walk: _Walk) -> list[shapely.Polygon]:
    noded = shapely.unary_union(shapely.linestrings(np.stack([walk.start, walk.end], axis=1)))
    return list(shapely.get_parts(shapely.polygonize(shapely.get_parts(noded))))


def _winding(point: Floats, walk: _Walk) -> int:
    """How often directed segments run around a point, anticlockwise."""
    (x, y), a, b = point, walk.start, walk.end
    rising, falling = (a[:, 1] <= y) & (b[:, 1] > y), (b[:, 1] <= y) & (a[:, 1] > y)
    side = (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (x - a[:, 0]) * (b[:, 1] - a[:, 1])
    return int((walk.times * (rising & (side > 0.0))).sum() - (walk.times * (falling & (side < 0.0))).sum())


def _with_faces(surface: Surface, plane: Plane, flat: Floats, triangles: Ints, tolerance: float) -> Surface:
    """The surface and triangles of a plane, over its own points where these are, in the material that is nearest."""
    points = np.empty((len(flat), 3))
    points[:, plane.axis] = plane.at
    points[:, [(plane.axis + 1) % 3, (plane.axis + 2) % 3]] = flat
    tree = cKDTree(surface.points)
    distance, nearest = tree.query(points)
    known = distance <= tolerance
    place = np.where(known, nearest, len(surface.points) + np.cumsum(~known) - 1)
    of_point = np.zeros(len(surface.points), dtype=np.int64)
    of_point[surface.triangles.ravel()] = np.repeat(surface.material, 3)
    return without_empty(
        Surface(
            np.concatenate([surface.points, points[~known]]),
            np.concatenate([surface.triangles, place[triangles]]),
            np.concatenate([surface.material, of_point[nearest[triangles[:, 0]]]]),
        )
    )
