"""Outlines with arcs, as well-known binary of ISO 13249-3, with straight edges instead.

Cadastres of Switzerland and Germany have arcs; GEOS, which reads all other geometries, does not.
"""

from __future__ import annotations

import struct

import numpy as np
import shapely

from grammarlab.arrays import Floats

_POLYGON, _MULTIPOLYGON, _COLLECTION = 3, 6, 7
_LINE, _ARCS, _COMPOUND, _CURVE_POLYGON, _MULTISURFACE = 2, 8, 9, 10, 12
_STEP = np.radians(5.0)
"""Largest angle of an edge of an arc: it leaves the arc by a thousandth of the radius."""
_MAX_DEPTH = 4
_STRAIGHT = 1e-12
"""Ratio of the area of a triangle to its squared size below which its corners are on a line."""


def straightened(body: bytes) -> shapely.Geometry | None:
    """The polygons of a geometry with arcs; None if it has none or is broken."""
    try:
        polygons = _polygons(_Reader(body), 0)
    except (struct.error, ValueError, OverflowError):
        return None
    return shapely.MultiPolygon(polygons) if polygons else None


class _Reader:
    """A position in well-known binary.

    Args:
        body: the binary.
    """

    def __init__(self, body: bytes) -> None:
        self.body = body
        self.position = 0

    def head(self) -> tuple[str, int, int]:
        """Byte order, kind and number of coordinates of the geometry that follows."""
        order = "<" if self.body[self.position : self.position + 1] == b"\1" else ">"
        (kind,) = struct.unpack_from(order + "I", self.body, self.position + 1)
        self.position += 5
        dimensions = 2 + (kind >> 31 & 1) + (kind >> 30 & 1)  # as PostGIS writes it
        kind &= 0x0FFFFFFF
        dimensions += (0, 1, 1, 2)[kind // 1000 % 4]
        return order, kind % 1000, dimensions

    def count(self, order: str) -> int:
        (number,) = struct.unpack_from(order + "I", self.body, self.position)
        self.position += 4
        return number

    def points(self, order: str, dimensions: int) -> Floats:
        """[n, 2] the points that follow, without heights."""
        number = self.count(order)
        size = 8 * number * dimensions
        if self.position + size > len(self.body):
            raise ValueError("the geometry ends in the middle")
        values = np.frombuffer(self.body, np.dtype(order + "f8"), number * dimensions, self.position)
        self.position += size
        return values.reshape(number, dimensions)[:, :2].astype(np.float64)


def _polygons(reader: _Reader, depth: int) -> list[shapely.Polygon]:
    order, kind, dimensions = reader.head()
    if depth > _MAX_DEPTH or kind not in (_POLYGON, _MULTIPOLYGON, _COLLECTION, _CURVE_POLYGON, _MULTISURFACE):
        raise ValueError("not an outline")
    if kind == _POLYGON:
        return _polygon([reader.points(order, dimensions) for _ in range(reader.count(order))])
    if kind == _CURVE_POLYGON:
        return _polygon([_curve(reader, 0) for _ in range(reader.count(order))])
    return [polygon for _ in range(reader.count(order)) for polygon in _polygons(reader, depth + 1)]


def _polygon(rings: list[Floats]) -> list[shapely.Polygon]:
    return [shapely.Polygon(rings[0], [ring for ring in rings[1:] if len(ring) > 3])] if rings else []


def _curve(reader: _Reader, depth: int) -> Floats:
    """[n, 2] the points of a curve of lines and arcs."""
    order, kind, dimensions = reader.head()
    if kind == _LINE:
        return reader.points(order, dimensions)
    if kind == _ARCS:
        return _stroked(reader.points(order, dimensions))
    if kind != _COMPOUND or depth > 0:
        raise ValueError("not a curve")
    parts = [_curve(reader, depth + 1) for _ in range(reader.count(order))]
    return np.concatenate([parts[0], *[part[1:] for part in parts[1:]]])


def _stroked(points: Floats) -> Floats:
    """Points on arcs, each through three of some points [2 k + 1, 2]."""
    if len(points) % 2 == 0:
        raise ValueError("expected an odd number of points of arcs")
    arcs = [_arc(*points[index : index + 3]) for index in range(0, len(points) - 2, 2)]
    return np.concatenate([points[:1], *arcs])


def _arc(start: Floats, middle: Floats, end: Floats) -> Floats:
    """[n, 2] the points of an arc behind its start."""
    if (start == end).all():  # a whole circle
        centre, turn = (start + middle) / 2, 2 * np.pi
    else:
        u, v = middle - start, end - start
        cross = u[0] * v[1] - u[1] * v[0]
        if abs(cross) <= _STRAIGHT * max(float(u @ u), float(v @ v)):
            return np.array([middle, end])
        centre = start + np.array([v[1] * (u @ u) - u[1] * (v @ v), u[0] * (v @ v) - v[0] * (u @ u)]) / (2 * cross)
        angles = np.arctan2(*(np.array([start, end]) - centre).T[::-1])
        turn = (angles[1] - angles[0]) % (2 * np.pi) if cross > 0 else -((angles[0] - angles[1]) % (2 * np.pi))
    x, y = start - centre
    share = np.linspace(0.0, turn, int(np.ceil(abs(turn) / _STEP)) + 1)[1:]
    arc = centre + np.column_stack([x * np.cos(share) - y * np.sin(share), x * np.sin(share) + y * np.cos(share)])
    arc[-1] = end
    return arc
