"""Turns of frames, as columns.

Axes [3, 3, S] are the x, y and z axis of S frames, one after another, each with its three components: numbers that are
used together lie together. Angles are in radians, right-handed; +y of the world is up.
"""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats


def trunk_axes(num: int) -> Floats:
    """[3, 3, S] axes of trunks: upright, x along the world's x."""
    axes = np.zeros((3, 3, num))
    axes[0, 0], axes[1, 2], axes[2, 1] = 1.0, -1.0, 1.0
    return axes


def frames_from_axes(axes: Floats) -> Floats:
    """[S, 3, 3] frames, with the axes as columns."""
    return np.ascontiguousarray(axes.T)


def axes_from_frames(frames: Floats) -> Floats:
    """[3, 3, S] axes of frames [S, 3, 3]."""
    return np.ascontiguousarray(frames.T)


def turned_about_x(axes: Floats, angle: Floats) -> Floats:
    """Axes after a turn about their own x: a positive angle turns z away from y."""
    x, y, z = axes
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([x, c * y + s * z, c * z - s * y])


def turned_about_y(axes: Floats, angle: Floats) -> Floats:
    """Axes after a turn about their own y: a positive angle turns z towards x."""
    x, y, z = axes
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x - s * z, y, c * z + s * x])


def turned_about_z(axes: Floats, angle: Floats) -> Floats:
    """Axes after a turn about their own z: a positive angle turns x towards y."""
    x, y, z = axes
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x + s * y, c * y - s * x, z])


def turned_about_vertical(axes: Floats, angle: Floats) -> Floats:
    """Axes after a turn about the world's vertical: a positive angle turns the world's z towards its x."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = axes[:, 0], axes[:, 1], axes[:, 2]
    return np.stack([c * x + s * z, y, c * z - s * x], axis=1)


def turned_about(axes: Floats, axis: Floats, angle: Floats) -> Floats:
    """Axes after a turn about unit vectors [3, S] of the world (Rodrigues' formula)."""
    c, s = np.cos(angle), np.sin(angle)
    t = (1.0 - c) * axis
    return np.stack([c * each + s * crossed(axis, each) + dots(axis, each) * t for each in axes])


def dots(one: Floats, other: Floats) -> Floats:
    """[S] scalar products of vectors [3, S], with one order of additions for any number of them."""
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def crossed(one: Floats, other: Floats) -> Floats:
    """[3, S] vector products of vectors [3, S]."""
    (a, b, c), (x, y, z) = one, other
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x])


def declination(direction: Floats) -> Floats:
    """[S] angle between unit vectors [3, S] and the vertical, 0 to π."""
    return np.arccos(np.clip(direction[1], -1.0, 1.0))
