"""Directions of streets: a cross of two perpendicular directions at every point.

Crosses of several kinds are averaged by their fourth powers as complex numbers, in which a quarter turn is no turn
(G. Chen et al., "Interactive procedural street modeling", SIGGRAPH 2008, section 4).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.arrays import Floats

FieldKind: TypeAlias = Literal["grid", "radial", "mixed"]
"""``grid``: the same directions everywhere; ``radial``: to and around a centre; ``mixed``: radial near the centre,
along the outline near the outline, and a grid between them."""
FIELD_KINDS: tuple[FieldKind, ...] = ("grid", "radial", "mixed")
_CENTRE_SHARE = 0.3
"""Prior: distance from the centre at which its weight has fallen by a factor e, by the square root of the area."""
_OUTLINE_REACH = 120.0
"""Prior: distance from the outline in metres, a block or two, at which its weight has fallen by a factor e."""
_CENTRE_WEIGHT, _OUTLINE_WEIGHT = 4.0, 3.0
"""Prior: weights at the centre and on the outline; the grid has the weight 1 everywhere."""
_OUTLINE_STEP = 15.0
"""Tolerance in metres: windings of the outline that are smaller have no effect on directions."""


@dataclass(frozen=True, slots=True)
class DirectionField:
    """A cross of two perpendicular directions at every point of the plane."""

    kind: FieldKind = "grid"
    angle: float | None = None
    """Degrees from the east to one of the directions of the grid, counter-clockwise; None for the direction of the
    smallest box around the outline."""
    centre: tuple[float, float] | None = None
    """Centre in metres of the frame; None for the middle of the outline."""


@dataclass(frozen=True, slots=True, eq=False)
class Directions:
    """The directions of a field on an outline."""

    kind: FieldKind
    angle: float
    """Radians from the east to a direction of the grid."""
    centre: Floats
    """[2] metres."""
    reach: float
    """Distance in metres at which the weight of the centre has fallen by a factor e."""
    edges: Floats
    """[E, 2, 2] ends of the edges of the outline, of non-zero length."""

    @property
    def is_straight(self) -> bool:
        """Whether all streets are straight."""
        return self.kind == "grid"

    @property
    def has_centre(self) -> bool:
        """Whether streets meet at the centre, where there is no direction."""
        return self.kind != "grid"

    def at(self, points: Floats) -> Floats:
        """[n] radians from the east to one of the two directions at points [n, 2]."""
        if self.kind == "grid":
            return np.full(len(points), self.angle)
        away = points - self.centre
        radial = np.arctan2(away[:, 1], away[:, 0])
        if self.kind == "radial":
            return radial
        weight = _CENTRE_WEIGHT * np.exp(-((away**2).sum(axis=1)) / self.reach**2)
        distance, along = self._nearest_edge(points)
        edge_weight = _OUTLINE_WEIGHT * np.exp(-((distance / _OUTLINE_REACH) ** 2))
        cross = np.exp(4j * self.angle) + weight * np.exp(4j * radial) + edge_weight * np.exp(4j * along)
        return np.angle(cross) / 4

    def _nearest_edge(self, points: Floats) -> tuple[Floats, Floats]:
        """[n] distances from the nearest edge of the outline, and its direction in radians."""
        start, end = self.edges[:, 0], self.edges[:, 1]
        along = end - start
        offset = points[:, None] - start
        share = np.clip((offset * along).sum(axis=2) / (along**2).sum(axis=1), 0.0, 1.0)
        distance = np.linalg.norm(offset - share[:, :, None] * along, axis=2)
        nearest = distance.argmin(axis=1)
        rows = np.arange(len(points))
        return distance[rows, nearest], np.arctan2(along[nearest, 1], along[nearest, 0])


def directions_on(field: DirectionField, outline: shapely.Polygon) -> Directions:
    """The directions of a field on a valid outline in metres."""
    if field.angle is None:
        corners = shapely.get_coordinates(shapely.oriented_envelope(outline))
        sides = np.diff(corners[:3], axis=0)
        side = sides[np.linalg.norm(sides, axis=1).argmax()]
        angle = float(np.arctan2(side[1], side[0]))
    else:
        angle = float(np.radians(field.angle))
    middle = outline.centroid if outline.contains(outline.centroid) else outline.representative_point()
    place = field.centre if field.centre is not None else (middle.x, middle.y)
    centre = np.round(np.array(place, dtype=np.float64), 3)
    return Directions(field.kind, angle, centre, _CENTRE_SHARE * outline.area**0.5, _edges(outline))


def _edges(outline: shapely.Polygon) -> Floats:
    """[E, 2, 2] edges of an outline and of its holes, without small windings."""
    rings: list[NDArray[np.float64]] = []
    for ring in (outline.exterior, *outline.interiors):
        corners = shapely.get_coordinates(shapely.simplify(ring, _OUTLINE_STEP))
        rings.append(np.stack([corners[:-1], corners[1:]], axis=1))
    edges = np.concatenate(rings)
    return edges[(edges[:, 0] != edges[:, 1]).any(axis=1)]
