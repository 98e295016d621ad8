"""Buildings along an arc, laid out straight: a street's curve is found, taken away, and given back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.mesh.surface import Floats, Surface

_STEEP = 0.1
"""Vertical part of a normal up to which a triangle belongs to a wall."""
_DIRECTION = np.radians(2.0)
"""Normals this near to each other count as one direction."""
_LEAST_DIRECTIONS = 6
"""Directions of walls along an arc, less than `_FARTHEST` from each other; a bay window has fewer."""
_FARTHEST = np.radians(31.0)
_LEAST_SPREAD = np.radians(15.0)
"""Around the centre that most walls along the arc cover, at least: a straight wall agrees with any far centre."""
_MISS = 0.06
"""Part of a radius by which the line through a wall, along its normal, misses the centre of its arc."""
_LEAST_PART = 0.3
"""Of the area of all walls that those along the arc have."""
_RADII = (3.0, 1_000.0)
"""Metres."""
_BIN = 0.05
"""Metres of distances from the centre that are counted together."""
_NEAR = (0.3, 0.1, 0.05, 0.05)
"""Metres from the arc within which walls decide where it lies, one round after the other."""
_ROUNDS = 4
_GAP = np.radians(30.0)
"""An arc leaves as much of a circle open, at least; a round tower is none."""
_NEAREST = 0.2
"""Part of the radius that all points are away from the centre."""


@dataclass(frozen=True, eq=False)
class Bend:
    """An arc about an upright axis; straight coordinates are x along it, y up, z away from the axis."""

    center: Floats
    """[2] x and z of the axis, in metres."""
    radius: float
    """Metres, of the wall that keeps its length."""
    middle: float
    """Direction from the axis to the middle of the arc, as radians from z towards x."""

    def straight(self, points: Floats) -> Floats:
        """[P, 3] points of the building laid out straight."""
        x, z = (points[:, [0, 2]] - self.center).T
        angle = np.angle(np.exp(1j * (np.arctan2(x, z) - self.middle)))
        return np.stack([self.radius * angle, points[:, 1], np.hypot(x, z) - self.radius], axis=1)

    def bent(self, points: Floats) -> Floats:
        """[P, 3] straight points along the arc; it is made wider where they would go around more than it can hold."""
        most = (2.0 * np.pi - _GAP) * self.radius
        radius = self.radius * max(1.0, float(np.ptp(points[:, 0])) / most)
        angle = self.middle + points[:, 0] / radius
        away = radius + points[:, 2]
        x, z = self.center[:, None] + away * np.stack([np.sin(angle), np.cos(angle)])
        return np.stack([x, points[:, 1], z], axis=1)


def bend_of(surface: Surface) -> Bend | None:
    """The arc that most walls of a building stand along; None for a building of straight walls.

    Lines through walls along their normals meet at the centre. Candidates are where lines of two walls do; that with
    the largest area of walls that agree is taken.

    Args:
        surface: upright.
    """
    corners = surface.corners()
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2.0
    area = np.linalg.norm(normals, axis=1)
    wall = (area > 0.0) & (np.abs(normals[:, 1]) <= _STEEP * area)
    area, normals = area[wall], normals[wall][:, [0, 2]]
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    places = corners[wall].mean(axis=1)[:, [0, 2]]
    # Normals may point inwards: a wall and its back have one direction.
    axis = np.arctan2(normals[:, 0], normals[:, 1]) % np.pi
    sort = (axis / _DIRECTION).astype(np.int64)
    total = np.bincount(sort, area)
    common = np.flatnonzero(total >= 0.01 * area.sum())
    if len(common) < _LEAST_DIRECTIONS:
        return None
    ones = [_facade(places, area, sort == each) for each in common]
    best, center = 0.0, np.zeros(2)
    for one, other in zip(*np.triu_indices(len(ones), 1), strict=True):
        found = _meeting(places[ones[one]], normals[ones[one]], places[ones[other]], normals[ones[other]])
        if found is None:
            continue
        agree = _agreeing(places, normals, found)
        if float(area[agree].sum()) > best:
            best, center = float(area[agree].sum()), found
    for _ in range(_ROUNDS):
        agree = _agreeing(places, normals, center)
        if not agree.any():
            return None
        center = _least_missed(places[agree], normals[agree], area[agree])
    agree = _agreeing(places, normals, center)
    directions = np.unique(sort[agree])
    if float(area[agree].sum()) < _LEAST_PART * area.sum() or _run(directions) < _LEAST_DIRECTIONS:
        return None
    if _spread(places[agree] - center, area[agree]) < _LEAST_SPREAD:
        return None
    return _fitted(surface.points, places[agree], normals[agree], area[agree], sort[agree], center)


def _facade(places: Floats, area: Floats, own: np.ndarray) -> int:
    """Of walls of one direction, the one of largest area."""
    return int(np.where(own, area, -1.0).argmax())


def _meeting(one: Floats, along: Floats, other: Floats, across: Floats) -> Floats | None:
    """Where two lines meet, each through a point along a direction; None where they are parallel."""
    turn = along[0] * across[1] - along[1] * across[0]
    if abs(turn) < np.sin(_DIRECTION):
        return None
    step = other - one
    return one + along * (step[0] * across[1] - step[1] * across[0]) / turn


def _agreeing(places: Floats, normals: Floats, center: Floats) -> np.ndarray:
    """[T] walls whose line along the normal goes through a centre, about."""
    away = places - center
    length = np.hypot(*away.T)
    miss = np.abs(away[:, 0] * normals[:, 1] - away[:, 1] * normals[:, 0])
    return (length >= _RADII[0]) & (length <= _RADII[1]) & (miss <= _MISS * length)


def _least_missed(places: Floats, normals: Floats, area: Floats) -> Floats:
    """[2] the point that lines through walls, along their normals, miss least."""
    across = np.stack([normals[:, 1], -normals[:, 0]], axis=1)
    root = np.sqrt(area)
    return np.linalg.lstsq(across * root[:, None], (across * places).sum(axis=1) * root, rcond=None)[0]


def _run(directions: np.ndarray) -> int:
    """How many directions follow each other, none far from the next."""
    far = np.diff(directions) * _DIRECTION > _FARTHEST
    return int(np.diff(np.concatenate([[-1], np.flatnonzero(far), [len(directions) - 1]])).max(initial=0))


def _spread(away: Floats, area: Floats) -> float:
    """Radians around the centre that four fifths of the area of walls cover."""
    angle = np.arctan2(*away.T)
    angle = np.angle(np.exp(1j * angle) / np.exp(1j * np.angle((area * np.exp(1j * angle)).sum())))
    order = np.argsort(angle)
    part = np.cumsum(area[order]) / area.sum()
    low, high = np.interp([0.1, 0.9], part, angle[order]).tolist()
    return high - low


def _fitted(
    points: Floats, places: Floats, normals: Floats, area: Floats, sort: np.ndarray, center: Floats
) -> Bend | None:
    """The arc that most walls touch; its centre and radius move until they touch it best.

    Of each direction only the wall nearest to the arc decides: walls have backs, and glass.
    """
    outward = normals * np.sign((normals * (places - center)).sum(axis=1))[:, None]
    reach = (outward * places).sum(axis=1)
    distance = reach - outward @ center
    bins = np.maximum(distance / _BIN, 0.0).astype(np.int64)
    often = np.convolve(np.bincount(bins, area), [1.0, 1.0, 1.0], mode="same")
    radius = float((often.argmax() + 0.5) * _BIN)
    for near in _NEAR:
        miss = np.abs(reach - outward @ center - radius)
        nearest = np.full(int(sort.max()) + 1, np.inf)
        np.minimum.at(nearest, sort, miss)
        own = (miss <= near) & (miss <= nearest[sort] + _BIN)
        if not own.any():
            return None
        # A wall touches the arc when it is as far along its normal as the centre, and a radius.
        root = np.sqrt(area[own])
        columns = np.column_stack([outward[own], np.ones(len(root))]) * root[:, None]
        found = np.linalg.lstsq(columns, reach[own] * root, rcond=None)[0]
        center, radius = found[:2], float(found[2])
    x, z = (points[:, [0, 2]] - center).T
    angles = np.sort(np.arctan2(x, z))
    gaps = np.diff(np.append(angles, angles[0] + 2.0 * np.pi))
    widest = int(gaps.argmax())
    if not _RADII[0] <= radius <= _RADII[1] or gaps[widest] < _GAP or np.hypot(x, z).min() < _NEAREST * radius:
        return None
    return Bend(center, radius, float(angles[widest] + gaps[widest] / 2.0 + np.pi))
