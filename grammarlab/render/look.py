"""The light and the paper that every picture shares, whichever renderer makes it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Color = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Look:
    """Light in linear units, where 1 is a fully lit white surface before exposure."""

    sun_azimuth: float = -62.0
    """Degrees from the direction of the camera; negative is to its left."""
    sun_elevation: float = 44.0
    """Degrees above the horizon."""
    sun_softness: float = 0.02
    """Radius of the sun as a tangent: how soft shadows are."""
    sun: Color = (2.30, 2.10, 1.80)
    sky: Color = (0.62, 0.74, 0.95)
    """Light from straight above."""
    horizon: Color = (0.95, 0.95, 0.93)
    ground: Color = (0.46, 0.43, 0.39)
    """Light from below."""
    bounce: float = 0.16
    """Light that reaches places where nothing of the surroundings is seen, as a share of the sky's."""
    exposure: float = 0.62
    white: float = 2.6
    """Smallest light that is shown as pure white, after exposure."""
    background_top: Color = (0.62, 0.68, 0.75)
    background_bottom: Color = (0.90, 0.90, 0.89)
    """Linear, as shown."""
    shadow: Color = (0.60, 0.64, 0.72)
    """What a full shadow of the sun leaves of the paper that the model stands on."""
    contact: Color = (0.28, 0.29, 0.31)
    """What the deepest gap leaves of it."""
    edge: float = 0.55
    """How much of the light an edge of the model takes away, 0..1."""


def sun_direction(look: Look, camera_axes: NDArray[np.float64]) -> Floats:
    """[3] unit vector towards the sun, which keeps its place beside the camera.

    Args:
        look: the light.
        camera_axes: [3, 3] rows right, up, backward.
    """
    backward = camera_axes[0, [2, 1, 0]] * (-1.0, 0.0, 1.0)
    azimuth, elevation = math.radians(look.sun_azimuth), math.radians(look.sun_elevation)
    across = math.sin(azimuth) * camera_axes[0] + math.cos(azimuth) * backward
    return (across * math.cos(elevation) + np.array([0.0, math.sin(elevation), 0.0])).astype(np.float32)


def surroundings(look: Look, directions: Floats) -> Floats:
    """[N, 3] light that arrives from directions [N, 3]: a clear sky above, pale ground below."""
    height = directions[:, 1:2]
    above = np.sqrt(np.clip(height, 0.0, 1.0))
    below = np.clip(-height * 4.0, 0.0, 1.0)
    horizon, sky, ground = (np.array(c, np.float32) for c in (look.horizon, look.sky, look.ground))
    zenith = sky * np.float32(0.62)
    return horizon + above * (zenith - horizon) + below * (ground - horizon)


def ambient(look: Look, normals: Floats) -> Floats:
    """[N, 3] light that an open surface with these unit normals receives from sky and ground."""
    upward = normals[:, 1:2] * np.float32(0.5) + np.float32(0.5)
    sky, ground = np.array(look.sky, np.float32), np.array(look.ground, np.float32)
    return ground + upward * (sky - ground)


def background(look: Look, y: Floats) -> Floats:
    """[N, 3] the paper at heights [N] of the picture, -1 at the bottom to 1 at the top."""
    top, bottom = np.array(look.background_top, np.float32), np.array(look.background_bottom, np.float32)
    t = np.clip(y * 0.5 + 0.5, 0.0, 1.0)[:, None]
    t = t * t * (3.0 - 2.0 * t)
    return (bottom + t * (top - bottom)).astype(np.float32)


def tone_map(look: Look, light: Floats) -> Floats:
    """Light as shown, linear in 0..1: nearly proportional in the shade, rolled off towards white."""
    light = light * np.float32(look.exposure)
    return np.clip(light * (1.0 + light / np.float32(look.white**2)) / (1.0 + light) * np.float32(1.25), 0.0, 1.0)
