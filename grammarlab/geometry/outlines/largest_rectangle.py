"""The largest axis-parallel rectangle inside a polygon, exact up to rounding.

The polygon is cut into trapezoids by vertical lines through its corners. A rectangle inside it passes through a chain
of neighbouring trapezoids, in which its left side, right side and height are bounded by linear inequalities. For each
chain the largest rectangle is a quadratic programme in these three numbers: its solution has at least two of the
bounds active, so all pairs and triples of bounds are tried at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from grammarlab.geometry.meshes.mesh import Floats

_TOLERANCE = 1e-10
"""Tolerance of the bounds, relative to the size of the polygon."""

_TIE = 1e-9
"""Relative difference below which areas are equal."""

_NUM_BOUNDS = 13
_PAIRS = np.array(list(combinations(range(_NUM_BOUNDS), 2)))
_TRIPLES = np.array(list(combinations(range(_NUM_BOUNDS), 3)))

_LARGEST_BATCH = 64
"""Number of chains solved at a time; it bounds the memory."""


@dataclass(frozen=True, slots=True)
class _Trapezoid:
    """Between two vertical lines: the floor and ceiling at its left and right side."""

    floor: tuple[float, float]
    ceiling: tuple[float, float]


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


def largest_rectangle(rings: Sequence[Floats]) -> Floats | None:
    """Lower left and upper right corner [2, 2] of the largest axis-parallel rectangle in a polygon.

    Of equally large rectangles, the one whose centre is nearest to the polygon's centroid is used.

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
    nearest = min(candidates, key=lambda rectangle: round(float(np.hypot(*(rectangle.mean(axis=0) - centre))), 9))
    return nearest * size + low


def _centroid(rings: Sequence[Floats]) -> Floats:
    total, moment = 0.0, np.zeros(2)
    for ring in rings:
        following = np.roll(ring, -1, axis=0)
        cross = ring[:, 0] * following[:, 1] - following[:, 0] * ring[:, 1]
        total += float(cross.sum())
        moment += ((ring + following) * cross[:, None]).sum(axis=0)
    return moment / (3.0 * total) if total else rings[0].mean(axis=0)


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
    found = np.concatenate([_corners(bounds, limits), _along_edges(bounds, limits)], axis=1)
    slack = limits[:, None, :] - np.einsum("kcj,kbj->kcb", found, bounds)
    feasible = np.isfinite(found).all(axis=2) & (slack >= -_TOLERANCE).all(axis=2)
    area = np.where(feasible, (found[..., 1] - found[..., 0]) * found[..., 2], -np.inf)
    rectangles = []
    for k, c in enumerate(area.argmax(axis=1)):
        left, right, height = found[k, c]
        if area[k, c] > 0.0 and height > 0.0:
            floor = float((floors[k, :, :2] @ (left, right) + floors[k, :, 2]).max())
            rectangles.append(np.array([(left, floor), (right, floor + height)]))
    return rectangles


def _sides(chain: _Chain) -> tuple[Floats, Floats]:
    """Lower and upper bounds of a rectangle of a chain: [3, 3] factors of left and right, and constants."""
    result = []
    for constant, name in ((chain.floor, "floor"), (chain.ceiling, "ceiling")):
        rows = [(0.0, 0.0, constant)]
        for place, trapezoid, span in ((0, chain.first, chain.first_span), (1, chain.last, chain.last_span)):
            begin, end = getattr(trapezoid, name)
            slope = (end - begin) / (span[1] - span[0])
            row = [0.0, 0.0, begin - slope * span[0]]
            row[place] = slope
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
