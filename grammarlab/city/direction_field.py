"""Directions of streets: a cross of two perpendicular directions at every point.

Crosses of several kinds are averaged by their fourth powers as complex numbers, in which a quarter turn is no turn
(G. Chen et al., "Interactive procedural street modeling", SIGGRAPH 2008, section 4).
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace
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
_LATTICE_STEP = 25.0
"""Tolerance: metres between the points at which directions of the outline are computed."""
_MAX_POINTS = 200_000
"""Budget: number of these points."""
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
    outline: Lattice | None
    """Weighted directions of the outline; None if they have no effect."""

    @property
    def is_straight(self) -> bool:
        """Whether all streets are straight."""
        return self.kind == "grid"

    @property
    def has_centre(self) -> bool:
        """Whether streets meet at the centre, where there is no direction."""
        return self.kind != "grid"

    def as_grid(self) -> Directions:
        """The grid of the field everywhere."""
        return replace(self, kind="grid", outline=None)

    def at(self, x: float, y: float) -> float:
        """Radians from the east to one of the two directions at a point."""
        if self.kind == "grid":
            return self.angle
        east, north = x - self.centre[0], y - self.centre[1]
        radial = math.atan2(north, east)
        if self.outline is None:
            return radial
        weight = _CENTRE_WEIGHT * math.exp(-(east**2 + north**2) / self.reach**2)
        cross = cmath.exp(4j * self.angle) + weight * cmath.exp(4j * radial) + self.outline.at(x, y)
        return cmath.phase(cross) / 4


@dataclass(frozen=True, slots=True, eq=False)
class Lattice:
    """Complex numbers on a square lattice, bilinear between its points and constant beyond it."""

    corner: tuple[float, float]
    step: float
    """Metres between points."""
    values: NDArray[np.complex128]
    """[r, c] rows to the north, columns to the east; at least two of each."""

    def at(self, x: float, y: float) -> complex:
        """The value at a point."""
        rows, columns = self.values.shape
        column = min(max((x - self.corner[0]) / self.step, 0.0), columns - 1.0)
        row = min(max((y - self.corner[1]) / self.step, 0.0), rows - 1.0)
        i, j = min(int(row), rows - 2), min(int(column), columns - 2)
        north, east = row - i, column - j
        lower = (1 - east) * self.values[i, j] + east * self.values[i, j + 1]
        upper = (1 - east) * self.values[i + 1, j] + east * self.values[i + 1, j + 1]
        return complex((1 - north) * lower + north * upper)


def directions_on(field: DirectionField, outline: shapely.Polygon) -> Directions:
    """The directions of a field on a valid outline in metres."""
    if field.angle is None:
        corners = shapely.get_coordinates(shapely.oriented_envelope(outline))
        sides = np.diff(corners[:3], axis=0)
        side = sides[np.linalg.norm(sides, axis=1).argmax()]
        angle = math.atan2(side[1], side[0])
    else:
        angle = math.radians(field.angle)
    middle = outline.centroid if outline.contains(outline.centroid) else outline.representative_point()
    place = field.centre if field.centre is not None else (middle.x, middle.y)
    centre = np.round(np.array(place, dtype=np.float64), 3)
    along = _along_outline(outline) if field.kind == "mixed" else None
    return Directions(field.kind, angle, centre, _CENTRE_SHARE * outline.area**0.5, along)


def _along_outline(outline: shapely.Polygon) -> Lattice:
    """Fourth powers of the directions of the nearest edges of an outline, with weights that fall with the distance."""
    low_x, low_y, high_x, high_y = outline.bounds
    step = max(_LATTICE_STEP, ((high_x - low_x) * (high_y - low_y) / _MAX_POINTS) ** 0.5)
    x, y = (np.arange(low, high + 2 * step, step) for low, high in ((low_x, high_x), (low_y, high_y)))
    points = np.stack(np.meshgrid(x, y), axis=2).reshape(-1, 2)
    edges = _edges(outline)
    tree = shapely.STRtree(np.asarray(shapely.linestrings(edges)))
    _, nearest = tree.query_nearest(np.asarray(shapely.points(points)), all_matches=False)
    start, along = edges[nearest, 0], edges[nearest, 1] - edges[nearest, 0]
    share = np.clip(((points - start) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    distance = np.hypot(*(points - start - share[:, None] * along).T)
    weight = _OUTLINE_WEIGHT * np.exp(-((distance / _OUTLINE_REACH) ** 2))
    values = weight * np.exp(4j * np.arctan2(along[:, 1], along[:, 0]))
    return Lattice((low_x, low_y), step, values.reshape(len(y), len(x)))


def _edges(outline: shapely.Polygon) -> Floats:
    """[E, 2, 2] edges of an outline and of its holes, without small windings."""
    rings: list[Floats] = []
    for ring in (outline.exterior, *outline.interiors):
        corners = shapely.get_coordinates(shapely.simplify(ring, _OUTLINE_STEP))
        rings.append(np.stack([corners[:-1], corners[1:]], axis=1))
    edges = np.concatenate(rings)
    return edges[(edges[:, 0] != edges[:, 1]).any(axis=1)]
