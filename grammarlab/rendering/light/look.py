"""Light and paper of all pictures, the same for all renderers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import AnyFloats

Color = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Look:
    """Light in linear units, where 1 is a fully lit white surface before exposure."""

    sun_azimuth: float = -62.0
    """Degrees from the direction of the camera; negative is to its left."""
    sun_elevation: float = 44.0
    """Degrees above the horizon."""
    sun_softness: float = 0.02
    """Radius of the sun as a tangent: softness of shadows."""
    sun: Color = (2.35, 2.16, 1.86)
    sky: Color = (0.60, 0.72, 0.95)
    """Light from straight above."""
    horizon: Color = (0.95, 0.95, 0.93)
    ground: Color = (0.46, 0.43, 0.39)
    """Light from below."""
    bounce: float = 0.18
    """Light at fully occluded places, as a share of the ground's."""
    exposure: float = 0.52
    shoulder: float = 0.55
    """Light up to which the tone curve is linear, after exposure; above, it approaches white."""
    background_top: Color = (0.56, 0.63, 0.71)
    background_bottom: Color = (0.88, 0.88, 0.87)
    """Linear colour of the paper."""
    shadow: Color = (0.47, 0.51, 0.60)
    """Factor of the paper in full shadow of the sun."""
    contact: Color = (0.30, 0.31, 0.33)
    """Factor of the paper at full occlusion."""
    edge: float = 0.5
    """Share of the light removed by edges of the model, 0..1."""


def sun_direction(look: Look, camera_axes: NDArray[np.floating]) -> AnyFloats:
    """[3] unit vector towards the sun, fixed relative to the camera.

    Args:
        look: the light.
        camera_axes: [3, 3] rows right, up, backward.
    """
    backward = camera_axes[0, [2, 1, 0]] * (-1.0, 0.0, 1.0)
    azimuth, elevation = math.radians(look.sun_azimuth), math.radians(look.sun_elevation)
    across = math.sin(azimuth) * camera_axes[0] + math.cos(azimuth) * backward
    return (across * math.cos(elevation) + np.array([0.0, math.sin(elevation), 0.0])).astype(np.float32)


def mirrored_surroundings(look: Look, directions: AnyFloats) -> AnyFloats:
    """[N, 3] sky in directions [N, 3]: clear, pale at the horizon.

    Below the horizon the sky is repeated, darker: seen from above, a window mirrors the ground, but people expect sky.
    """
    height = directions[:, 1]
    above = np.sqrt(np.abs(height))
    horizon, sky = np.array(look.horizon, np.float32), np.array(look.sky, np.float32)
    strength = np.where(height < 0, np.float32(1.1), np.float32(1.4))
    return mixed((strength, strength * above), (horizon, sky * np.array((0.55, 0.75, 1.0), np.float32) - horizon))


def ambient(look: Look, normals: AnyFloats) -> AnyFloats:
    """[N, 3] light that an open surface with these unit normals receives from sky and ground."""
    upward = normals[:, 1] * np.float32(0.5) + np.float32(0.5)
    return mixed((upward, 1 - upward), (look.sky, look.ground))


def mixed(amounts: Sequence[AnyFloats], colors: Sequence[Color | AnyFloats]) -> AnyFloats:
    """[N, 3] sum of K colours [3] with weights [N].

    One matrix product: multiplying rows of three by a colour is five times slower.
    """
    return np.stack(amounts, axis=1) @ np.array(colors, np.float32)


def background(look: Look, y: AnyFloats) -> AnyFloats:
    """[N, 3] the paper at heights [N] of the picture, -1 at the bottom to 1 at the top."""
    top, bottom = np.array(look.background_top, np.float32), np.array(look.background_bottom, np.float32)
    t = np.clip(y * 0.5 + 0.5, 0.0, 1.0)[:, None]
    t = t * t * (3.0 - 2.0 * t)
    return (bottom + t * (top - bottom)).astype(np.float32)


def tone_map(look: Look, light: AnyFloats) -> AnyFloats:
    """Tone curve of light, linear in 0..1: identity up to the shoulder, rolled off towards white above."""
    light = light * np.float32(look.exposure)
    start = np.float32(look.shoulder)
    room = np.float32(1.0) - start
    return np.where(light < start, light, start + room * (1.0 - np.exp((start - np.maximum(light, start)) / room)))
