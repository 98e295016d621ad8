"""CGA's ``innerRectangle`` and ``innerRect``: the largest rectangle inside each face."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import offsets_from_counts
from grammarlab.geometry.meshes.mesh import Floats, Indices, Meshes
from grammarlab.geometry.meshes.planar import RELATIVE_TOLERANCE, Polygons, lay_flat, rectangle_sizes, regroup
from grammarlab.geometry.outlines.largest_rectangle import largest_rectangle
from grammarlab.geometry.outlines.patches import Patch, alike, fill, in_order, rings, stamp_patch
from grammarlab.geometry.outlines.setback import REMAINDER, Setback
from grammarlab.geometry.outlines.skeleton import Loop

Alignment = Literal["scope", "edge"]

RECTANGLE = 0
"""The group of inner rectangles."""

_LONG_ENOUGH = 0.25
"""Smallest length of an edge that gives rectangles a direction, as a share of the longest edge of its ring."""

_Seen = tuple[float, float, float, float]
"""A row-major matrix: the projections of the unit vectors along x and y of a face's frame."""


def inner_rectangle(meshes: Meshes, alignment: Alignment = "scope") -> Setback:
    """The largest rectangle inside each face, and what remains of the face.

    Rectangles are projected along the axis nearest to the face's normal, so on a slanted face they are
    parallelograms. Of equally large rectangles, the one nearest to the centroid of the face is used. A rectangle
    begins with the edge most parallel to the first edge of the face; a remainder, which may have several pieces,
    begins at its first corner in the order of the face. A face that is already an aligned rectangle has no
    remainder; a face without area, or with crossing edges, is its own remainder.

    Args:
        meshes: M meshes, in the axes of their scopes.
        alignment: whether sides are parallel to the axes, or one is parallel to an edge above a quarter of the longest
            edge of its ring.

    Returns:
        Rectangles as group `RECTANGLE`, the rest as `REMAINDER`, face by face.
    """
    polygons = lay_flat(meshes)
    seen = _projections(polygons)
    whole = _whole_rectangles(polygons, seen, alignment)
    batches: list[Meshes] = []
    rows: list[Indices] = []
    groups: list[Indices] = []
    fast = np.flatnonzero(whole)
    if len(fast):
        corners = (polygons.offsets[fast][:, None] + np.arange(4)).ravel()
        batches.append(Meshes.from_polygons(polygons.points[corners], np.full(len(fast), 4)))
        rows.append(fast)
        groups.append(np.full((len(fast), 1), RECTANGLE))
    slow = np.flatnonzero(~whole)
    keys: list[_Seen] = [(a, b, c, d) for a, b, c, d in seen[slow].reshape(-1, 4).tolist()]
    for members, xy, matrix in alike(polygons, slow, keys):
        patch, pieces = _inner_patch(xy, np.array(matrix).reshape(2, 2), alignment)
        batches.append(stamp_patch(polygons, members, patch))
        rows.append(members)
        groups.append(np.tile(np.array(pieces), (len(members), 1)))
    if not batches:
        return Setback(meshes, np.zeros(0, np.int64))
    order = np.argsort(np.concatenate(rows), kind="stable")
    flat = [row for group in groups for row in group]
    labels = np.concatenate([flat[i] for i in order.tolist()])
    return Setback(regroup(in_order(batches, rows), meshes.mesh_faces), labels)


def inner_rect(meshes: Meshes) -> Meshes:
    """CGA's older ``innerRect``: each face replaced by the largest rectangle along the axes; see `inner_rectangle`.

    Faces without such a rectangle are left out.
    """
    result = inner_rectangle(meshes, "scope")
    chosen = np.flatnonzero(result.group == RECTANGLE)
    pieces = result.meshes
    owner = pieces.mesh_of_face()[chosen]
    corners = pieces.face_offsets[chosen][:, None] + np.arange(4)
    points = pieces.points[pieces.corner_points()[corners]].reshape(-1, 3)
    per_mesh = np.bincount(owner, minlength=len(meshes))
    return Meshes.from_polygons(points, np.full(len(chosen), 4), per_mesh)


def _projections(polygons: Polygons) -> Floats:
    """[F, 2, 2] rows: x and y of each face's frame seen along the axis that its normal is nearest to."""
    normal = polygons.axes[:, 2]
    # Ties as in the selectors of `comp`: up before front before right.
    magnitude = np.abs(normal) + np.array([0.0, 2e-6, 1e-6])
    axis = magnitude.argmax(axis=1)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    row = np.arange(len(polygons))
    side = np.where(normal[row, axis] < 0.0, -1.0, 1.0)
    flat = polygons.axes[:, :2]
    return np.stack([flat[row, :, first] * side[:, None], flat[row, :, second]], axis=2)


def _whole_rectangles(polygons: Polygons, seen: Floats, alignment: Alignment) -> NDArray[np.bool_]:
    """[F] whether faces are their own inner rectangles: aligned rectangles that are not slanted."""
    rectangular, _ = rectangle_sizes(polygons)
    upright = np.abs(np.abs(seen[:, 0, 0] * seen[:, 1, 1] - seen[:, 0, 1] * seen[:, 1, 0]) - 1.0) <= RELATIVE_TOLERANCE
    aligned = np.abs(seen[:, 0]).min(axis=1) <= RELATIVE_TOLERANCE
    return rectangular & upright & (aligned if alignment == "scope" else True)


def _inner_patch(xy: Floats, seen: Floats, alignment: Alignment) -> tuple[Patch, list[int]]:
    """The rectangle and the remainder of a polygon, and the group of each piece."""
    loops = rings(xy)
    corners = tuple(corner for ring in loops for corner in ring)
    flat = np.stack([xy[:, 0] * seen[0, i] + xy[:, 1] * seen[1, i] for i in range(2)], axis=1)
    rectangle = _best(flat, loops, alignment) if _is_simple(flat, loops) else None
    if rectangle is None:
        whole = tuple(range(len(xy)))
        return Patch(xy, np.zeros(len(xy)), whole, (whole,), (0,)), [REMAINDER]
    known = flat[list(corners)]
    reach = 4.0 * RELATIVE_TOLERANCE * float(np.ptp(known, axis=0).max())
    pieces = [_snapped(rectangle, known, reach)]
    pieces += _remainder(flat, loops, rectangle, np.concatenate([known, pieces[0]]), reach)
    number: dict[tuple[float, float], int] = {}
    for place in map(tuple, np.concatenate([known, *pieces]).tolist()):
        number.setdefault(place, len(number))
    faces: list[Loop] = [tuple(number[place] for place in map(tuple, piece.tolist())) for piece in pieces]
    nodes = np.array(list(number))
    turned = float(seen[0, 0] * seen[1, 1] - seen[0, 1] * seen[1, 0])
    back = np.array([[seen[1, 1], -seen[0, 1]], [-seen[1, 0], seen[0, 0]]]) / turned
    nodes = np.stack([nodes[:, 0] * back[0, i] + nodes[:, 1] * back[1, i] for i in range(2)], axis=1)
    patch = Patch(nodes, np.zeros(len(nodes)), corners, tuple(faces), (0,) * len(faces))
    return patch, [RECTANGLE, *([REMAINDER] * (len(faces) - 1))]


def _area(flat: Floats, loops: list[list[int]]) -> shapely.Polygon:
    return shapely.Polygon(flat[loops[0]], [flat[ring] for ring in loops[1:]])


def _is_simple(flat: Floats, loops: list[list[int]]) -> bool:
    known = bool(loops) and bool(np.isfinite(flat).all()) and min(map(len, loops)) > 2
    return known and _area(flat, loops).is_valid


def _best(flat: Floats, loops: list[list[int]], alignment: Alignment) -> Floats | None:
    """[4, 2] the largest rectangle over all directions allowed, beginning along the first edge of the polygon."""
    best, largest = None, 0.0
    for x, y in _directions(flat, loops) if alignment == "edge" else [(1.0, 0.0)]:
        turn = np.array([[x, -y], [y, x]])
        found = largest_rectangle([_turned(flat[ring], turn) for ring in loops])
        if found is None:
            continue
        (left, low), (right, high) = found.tolist()
        if (right - left) * (high - low) > largest * (1.0 + RELATIVE_TOLERANCE):
            largest = (right - left) * (high - low)
            best = _turned(np.array([(left, low), (right, low), (right, high), (left, high)]), turn.T)
    if best is None:
        return None
    along = np.roll(best, -1, axis=0) - best
    first = flat[1] - flat[0]
    cosine = (along @ first) / np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-300)
    return np.roll(best, -int(np.argmax(np.round(cosine / max(float(np.hypot(*first)), 1e-300), 9))), axis=0)


def _turned(points: Floats, turn: Floats) -> Floats:
    return np.stack([points[:, 0] * turn[0, i] + points[:, 1] * turn[1, i] for i in range(2)], axis=1)


def _directions(flat: Floats, loops: list[list[int]]) -> list[tuple[float, float]]:
    """Unit vectors along the longer edges, each direction once, quarter turns being the same."""
    found: dict[tuple[float, float], tuple[float, float]] = {}
    for ring in loops:
        along = np.roll(flat[ring], -1, axis=0) - flat[ring]
        length = np.hypot(along[:, 0], along[:, 1])
        for (x, y), size in zip(along.tolist(), length.tolist(), strict=True):
            if size > _LONG_ENOUGH * length.max():
                quarters = [(x, y), (-y, x), (-x, -y), (y, -x)]
                way = next((a / size, b / size) for a, b in quarters if a > 0.0 and b >= 0.0)
                found.setdefault((round(way[0], 9), round(way[1], 9)), way)
    return list(found.values())


def _remainder(flat: Floats, loops: list[list[int]], rectangle: Floats, known: Floats, reach: float) -> list[Floats]:
    """[n, 2] remainder of a polygon without a rectangle, in the order of its corners.

    Args:
        flat: [C, 2] the corners of the polygon.
        loops: its rings.
        rectangle: [4, 2] the rectangle.
        known: [K, 2] corners of both; corners of the remainder within ``reach`` are moved to them.
        reach: in metres; a remainder must be wider.
    """
    left = shapely.difference(_area(flat, loops), shapely.Polygon(rectangle), grid_size=0.25 * reach)
    pieces: list[tuple[int, Floats]] = []
    for part in shapely.get_parts(left).tolist():
        if not isinstance(part, shapely.Polygon) or part.area <= reach * part.length:
            continue
        outlines = [
            _snapped(shapely.get_coordinates(ring)[:-1], known, reach) for ring in (part.exterior, *part.interiors)
        ]
        turned = [
            ring if shapely.LinearRing(ring).is_ccw == (i == 0) else ring[::-1] for i, ring in enumerate(outlines)
        ]
        places = np.concatenate(turned)
        bounds = offsets_from_counts(np.array([len(ring) for ring in turned], np.int64)).tolist()
        (walk,) = fill(places, [tuple(range(a, b)) for a, b in pairwise(bounds)])
        ranks = [_rank(places[node], known) for node in walk]
        first = int(np.argmin(ranks))
        pieces.append((ranks[first], places[[*walk[first:], *walk[:first]]]))
    return [piece for _, piece in sorted(pieces, key=lambda pair: pair[0])]


def _snapped(points: Floats, places: Floats, reach: float) -> Floats:
    """The points; those within reach of a known point are moved to it."""
    distance = np.abs(points[:, None] - places[None]).max(axis=2)
    nearest = distance.argmin(axis=1)
    near = distance[np.arange(len(points)), nearest] <= reach
    return np.where(near[:, None], places[nearest], points)


def _rank(place: Floats, known: Floats) -> int:
    """Index of the known point at this place; their number if there is none."""
    at = np.flatnonzero((known == place).all(axis=1))
    return int(at[0]) if len(at) else len(known)
