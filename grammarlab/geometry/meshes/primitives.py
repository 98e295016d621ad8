"""Primitive shapes in the unit cube 0..1: closed if they have a volume, all faces point outwards.

Every primitive except the sphere and the star equals ``extrude`` or ``taper`` of its outline, face order included:
walls in the order of the footprint's edges, then the top, then the bottom.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.mesh import Meshes

FRONT, RIGHT, BACK, LEFT, TOP, BOTTOM = range(6)
"""Faces of `box`, in order."""

BOX_ROTATIONS: Floats = np.array(
    [
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
        [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
        [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
    ],
    dtype=np.float64,
)
"""[6, 3, 3] the frame of each face of `box`: columns are x along the first edge, y, and z along the outward normal."""

BOX_ORIGINS: Floats = np.array([[0, 0, 1], [1, 0, 1], [1, 0, 0], [0, 0, 0], [0, 1, 1], [0, 0, 0]], dtype=np.float64)
"""[6, 3] the first corner of each face of `box`: the origin of its frame."""

DEFAULT_SIDES = 16
"""Default number of sides of round primitives."""

STAR_TIPS, STAR_INNER_RADIUS = 5, 0.45
"""Star of the toy grammar; the inner radius is relative to the outer radius."""


def quad() -> Meshes:
    """The unit square at y = 0, seen from above; its first edge is the front one, along +x at z = 1."""
    return _ring(np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]))


def disk(sides: int = DEFAULT_SIDES) -> Meshes:
    """A regular polygon at y = 0 that fills the unit square, seen from above."""
    return _ring(_filling(_circle(sides)))


def box() -> Meshes:
    """The unit cube; faces are `FRONT`, `RIGHT`, `BACK`, `LEFT`, `TOP`, `BOTTOM`."""
    return extrude(quad(), np.ones(1))


def cylinder(sides: int = DEFAULT_SIDES) -> Meshes:
    """A prism over `disk`: its walls, the top, the bottom."""
    return extrude(disk(sides), np.ones(1))


def cone(sides: int = DEFAULT_SIDES) -> Meshes:
    """A pyramid over `disk` with its tip above the centre: its walls, then the bottom."""
    base = disk(sides).points
    center = _center(_circle(sides))
    points = np.vstack((base, [center[0], 1.0, center[1]]))
    walls = [[i, (i + 1) % sides, sides] for i in range(sides)]
    return Meshes.single(points, [*walls, list(range(sides))[::-1]])


def sphere(sides: int = DEFAULT_SIDES, divisions: int = DEFAULT_SIDES) -> Meshes:
    """A ball of quads with triangles at its poles; rows of faces from the bottom up.

    Args:
        sides: faces around, at least 3.
        divisions: rows of faces from pole to pole, at least 2.
    """
    latitude = np.linspace(-np.pi / 2, np.pi / 2, divisions + 1)[1:-1]
    circle = _circle(sides)
    rings = np.stack(
        [
            np.cos(latitude)[:, None] * circle[:, 0],
            np.broadcast_to(np.sin(latitude)[:, None], (divisions - 1, sides)),
            np.cos(latitude)[:, None] * circle[:, 1],
        ],
        axis=-1,
    ).reshape(-1, 3)
    points = np.vstack((rings, [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]))
    low, high = points.min(axis=0), points.max(axis=0)
    south, north = len(rings), len(rings) + 1
    here = np.arange(sides)
    after = (here + 1) % sides
    top = (divisions - 2) * sides
    faces = [[south, after[i], here[i]] for i in range(sides)]
    for row in range(0, top, sides):
        faces += [[row + here[i], row + after[i], row + sides + after[i], row + sides + here[i]] for i in range(sides)]
    faces += [[top + here[i], top + after[i], north] for i in range(sides)]
    return Meshes.single((points - low) / (high - low), faces)


def star(tips: int = STAR_TIPS, inner_radius: float = STAR_INNER_RADIUS) -> Meshes:
    """A prism over a star: its walls, the top, the bottom."""
    outline = _circle(2 * tips) * np.where(np.arange(2 * tips) % 2, inner_radius, 1.0)[:, None]
    return extrude(_ring(_filling(outline)), np.ones(1))


def _circle(sides: int) -> Floats:
    """[sides, 2] x and z on the unit circle, counter-clockwise seen from above, starting in the back."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    return np.column_stack((-np.sin(angle), -np.cos(angle)))


def _filling(outline: Floats) -> Floats:
    """An outline scaled to fill the unit square."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    return (outline - low) / (high - low)


def _center(circle: Floats) -> Floats:
    """Centre of a circle after `_filling` has scaled it."""
    low, high = circle.min(axis=0), circle.max(axis=0)
    return -low / (high - low)


def _ring(outline: Floats) -> Meshes:
    """One face at y = 0 through x and z [n, 2]."""
    points = np.column_stack((outline[:, 0], np.zeros(len(outline)), outline[:, 1]))
    return Meshes.from_polygons(points, np.array([len(points)]))


_BUILTIN: dict[str, Callable[[], Meshes]] = {
    "quad": quad,
    "disk": disk,
    "cube": box,
    "box": box,
    "cylinder": cylinder,
    "cone": cone,
    "sphere": sphere,
    "star": star,
}

BUILTIN_ASSETS: tuple[str, ...] = tuple(f"builtin:{name}" for name in _BUILTIN)
"""Names of built-in meshes, as in ``i("builtin:cube")``."""


@cache
def builtin_asset(name: str) -> Meshes:
    """The primitive of that name, with or without ``builtin:`` in front.

    Raises:
        KeyError: If the primitive does not exist.
    """
    return _BUILTIN[name.removeprefix("builtin:")]()
