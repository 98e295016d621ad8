"""Primitive shapes in the unit cube 0..1: closed if they have a volume, all faces point outwards.

Faces have the order of CityEngine's: bottom, top and walls from the first edge on; a cylinder begins with its top.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.mesh import Meshes

BOTTOM, TOP, FRONT, RIGHT, BACK, LEFT = range(6)
"""Faces of `box`, in order."""

BOX_ROTATIONS: Floats = np.array(
    [
        [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
        [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
        [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
    ],
    dtype=np.float64,
)
"""[6, 3, 3] the frame of each face of `box`: columns are x along the first edge, y, and z along the outward normal."""

BOX_ORIGINS: Floats = np.array([[0, 0, 0], [0, 1, 1], [0, 0, 1], [1, 0, 1], [1, 0, 0], [0, 0, 0]], dtype=np.float64)
"""[6, 3] the first corner of each face of `box`: the origin of its frame."""

DEFAULT_SIDES = 16
"""Default number of sides of round primitives."""

STAR_TIPS, STAR_INNER_RADIUS = 5, 0.45
"""Star of the toy grammar; the inner radius is relative to the outer radius."""

_kept = lru_cache(maxsize=64)
"""Round primitives of few faces are made once for each number of sides; the largest take 60 kB each."""


@cache
def quad() -> Meshes:
    """The unit square at y = 0, seen from above; its first edge is the front one, along +x at z = 1."""
    return _ring(np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]))


@_kept
def disk(sides: int = DEFAULT_SIDES) -> Meshes:
    """A regular polygon at y = 0 that fills the unit square, seen from above."""
    return _ring(_filling(_circle(sides)))


@cache
def box() -> Meshes:
    """The unit cube; faces are `BOTTOM`, `TOP`, `FRONT`, `RIGHT`, `BACK`, `LEFT`, the bottom from its x axis on."""
    prism = extrude(quad(), np.ones(1))
    # `extrude` begins the bottom with the first edge of the quad.
    corners = np.concatenate((np.roll(prism.corners[:4], 2), prism.corners[4:]))
    return replace(prism, corners=corners)


@_kept
def cylinder(sides: int = DEFAULT_SIDES) -> Meshes:
    """A prism over `disk`: the top, the bottom, its walls."""
    prism = extrude(disk(sides), np.ones(1))
    bottom, top, walls = np.split(prism.corners, (sides, 2 * sides))
    return replace(prism, corners=np.concatenate((top, np.roll(bottom, -1), walls)))


@_kept
def cone(sides: int = DEFAULT_SIDES) -> Meshes:
    """A pyramid over `disk` with its tip above the centre: the bottom, then its walls."""
    base = disk(sides).points
    center = _center(_circle(sides))
    points = np.vstack((base, [center[0], 1.0, center[1]]))
    walls = [[i, (i + 1) % sides, sides] for i in range(sides)]
    return Meshes.single(points, [[1, 0, *range(sides - 1, 1, -1)], *walls])


def sphere(sides: int = DEFAULT_SIDES, divisions: int = DEFAULT_SIDES) -> Meshes:
    """A ball of quads with triangles at its poles: one face in front, then rows of faces from the bottom up.

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
    quads = [
        [row + sides + after[i], row + sides + here[i], row + here[i], row + after[i]]
        for row in range(0, top, sides)
        for i in range(sides)
    ]
    below = [[after[i], here[i], south] for i in (*range(1, sides), 0)]
    above = [[top + here[i], top + after[i], north] for i in range(sides)]
    faces = [*quads[:1], *below, *quads[1:], *above]
    return Meshes.single((points - low) / (high - low), faces)


def star(tips: int = STAR_TIPS, inner_radius: float = STAR_INNER_RADIUS) -> Meshes:
    """A prism over a star, with one tip in the back."""
    angle = np.pi * np.arange(2 * tips) / tips
    radius = np.where(np.arange(2 * tips) % 2, inner_radius, 1.0)
    outline = np.column_stack((-radius * np.sin(angle), -radius * np.cos(angle)))
    return extrude(_ring(_filling(outline)), np.ones(1))


def _circle(sides: int) -> Floats:
    """[sides, 2] x and z on the unit circle, counter-clockwise seen from above; the first edge lies in front."""
    angle = np.pi * (2.0 * np.arange(sides) - 1.0) / sides
    return np.column_stack((np.sin(angle), np.cos(angle)))


def _filling(outline: Floats) -> Floats:
    """An outline scaled to fill the unit square."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    return (outline - low) / (high - low)


def _center(circle: Floats) -> Floats:
    """Centre of a circle after `_filling` has scaled it."""
    low, high = circle.min(axis=0), circle.max(axis=0)
    return -low / (high - low)


def natural_size(name: str, *counts: int) -> Floats:
    """[3] size of a round primitive inscribed in a circle of diameter 1 and of height 1; ones for the others.

    Args:
        name: `disk`, `cylinder`, `cone`, `sphere` or another primitive.
        counts: numbers of sides, and of divisions of a sphere, as for these functions.
    """
    if name not in _ROUND:
        return np.array([1.0, 0.0 if name == "quad" else 1.0, 1.0])
    width, depth = 0.5 * np.ptp(_circle(*counts[:1] or (DEFAULT_SIDES,)), axis=0)
    if name == "sphere":
        divisions = counts[1] if len(counts) > 1 else DEFAULT_SIDES
        widest = np.cos(np.pi * (0.5 / divisions if divisions % 2 else 0.0))
        width, depth = width * widest, depth * widest
    return np.array([width, 0.0 if name == "disk" else 1.0, depth])


def axis_place(name: str, *counts: int) -> Floats:
    """[3] where the axis of a round primitive meets its floor, as shares of its size; the middle for the others.

    Args:
        name: as for `natural_size`.
        counts: as for `natural_size`.
    """
    if name not in _ROUND:
        return np.array([0.5, 0.0, 0.5])
    x, z = _center(_circle(*counts[:1] or (DEFAULT_SIDES,)))
    return np.array([x, 0.0, z])


def _ring(outline: Floats) -> Meshes:
    """One face at y = 0 through x and z [n, 2]."""
    points = np.column_stack((outline[:, 0], np.zeros(len(outline)), outline[:, 1]))
    return Meshes.from_polygons(points, np.array([len(points)]))


_ROUND = frozenset({"disk", "cylinder", "cone", "sphere"})

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
