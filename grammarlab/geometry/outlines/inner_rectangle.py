"""Largest rectangle inside each face, exact up to rounding: CGA's ``innerRectangle`` and ``innerRect``.

The polygon is cut into trapezoids by vertical lines through its corners. A rectangle inside it passes through a chain
of neighbouring trapezoids, in which its left side, right side and height are bounded by linear inequalities. For each
chain the largest rectangle is a quadratic programme in these three numbers: its solution has at least two of the
bounds active, so all pairs and triples of bounds are tried at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from operator import itemgetter
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats, offsets_from_counts
from grammarlab.geometry.meshes.mesh import Indices, Meshes
from grammarlab.geometry.meshes.planar import RELATIVE_TOLERANCE, Polygons, lay_flat, rectangle_sizes, regroup
from grammarlab.geometry.outlines.patches import Patch, alike, fill, in_order, rings, stamp_patch
from grammarlab.geometry.outlines.setback import REMAINDER, Setback
from grammarlab.geometry.outlines.straight_skeleton import Loop

_TOLERANCE = 1e-10
"""Tolerance of the bounds, relative to the size of the polygon."""
_TIE = 1e-9
"""Relative difference below which areas are equal."""
_NUM_BOUNDS = 13
_PAIRS = np.array(list(combinations(range(_NUM_BOUNDS), 2)))
_TRIPLES = np.array(list(combinations(range(_NUM_BOUNDS), 3)))
_LARGEST_BATCH = 64
"""Number of chains solved at a time; it bounds the memory."""
Alignment = Literal["scope", "edge"]
RECTANGLE = 0
"""The group of inner rectangles."""
_MIN_EDGE_SHARE = 0.25
"""Smallest length of an edge that gives rectangles a direction, as a share of the longest edge of its ring."""
_GRID = 1e-4
"""Distance in metres of the grid around the centroid of a face to which its corners move before rectangles along edges
are compared, as CityEngine does: a side is up to this much inside the face or, where it faces the centroid, outside. A
tolerance."""
_NEARBY = 2.0 * _GRID
"""Largest distance in metres from the sides of a rectangle on the grid to those of its hole in the remainder."""
_GRID_SLACK = 1e-5
"""Share of a grid cell below which a corner that rounding has put short of a grid line is on it."""
_Projection = tuple[float, float, float, float]
"""A row-major matrix: the projections of the unit vectors along x and y of a face's frame."""


def inner_rectangle(meshes: Meshes, alignment: Alignment = "scope") -> Setback:
    """The largest rectangle inside each face, and what remains of the face.

    Rectangles along edges have their sides on a grid of 0.1 mm, as CityEngine has: beside edges along them they are up
    to a cell short of these or, where they face the centroid, a cell beyond. The remainder leaves out the largest
    rectangle in the face within two cells of them. Faces too small for the grid have exact rectangles.

    Rectangles are projected along the axis nearest to the face's normal, so on a slanted face they are
    parallelograms. Of equally large rectangles, one along the longest edge is used, of these the one nearest to the
    centroid of the face, and of these the one nearest to the first of the longest edges. A rectangle begins with the
    edge most parallel to the first edge of the face; a remainder, which may have several pieces, begins at its first
    corner in the order of the face. A face that is already an aligned rectangle has no remainder; a face without area,
    or with crossing edges, is its own remainder.

    Args:
        meshes: M meshes, in the axes of their scopes.
        alignment: whether sides are parallel to the axes, or one is parallel to an edge above a quarter of the longest
            edge of its ring.

    Returns:
        Rectangles as group `RECTANGLE`, the rest as `REMAINDER`, face by face.
    """
    polygons = lay_flat(meshes)
    projections = _projections(polygons)
    whole = _whole_rectangles(polygons, projections, alignment)
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
    keys: list[_Projection] = [(a, b, c, d) for a, b, c, d in projections[slow].reshape(-1, 4).tolist()]
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


def largest_rectangle(rings: Sequence[Floats]) -> Floats | None:
    """Lower left and upper right corner [2, 2] of the largest axis-parallel rectangle in a polygon.

    Of equally large rectangles, the one whose centre is nearest to the polygon's centroid is used, then the lowest.

    Args:
        rings: [n, 2] the outline, then holes; in metres.

    Returns:
        The rectangle; None for a polygon without area.
    """
    points = np.concatenate(rings)
    low = points.min(axis=0)
    size = float(np.ptp(points, axis=0).max())
    if size <= 0.0 or not np.isfinite(size):
        return None
    unit = [(ring - low) / size for ring in rings]
    chains = sorted(_chains(unit), key=lambda chain: -chain.most)
    best: list[tuple[float, Floats]] = []
    largest = _TOLERANCE
    for start in range(0, len(chains), _LARGEST_BATCH):
        batch = [chain for chain in chains[start : start + _LARGEST_BATCH] if chain.most >= largest * (1.0 - _TIE)]
        if not batch:
            break
        for rectangle in _largest_in(batch):
            area = float(np.prod(rectangle[1] - rectangle[0]))
            largest = max(largest, area)
            best.append((area, rectangle))
    candidates = [rectangle for area, rectangle in best if area >= largest * (1.0 - _TIE)]
    if not candidates:
        return None
    centre = _centroid(unit)
    return min(candidates, key=lambda rectangle: _preference(rectangle, centre)) * size + low


def _preference(rectangle: Floats, centre: Floats) -> list[float]:
    """Numbers that are lowest, in this order, for the one to use of equally large rectangles.

    Along the longest edge of a face, the lowest top is nearest to this edge, which CityEngine prefers.
    """
    left, top = float(rectangle[0, 0]), float(rectangle[1, 1])
    distance = float(np.hypot(*(rectangle.mean(axis=0) - centre)))
    return [round(number, 9) for number in (distance, top, left)]


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


def _whole_rectangles(polygons: Polygons, projections: Floats, alignment: Alignment) -> NDArray[np.bool_]:
    """[F] whether faces are their own inner rectangles: aligned rectangles that are not slanted."""
    rectangular, _ = rectangle_sizes(polygons)
    upright = (
        np.abs(np.abs(projections[:, 0, 0] * projections[:, 1, 1] - projections[:, 0, 1] * projections[:, 1, 0]) - 1.0)
        <= RELATIVE_TOLERANCE
    )
    aligned = np.abs(projections[:, 0]).min(axis=1) <= RELATIVE_TOLERANCE
    return rectangular & upright & (aligned if alignment == "scope" else True)


def _inner_patch(xy: Floats, projection: Floats, alignment: Alignment) -> tuple[Patch, list[int]]:
    """The rectangle and the remainder of a polygon, and the group of each piece."""
    loops = rings(xy)
    corners = tuple(corner for ring in loops for corner in ring)
    flat = _transformed(xy, projection)
    rectangles = _largest_over_directions(flat, loops, alignment) if _is_simple(flat, loops) else None
    if rectangles is None:
        whole = tuple(range(len(xy)))
        return Patch(xy, np.zeros(len(xy)), whole, (whole,), (0,)), [REMAINDER]
    outline_points = flat[list(corners)]
    reach = 4.0 * RELATIVE_TOLERANCE * float(np.ptp(outline_points, axis=0).max())
    rectangle, hole = rectangles
    pieces = [_snapped(rectangle, outline_points, reach)]
    cut = _snapped(hole, outline_points, reach)
    pieces += _remainder(flat, loops, hole, np.concatenate([outline_points, cut]), reach)
    number: dict[tuple[float, float], int] = {}
    for point in map(tuple, np.concatenate([outline_points, *pieces]).tolist()):
        number.setdefault(point, len(number))
    faces: list[Loop] = [tuple(number[point] for point in map(tuple, piece.tolist())) for piece in pieces]
    nodes = np.array(list(number))
    determinant = float(projection[0, 0] * projection[1, 1] - projection[0, 1] * projection[1, 0])
    back = np.array([[projection[1, 1], -projection[0, 1]], [-projection[1, 0], projection[0, 0]]]) / determinant
    nodes = _transformed(nodes, back)
    patch = Patch(nodes, np.zeros(len(nodes)), corners, tuple(faces), (0,) * len(faces))
    return patch, [RECTANGLE, *([REMAINDER] * (len(faces) - 1))]


def _largest_over_directions(
    flat: Floats, loops: list[list[int]], alignment: Alignment
) -> tuple[Floats, Floats] | None:
    """[4, 2] the largest rectangle over all directions allowed, and the hole for it in the remainder."""
    best = None
    largest = 0.0
    for x, y in _directions(flat, loops) if alignment == "edge" else [(1.0, 0.0)]:
        turn = np.array([[x, -y], [y, x]])
        bounds = largest_rectangle([_transformed(flat[ring], turn) for ring in loops])
        if bounds is None:
            continue
        extent = float(np.prod(bounds[1] - bounds[0]))
        if extent > largest * (1.0 + RELATIVE_TOLERANCE):
            largest = extent
            best = bounds, turn
    if best is None:
        return None
    exact, turn = best
    first = flat[1] - flat[0]
    on_grid = _on_grid(flat, loops, turn) if alignment == "edge" else None
    whole = _transformed(_corners_of(exact), turn.T)
    rectangle, hole = on_grid or (whole, whole)
    return _from_first_edge(rectangle, first), _from_first_edge(hole, first)


def _on_grid(flat: Floats, loops: list[list[int]], turn: Floats) -> tuple[Floats, Floats] | None:
    """Corners [4, 2] of the largest rectangle on the grid, and of the largest one in the face at the same place.

    One search chooses among equally large rectangles: two might choose different ones.

    Args:
        flat: [C, 2] the corners of the polygon.
        loops: corner indices of the rings of the polygon.
        turn: [2, 2] matrix by which rows turn to the direction of the sides.
    """
    centre = _centroid([flat[ring] for ring in loops])
    bounds = largest_rectangle([_inwards(_transformed(flat[ring] - centre, turn)) for ring in loops])
    if bounds is None:
        return None
    rectangle, nearby = (
        _transformed(_corners_of(bounds + np.array([[-more], [more]])), turn.T) + centre for more in (0.0, _NEARBY)
    )
    parts = shapely.get_parts(shapely.intersection(_area(flat, loops), shapely.Polygon(nearby))).tolist()
    part = max(parts, key=shapely.area, default=None)
    if not isinstance(part, shapely.Polygon) or part.is_empty:
        return None
    place = [shapely.get_coordinates(ring)[:-1] - centre for ring in (part.exterior, *part.interiors)]
    hole = largest_rectangle([_transformed(ring, turn) for ring in place])
    return None if hole is None else (rectangle, _transformed(_corners_of(hole), turn.T) + centre)


def _inwards(points: Floats) -> Floats:
    """Points moved towards the axes to the grid."""
    cells = points / _GRID
    return np.sign(points) * np.floor(np.abs(cells) + _GRID_SLACK) * _GRID


def _corners_of(bounds: Floats) -> Floats:
    """[4, 2] corners, counter-clockwise, of a rectangle given by its lower left and its upper right one."""
    (left, low), (right, high) = bounds.tolist()
    return np.array([(left, low), (right, low), (right, high), (left, high)])


def _from_first_edge(rectangle: Floats, first: Floats) -> Floats:
    """The corners of a rectangle from the side on that is most parallel to the first edge [2] of its polygon."""
    along = np.roll(rectangle, -1, axis=0) - rectangle
    cosine = (along @ first) / np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-300)
    return np.roll(rectangle, -int(np.argmax(np.round(cosine / max(float(np.hypot(*first)), 1e-300), 9))), axis=0)


def _directions(flat: Floats, loops: list[list[int]]) -> list[tuple[float, float]]:
    """Unit vectors along the longer edges, the longest first; of those that differ by quarter turns the first."""
    directions: dict[tuple[float, float], tuple[float, tuple[float, float]]] = {}
    for ring in loops:
        along = np.roll(flat[ring], -1, axis=0) - flat[ring]
        length = np.hypot(along[:, 0], along[:, 1])
        for (x, y), size in zip(along.tolist(), length.tolist(), strict=True):
            if size > _MIN_EDGE_SHARE * length.max():
                quarters = [(x, y), (-y, x), (-x, -y), (y, -x)]
                name = next((round(a / size, 9), round(b / size, 9)) for a, b in quarters if a > 0.0 and b >= 0.0)
                edge = round(size, 9), (x / size, y / size)
                directions[name] = max(directions.get(name, edge), edge, key=itemgetter(0))
    return [direction for _, direction in sorted(directions.values(), key=itemgetter(0), reverse=True)]


@dataclass(frozen=True, slots=True)
class _Chain:
    """Trapezoids that a rectangle passes through: ranges of its beginning and end, and the bounds in between."""

    first: _Trapezoid
    last: _Trapezoid
    first_span: tuple[float, float]
    last_span: tuple[float, float]
    floor: float
    ceiling: float

    @property
    def most(self) -> float:
        """Upper bound on the area of rectangles in this chain."""
        tallest = max(self.first.ceiling) - min(self.first.floor)
        return (self.last_span[1] - self.first_span[0]) * min(self.ceiling - self.floor, tallest)


def _chains(rings: Sequence[Floats]) -> list[_Chain]:
    """The chains that may hold the largest rectangle."""
    lines, slabs = _slabs(rings)
    chains: list[_Chain] = []
    least = 0.0
    for i, slab in enumerate(slabs):
        span = lines[i], lines[i + 1]
        for first in slab:
            chains.append(_Chain(first, first, span, span, min(first.floor), max(first.ceiling)))
            # Trapezoids reached so far, with the bounds up to the line on their right.
            reached = [(first, -np.inf, np.inf)]
            for j in range(i + 1, len(slabs)):
                reached = [
                    (after, low, high)
                    for before, floor, ceiling in reached
                    for after in slabs[j]
                    if (high := min(ceiling, before.ceiling[1], after.ceiling[0]))
                    - (low := max(floor, before.floor[1], after.floor[0]))
                    > max(_TOLERANCE, least * (1.0 - _TIE) / (lines[-1] - lines[i]))
                ]
                for after, low, high in reached:
                    chains.append(_Chain(first, after, span, (lines[j], lines[j + 1]), low, high))
                    # The rectangle between the first and the last line within the chain.
                    least = max(least, (lines[j] - lines[i + 1]) * (high - low))
    return chains


@dataclass(frozen=True, slots=True)
class _Trapezoid:
    """Between two vertical lines: the floor and ceiling at its left and right side."""

    floor: tuple[float, float]
    ceiling: tuple[float, float]


def _slabs(rings: Sequence[Floats]) -> tuple[list[float], list[list[_Trapezoid]]]:
    """The positions of vertical lines through all corners, and the trapezoids between consecutive ones, upwards."""
    start = np.concatenate(rings)
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    lines = np.unique(start[:, 0])
    lines = lines[np.diff(lines, prepend=-1.0) > _TOLERANCE]
    slabs = []
    for left, right in pairwise(lines.tolist()):
        middle = 0.5 * (left + right)
        across = np.flatnonzero((start[:, 0] < middle) != (end[:, 0] < middle))
        slope = (end[across, 1] - start[across, 1]) / (end[across, 0] - start[across, 0])
        at_left = start[across, 1] + slope * (left - start[across, 0])
        at_right = start[across, 1] + slope * (right - start[across, 0])
        order = np.argsort(at_left + at_right, kind="stable").tolist()
        sides = [(float(at_left[i]), float(at_right[i])) for i in order]
        slabs.append([_Trapezoid(sides[i], sides[i + 1]) for i in range(0, len(sides) - 1, 2)])
    return lines.tolist(), slabs


def _largest_in(chains: Sequence[_Chain]) -> list[Floats]:
    """The largest rectangle of each chain, if it has one."""
    floors, ceilings = (np.stack(sides) for sides in zip(*(_sides(chain) for chain in chains), strict=True))
    # Bounds on (left, right, height): bounds @ unknowns <= limits.
    gaps = ceilings[:, :, None, :] - floors[:, None, :, :]
    height_rows = np.concatenate([-gaps[..., :2], np.ones((*gaps.shape[:3], 1))], axis=3).reshape(len(chains), 9, 3)
    spans = np.array([(*chain.first_span, *chain.last_span) for chain in chains])
    span_rows = np.array([(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0)], float)
    bounds = np.concatenate([height_rows, np.broadcast_to(span_rows, (len(chains), 4, 3))], axis=1)
    limits = np.concatenate([gaps[..., 2].reshape(len(chains), 9), spans * [-1, 1, -1, 1]], axis=1)
    candidates = np.concatenate([_corners(bounds, limits), _along_edges(bounds, limits)], axis=1)
    slack = limits[:, None, :] - np.einsum("kcj,kbj->kcb", candidates, bounds)
    feasible = np.isfinite(candidates).all(axis=2) & (slack >= -_TOLERANCE).all(axis=2)
    area = np.where(feasible, (candidates[..., 1] - candidates[..., 0]) * candidates[..., 2], -np.inf)
    rectangles = []
    for k, c in enumerate(area.argmax(axis=1)):
        left, right, height = candidates[k, c]
        if area[k, c] > 0.0 and height > 0.0:
            floor = float((floors[k, :, :2] @ (left, right) + floors[k, :, 2]).max())
            rectangles.append(np.array([(left, floor), (right, floor + height)]))
    return rectangles


def _sides(chain: _Chain) -> tuple[Floats, Floats]:
    """Lower and upper bounds of a rectangle of a chain: [3, 3] factors of left and right, and constants."""
    result = []
    for constant, name in ((chain.floor, "floor"), (chain.ceiling, "ceiling")):
        rows = [(0.0, 0.0, constant)]
        for column, trapezoid, span in ((0, chain.first, chain.first_span), (1, chain.last, chain.last_span)):
            begin, end = getattr(trapezoid, name)
            slope = (end - begin) / (span[1] - span[0])
            row = [0.0, 0.0, begin - slope * span[0]]
            row[column] = slope
            rows.append((row[0], row[1], row[2]))
        result.append(np.array(rows))
    return result[0], result[1]


def _corners(bounds: Floats, limits: Floats) -> Floats:
    """[K, T, 3] points where three bounds are active; not finite if they do not meet in a point."""
    a, b, c = (bounds[:, _TRIPLES[:, i]] for i in range(3))
    p, q, r = (limits[:, _TRIPLES[:, i], None] for i in range(3))
    bc, ca, ab = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    determinant = np.einsum("ktj,ktj->kt", a, bc)[..., None]
    point = p * bc + q * ca + r * ab
    return np.divide(point, determinant, out=np.full_like(point, np.nan), where=np.abs(determinant) > _TOLERANCE)


def _along_edges(bounds: Floats, limits: Floats) -> Floats:
    """[K, P, 3] points of largest area where two bounds are active; not finite if there is no maximum."""
    a, b = (bounds[:, _PAIRS[:, i]] for i in range(2))
    p, q = (limits[:, _PAIRS[:, i], None] for i in range(2))
    along = np.cross(a, b)
    square = np.einsum("kpj,kpj->kp", along, along)[..., None]
    start = p * np.cross(b, along) + q * np.cross(along, a)
    start = np.divide(start, square, out=np.full_like(start, np.nan), where=square > _TOLERANCE)
    width, widening = start[..., 1] - start[..., 0], along[..., 1] - along[..., 0]
    curvature = 2.0 * widening * along[..., 2]
    step = -(width * along[..., 2] + widening * start[..., 2])
    step = np.divide(step, curvature, out=np.full_like(step, np.nan), where=curvature < -_TOLERANCE)
    return start + step[..., None] * along


def _centroid(rings: Sequence[Floats]) -> Floats:
    total, moment = 0.0, np.zeros(2)
    for ring in rings:
        following = np.roll(ring, -1, axis=0)
        cross = ring[:, 0] * following[:, 1] - following[:, 0] * ring[:, 1]
        total += float(cross.sum())
        moment += ((ring + following) * cross[:, None]).sum(axis=0)
    return moment / (3.0 * total) if total else rings[0].mean(axis=0)


def _transformed(points: Floats, matrix: Floats) -> Floats:
    """[N, 2] points as rows times a matrix [2, 2]."""
    return np.stack([points[:, 0] * matrix[0, i] + points[:, 1] * matrix[1, i] for i in range(2)], axis=1)


def _is_simple(flat: Floats, loops: list[list[int]]) -> bool:
    is_valid = bool(loops) and bool(np.isfinite(flat).all()) and min(map(len, loops)) > 2
    return is_valid and _area(flat, loops).is_valid


def _area(flat: Floats, loops: list[list[int]]) -> shapely.Polygon:
    return shapely.Polygon(flat[loops[0]], [flat[ring] for ring in loops[1:]])


def _snapped(points: Floats, known_points: Floats, reach: float) -> Floats:
    """The points; those within reach of a known point are moved to it."""
    distance = np.abs(points[:, None] - known_points[None]).max(axis=2)
    nearest = distance.argmin(axis=1)
    near = distance[np.arange(len(points)), nearest] <= reach
    return np.where(near[:, None], known_points[nearest], points)


def _remainder(
    flat: Floats, loops: list[list[int]], rectangle: Floats, known_points: Floats, reach: float
) -> list[Floats]:
    """[n, 2] remainder of a polygon without a rectangle, in the order of its corners.

    Args:
        flat: [C, 2] the corners of the polygon.
        loops: corner indices of the rings of the polygon.
        rectangle: [4, 2] the rectangle.
        known_points: [K, 2] corners of both; corners of the remainder within ``reach`` are moved to them.
        reach: tolerance in metres; a remainder must be wider.
    """
    remainder = shapely.difference(_area(flat, loops), shapely.Polygon(rectangle), grid_size=0.25 * reach)
    pieces: list[tuple[int, Floats]] = []
    for part in shapely.get_parts(remainder).tolist():
        if not isinstance(part, shapely.Polygon) or part.area <= reach * part.length:
            continue
        outlines = [
            _snapped(shapely.get_coordinates(ring)[:-1], known_points, reach)
            for ring in (part.exterior, *part.interiors)
        ]
        turned = [
            ring if shapely.LinearRing(ring).is_ccw == (i == 0) else ring[::-1] for i, ring in enumerate(outlines)
        ]
        points = np.concatenate(turned)
        bounds = offsets_from_counts(np.array([len(ring) for ring in turned], np.int64)).tolist()
        (walk,) = fill(points, [tuple(range(a, b)) for a, b in pairwise(bounds)])
        ranks = [_rank(points[node], known_points) for node in walk]
        first = int(np.argmin(ranks))
        pieces.append((ranks[first], points[[*walk[first:], *walk[:first]]]))
    return [piece for _, piece in sorted(pieces, key=lambda pair: pair[0])]


def _rank(point: Floats, known_points: Floats) -> int:
    """Index of the known point at this place; their number if there is none."""
    matches = np.flatnonzero((known_points == point).all(axis=1))
    return int(matches[0]) if len(matches) else len(known_points)
