"""A building upright and square to its main walls, and views of its four sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.synthesis.mesh.surface import Surface

FRONT, RIGHT, BACK, LEFT = range(4)
SIDES = ("front", "right", "back", "left")
VIEWS = np.array(
    [
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
        [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
        [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
    ],
    dtype=np.float64,
)
"""[4, 3, 3] for each side, the directions to the right, up and towards the viewer."""
_AXES = np.abs(VIEWS).argmax(axis=2)
"""[4, 3] axis of the building for each axis of a view, ignoring its sign."""
Z_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
"""Rotation of a building with z up to one with y up."""
_MAX_VERTICAL = 0.35
"""Largest vertical component of the normal of a triangle in a wall."""


@dataclass(frozen=True, slots=True)
class Plane:
    """A plane across an axis of the building."""

    axis: int
    position: float
    """Coordinate on the axis, metres."""


def plane_of(side: int, axis: int, position: float) -> Plane:
    """The plane of constant coordinate of a view (0 right, 1 up, 2 towards the viewer)."""
    direction = VIEWS[side, axis]
    building_axis = int(np.abs(direction).argmax())
    return Plane(building_axis, position * float(direction[building_axis]))


def seen_from(side: int, points: Floats) -> Floats:
    """Points [..., 3] of the building in the coordinates of a view."""
    return np.stack([VIEWS[side, k, axis] * points[..., axis] for k, axis in enumerate(_AXES[side])], axis=-1)


def placed_from(side: int, points: Floats) -> Floats:
    """Points [..., 3] in the coordinates of a view, transformed back to those of the building."""
    back = np.argsort(_AXES[side])
    return np.stack([VIEWS[side, k, axis] * points[..., k] for axis, k in enumerate(back)], axis=-1)


def turn_to_walls(surface: Surface) -> Floats:
    """[3, 3] rotation about y, at most 45 degrees, that makes the walls, weighted by area, square to x and z.

    Walls at right angles have equal angles after multiplication by four. Normals may point inwards.
    """
    corners = surface.corners()
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2.0
    area = np.linalg.norm(normals, axis=1)
    wall = np.abs(normals[:, 1]) <= _MAX_VERTICAL * area
    angle = np.arctan2(normals[wall, 0], normals[wall, 2])
    total = (area[wall] * np.exp(4j * angle)).sum()
    turn = float(np.angle(total)) / 4.0 if abs(total) > 1e-9 * max(float(area.sum()), 1e-12) else 0.0
    return rotation(turn)


def rotation(turn: float) -> Floats:
    """[3, 3] rotation about y by radians; exact for right angles up to rounding errors."""
    if abs(turn) < 1e-6:
        return np.eye(3)
    c, s = np.cos(turn), np.sin(turn)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
