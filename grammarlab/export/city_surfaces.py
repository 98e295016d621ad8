"""Geometries of CityJSON: surfaces over a table of points in whole millimetres, with their kinds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from grammarlab.arrays import Floats, Ints
from grammarlab.export.surface_labels import GROUND, ROOF, SURFACE_TYPES, WALL
from grammarlab.geometry.meshes.ragged import distinct_keys

MILLIMETRES = 1000.0
"""Steps per metre of coordinates."""
Surface: TypeAlias = list[list[int]]
"""Rings of rows of points: the outer one counter-clockwise seen from outside, then holes."""


@dataclass(frozen=True, slots=True)
class SurfaceKind:
    """A semantic surface."""

    kind: int
    """Index into `SURFACE_TYPES`."""
    parent: int | None = None
    """Index of the wall of an opening."""

    def as_dict(self) -> dict[str, object]:
        """The object of the file."""
        parent = {} if self.parent is None else {"parent": self.parent}
        return {"type": SURFACE_TYPES[self.kind], **parent}


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class CityGeometry:
    """F surfaces of a building, closed if they are a solid."""

    shape: Literal["Solid", "MultiSurface"]
    points: Ints
    """[V, 3] millimetres to the east, to the north and up from the origin of the frame."""
    surfaces: Sequence[Surface]
    kinds: Sequence[SurfaceKind]
    """The different semantic surfaces."""
    kind: Sequence[int]
    """[F] index into `kinds`."""


def to_grid(metres: Floats) -> Ints:
    """Whole millimetres of coordinates in metres."""
    return np.rint(metres * MILLIMETRES).astype(np.int64)


def distinct_points(points: Ints) -> tuple[Ints, Ints]:
    """The different rows of a table of points [V, 3], in ascending order, and the number of each row [V]."""
    if len(points) == 0:
        return points, np.zeros(0, np.int64)
    low = points.min(axis=0)
    extent = (points.max(axis=0) - low + 1).tolist()
    if math.prod(extent) >= 2**63:
        different, number = np.unique(points, axis=0, return_inverse=True)
        return different, number.ravel()
    x, y, z = (points - low).T
    first, number = distinct_keys((x * extent[1] + y) * extent[2] + z)
    return points[first], number


def solid(points: Ints, surfaces: Sequence[Surface], kind: Sequence[int]) -> CityGeometry:
    """A solid of ground, walls and roof.

    Args:
        points: [V, 3] as in `CityGeometry`.
        surfaces: [F] the surfaces.
        kind: [F] `GROUND`, `WALL` or `ROOF`.
    """
    number = {GROUND: 0, WALL: 1, ROOF: 2}
    return CityGeometry(
        shape="Solid",
        points=points,
        surfaces=surfaces,
        kinds=[SurfaceKind(name) for name in number],
        kind=[number[name] for name in kind],
    )


def block(footprint: shapely.Polygon, low: float, high: float) -> CityGeometry | None:
    """Prism over a footprint with its holes.

    Args:
        footprint: metres to the east and to the north of the frame's origin.
        low: height of the bottom in metres.
        high: height of the top.

    Returns:
        The prism; None if nothing remains of it on the grid of millimetres.
    """
    bottom, top = to_grid(np.array([low, high])).tolist()
    plan, rings = _plan(footprint)
    if not rings or top <= bottom:
        return None
    num = len(plan)
    points = np.concatenate([np.column_stack([plan, np.full(num, z)]) for z in (bottom, top)])
    walls = [[[a, b, b + num, a + num]] for ring in rings for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)]
    ground, roof = [ring[::-1] for ring in rings], [[row + num for row in ring] for ring in rings]
    return solid(points, [ground, *walls, roof], [GROUND, *[WALL] * len(walls), ROOF])


def with_ground(geometry: CityGeometry, footprint: shapely.Polygon, low: float) -> CityGeometry:
    """Surfaces with a ground surface below them: a footprint, in metres, at a height in metres."""
    plan, rings = _plan(footprint)
    if not rings:
        return geometry
    first = len(geometry.points)
    ground = [[row + first for row in reversed(ring)] for ring in rings]
    level = np.full(len(plan), to_grid(np.array(low)))
    return replace(
        geometry,
        points=np.concatenate([geometry.points, np.column_stack([plan, level])]),
        surfaces=[*geometry.surfaces, ground],
        kinds=[*geometry.kinds, SurfaceKind(GROUND)],
        kind=[*geometry.kind, len(geometry.kinds)],
    )


def _plan(footprint: shapely.Polygon) -> tuple[Ints, Surface]:
    """Points [n, 2] of a footprint in millimetres, and its rings of them seen from above."""
    rings = rings_on_grid(footprint)
    starts = np.cumsum([0, *(len(ring) for ring in rings)]).tolist()
    plan = np.concatenate([np.zeros((0, 2), np.int64), *rings])
    return plan, [list(range(start, end)) for start, end in pairwise(starts)]


def rings_on_grid(polygon: shapely.Polygon) -> list[Ints]:
    """Rings [n, 2] of a polygon in millimetres, unclosed: the outer one counter-clockwise, holes clockwise.

    Of a polygon that falls apart on the grid the largest part remains.
    """
    snapped = shapely.get_parts(shapely.set_precision(polygon, 1 / MILLIMETRES))
    parts = [part for part in snapped if isinstance(part, shapely.Polygon) and not part.is_empty]
    if not parts:
        return []
    whole = orient(max(parts, key=lambda part: part.area))
    return [to_grid(shapely.get_coordinates(ring)[:-1]) for ring in (whole.exterior, *whole.interiors)]
