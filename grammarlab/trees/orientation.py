"""Turns of frames, as columns.

Axes [3, S, 3] are the x, y and z axis of S frames, one after another, so that one axis of all of them lies together.
Angles are in radians, right-handed; +y of the world is up.
"""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats


def trunk_axes(num: int) -> Floats:
    """[3, S, 3] axes of trunks: upright, x along the world's x."""
    axes = np.zeros((3, num, 3))
    axes[0, :, 0], axes[1, :, 2], axes[2, :, 1] = 1.0, -1.0, 1.0
    return axes


def frames_from_axes(axes: Floats) -> Floats:
    """[S, 3, 3] frames, with the axes as columns."""
    return np.ascontiguousarray(np.moveaxis(axes, 0, 2))


def axes_from_frames(frames: Floats) -> Floats:
    """[3, S, 3] axes of frames [S, 3, 3]."""
    return np.ascontiguousarray(np.moveaxis(frames, 2, 0))


def turned_about_x(axes: Floats, angle: Floats) -> Floats:
    """Axes after a turn about their own x: a positive angle turns z away from y."""
    x, y, z = axes
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack([x, c * y + s * z, c * z - s * y])


def turned_about_y(axes: Floats, angle: Floats) -> Floats:
    """Axes after a turn about their own y: a positive angle turns z towards x."""
    x, y, z = axes
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack([c * x - s * z, y, c * z + s * x])


def turned_about_z(axes: Floats, angle: Floats) -> Floats:
    """Axes after a turn about their own z: a positive angle turns x towards y."""
    x, y, z = axes
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack([c * x + s * y, c * y - s * x, z])


def turned_about_vertical(axes: Floats, angle: Floats) -> Floats:
    """Axes after a turn about the world's vertical: a positive angle turns the world's z towards its x."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y, z = axes[..., 0], axes[..., 1], axes[..., 2]
    return np.stack([c.T * x + s.T * z, y, c.T * z - s.T * x], axis=-1)


def turned_about(axes: Floats, axis: Floats, angle: Floats) -> Floats:
    """Axes after a turn about unit vectors [S, 3] of the world (Rodrigues' formula)."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = dots(axes, axis)[..., None]
    return c * axes + s * np.cross(axis, axes) + (1.0 - c) * along * axis


def dots(one: Floats, other: Floats) -> Floats:
    """[…] scalar products of vectors […, 3], with one order of additions for any number of them."""
    product = one * other
    return product[..., 0] + product[..., 1] + product[..., 2]


def declination(direction: Floats) -> Floats:
    """[S] angle between unit vectors [S, 3] and the vertical, 0 to π."""
    return np.arccos(np.clip(direction[:, 1], -1.0, 1.0))
