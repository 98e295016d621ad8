"""Buildings along an arc: the arc is found, the building is straightened, and results are bent back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.synthesis.mesh.surface import Surface

_MAX_VERTICAL = 0.1
"""Largest vertical component of the normal of a triangle in a wall."""
_DIRECTION_TOLERANCE = np.radians(2.0)
"""Largest angle between normals of one direction."""
_MIN_DIRECTIONS = 6
"""Least number of directions of walls along an arc, with differences below `_MAX_ANGLE`; a bay window has fewer."""
_MAX_ANGLE = np.radians(31.0)
"""Largest angle between neighbouring directions of walls along an arc."""
_MIN_SPREAD = np.radians(15.0)
"""Least angle around the centre that most walls along the arc cover: a straight wall fits any far centre."""
_MAX_MISS_RATIO = 0.06
"""Largest distance of the normal line of a wall from the centre of its arc, as a fraction of the radius."""
_MIN_AREA_SHARE = 0.3
"""Least share of the area of all walls that lies along the arc."""
_RADII = (3.0, 1_000.0)
"""Least and largest radius, metres."""
_BIN_M = 0.05
"""Bin width of distances from the centre, metres."""
_DISTANCES_M = (0.3, 0.1, 0.05, 0.05)
"""Distance from the arc of the walls that determine its position, metres, by round."""
_MAX_ROUNDS = 4
"""Number of fits of the centre to the walls that agree with it."""
_MIN_GAP = np.radians(30.0)
"""Least opening of an arc; a round tower is not an arc."""
_MIN_DISTANCE_RATIO = 0.2
"""Least distance of points from the centre, as a fraction of the radius."""


@dataclass(frozen=True, eq=False)
class Bend:
    """An arc about an upright axis; straight coordinates are x along it, y up, z away from the axis."""

    center: Floats
    """[2] x and z of the axis, metres."""
    radius: float
    """Radius of the wall that keeps its length, metres."""
    middle: float
    """Direction from the axis to the middle of the arc, radians from z towards x."""

    def straight(self, points: Floats) -> Floats:
        """[P, 3] points of the building, straightened."""
        x, z = (points[:, [0, 2]] - self.center).T
        angle = np.angle(np.exp(1j * (np.arctan2(x, z) - self.middle)))
        return np.stack([self.radius * angle, points[:, 1], np.hypot(x, z) - self.radius], axis=1)

    def bent(self, points: Floats) -> Floats:
        """[P, 3] straight points along the arc; its radius grows if they would cover more than the circle allows."""
        most = (2.0 * np.pi - _MIN_GAP) * self.radius
        radius = self.radius * max(1.0, float(np.ptp(points[:, 0])) / most)
        angle = self.middle + points[:, 0] / radius
        away = radius + points[:, 2]
        x, z = self.center[:, None] + away * np.stack([np.sin(angle), np.cos(angle)])
        return np.stack([x, points[:, 1], z], axis=1)


def bend_of(surface: Surface) -> Bend | None:
    """The arc along which most walls of a building lie; None for a building of straight walls.

    Lines through walls along their normals meet at the centre. Candidates are where lines of two walls do; that with
    the largest area of walls that agree is taken.

    Args:
        surface: surface of the upright building.
    """
    corners = surface.corners()
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2.0
    area = np.linalg.norm(normals, axis=1)
    wall = (area > 0.0) & (np.abs(normals[:, 1]) <= _MAX_VERTICAL * area)
    area, normals = area[wall], normals[wall][:, [0, 2]]
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    midpoints = corners[wall].mean(axis=1)[:, [0, 2]]
    # Normals may point inwards: a wall and its back have the same direction.
    axis = np.arctan2(normals[:, 0], normals[:, 1]) % np.pi
    sort = (axis / _DIRECTION_TOLERANCE).astype(np.int64)
    total = np.bincount(sort, area)
    common = np.flatnonzero(total >= 0.01 * area.sum())
    if len(common) < _MIN_DIRECTIONS:
        return None
    walls = [_largest_wall(midpoints, area, sort == direction) for direction in common]
    best, center = 0.0, np.zeros(2)
    for a, b in zip(*np.triu_indices(len(walls), 1), strict=True):
        candidate = _intersection(midpoints[walls[a]], normals[walls[a]], midpoints[walls[b]], normals[walls[b]])
        if candidate is None:
            continue
        agree = _agreeing(midpoints, normals, candidate)
        if float(area[agree].sum()) > best:
            best, center = float(area[agree].sum()), candidate
    for _ in range(_MAX_ROUNDS):
        agree = _agreeing(midpoints, normals, center)
        if not agree.any():
            return None
        center = _nearest_point(midpoints[agree], normals[agree], area[agree])
    agree = _agreeing(midpoints, normals, center)
    directions = np.unique(sort[agree])
    if float(area[agree].sum()) < _MIN_AREA_SHARE * area.sum() or _run(directions) < _MIN_DIRECTIONS:
        return None
    if _spread(midpoints[agree] - center, area[agree]) < _MIN_SPREAD:
        return None
    return _fitted_arc(surface.points, midpoints[agree], normals[agree], area[agree], sort[agree], center)


def _largest_wall(midpoints: Floats, area: Floats, is_member: np.ndarray) -> int:
    """The wall of largest area, of those with one direction."""
    return int(np.where(is_member, area, -1.0).argmax())


def _intersection(a: Floats, along: Floats, b: Floats, across: Floats) -> Floats | None:
    """Intersection of two lines, each through a point along a direction; None if they are parallel."""
    turn = along[0] * across[1] - along[1] * across[0]
    if abs(turn) < np.sin(_DIRECTION_TOLERANCE):
        return None
    step = b - a
    return a + along * (step[0] * across[1] - step[1] * across[0]) / turn


def _agreeing(midpoints: Floats, normals: Floats, center: Floats) -> np.ndarray:
    """[T] whether the normal line of each wall passes near a centre."""
    away = midpoints - center
    length = np.hypot(*away.T)
    miss = np.abs(away[:, 0] * normals[:, 1] - away[:, 1] * normals[:, 0])
    return (length >= _RADII[0]) & (length <= _RADII[1]) & (miss <= _MAX_MISS_RATIO * length)


def _nearest_point(midpoints: Floats, normals: Floats, area: Floats) -> Floats:
    """[2] the point with the least distances to the normal lines of walls."""
    across = np.stack([normals[:, 1], -normals[:, 0]], axis=1)
    root = np.sqrt(area)
    return np.linalg.lstsq(across * root[:, None], (across * midpoints).sum(axis=1) * root, rcond=None)[0]


def _run(directions: np.ndarray) -> int:
    """Number of consecutive directions with small differences."""
    is_gap = np.diff(directions) * _DIRECTION_TOLERANCE > _MAX_ANGLE
    return int(np.diff(np.concatenate([[-1], np.flatnonzero(is_gap), [len(directions) - 1]])).max(initial=0))


def _spread(away: Floats, area: Floats) -> float:
    """Angle around the centre that four fifths of the area of walls cover, radians."""
    angle = np.arctan2(*away.T)
    angle = np.angle(np.exp(1j * angle) / np.exp(1j * np.angle((area * np.exp(1j * angle)).sum())))
    order = np.argsort(angle)
    part = np.cumsum(area[order]) / area.sum()
    low, high = np.interp([0.1, 0.9], part, angle[order]).tolist()
    return high - low


def _fitted_arc(
    points: Floats, midpoints: Floats, normals: Floats, area: Floats, sort: np.ndarray, center: Floats
) -> Bend | None:
    """The arc that most walls touch; its centre and radius are refined by rounds.

    Of each direction only the wall nearest to the arc decides: walls have backs, and glass.
    """
    outward = normals * np.sign((normals * (midpoints - center)).sum(axis=1))[:, None]
    reach = (outward * midpoints).sum(axis=1)
    distance = reach - outward @ center
    bins = np.maximum(distance / _BIN_M, 0.0).astype(np.int64)
    smoothed_area = np.convolve(np.bincount(bins, area), [1.0, 1.0, 1.0], mode="same")
    radius = float((smoothed_area.argmax() + 0.5) * _BIN_M)
    for near in _DISTANCES_M:
        miss = np.abs(reach - outward @ center - radius)
        nearest = np.full(int(sort.max()) + 1, np.inf)
        np.minimum.at(nearest, sort, miss)
        is_near = (miss <= near) & (miss <= nearest[sort] + _BIN_M)
        if not is_near.any():
            return None
        # A wall touches the arc if its distance along its normal is that of the centre, plus a radius.
        root = np.sqrt(area[is_near])
        columns = np.column_stack([outward[is_near], np.ones(len(root))]) * root[:, None]
        solution = np.linalg.lstsq(columns, reach[is_near] * root, rcond=None)[0]
        center, radius = solution[:2], float(solution[2])
    x, z = (points[:, [0, 2]] - center).T
    angles = np.sort(np.arctan2(x, z))
    gaps = np.diff(np.append(angles, angles[0] + 2.0 * np.pi))
    widest = int(gaps.argmax())
    if (
        not _RADII[0] <= radius <= _RADII[1]
        or gaps[widest] < _MIN_GAP
        or np.hypot(x, z).min() < _MIN_DISTANCE_RATIO * radius
    ):
        return None
    return Bend(center, radius, float(angles[widest] + gaps[widest] / 2.0 + np.pi))
