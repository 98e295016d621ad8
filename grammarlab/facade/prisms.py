"""Leaves that are not rectangles, as meshes: the element itself, and the rest of its box."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon, box, make_valid
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from grammarlab.geometry.meshes.keyhole import keyhole
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.solids.extrude import extrude

Floats = NDArray[np.float64]

_LEAST_AREA = 1e-9
"""Least area of a piece of a box; smaller pieces are left out."""

UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""[3, 3] rotation of prisms over the plane of x and z to that of x and y, with y towards the viewer."""


def prisms(outline: Floats) -> tuple[Meshes, Meshes]:
    """Prisms of height 1 over an outline, and over the rest of the unit square.

    Args:
        outline: [P, 2] corners in 0 to 1, v up; parts outside the square are clipped.

    Returns:
        The meshes of the pieces of each, with u along x and v against z, to be rotated by `UPRIGHT`.
    """
    square = box(0.0, 0.0, 1.0, 1.0)
    inside = make_valid(Polygon(outline)).intersection(square)
    return _prisms(inside), _prisms(square.difference(inside))


def _prisms(shape: BaseGeometry) -> Meshes:
    rings = list(_rings(shape))
    if not rings:
        return Meshes.from_polygons(np.zeros((0, 3)), np.zeros(0, dtype=np.int64))
    flat = np.concatenate(rings)
    points = np.column_stack([flat[:, 0], np.zeros(len(flat)), 1.0 - flat[:, 1]])
    return extrude(Meshes.from_polygons(points, np.array([len(ring) for ring in rings])), np.ones(len(rings)))


def _rings(shape: BaseGeometry) -> Iterator[Floats]:
    """[n, 2] one closed walk around each polygon of a shape and its holes."""
    for piece in getattr(shape, "geoms", [shape]):
        if isinstance(piece, Polygon) and piece.area > _LEAST_AREA:
            turned = orient(piece)
            rings = [np.asarray(ring.coords)[:-1] for ring in (turned.exterior, *turned.interiors)]
            yield np.concatenate(rings)[keyhole(rings)]
