"""Conversion between sRGB values and linear light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def linear_from_srgb(color: NDArray[np.floating]) -> NDArray[np.floating]:
    """Linear light in 0..1 from sRGB values in 0..1 (IEC 61966-2-1).

    >>> linear_from_srgb(np.array([0.0, 0.5, 1.0])).round(4).tolist()
    [0.0, 0.214, 1.0]
    """
    color = np.clip(color, 0.0, 1.0)
    return np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)


def srgb_from_linear(light: NDArray[np.floating]) -> NDArray[np.floating]:
    """SRGB values in 0..1 from linear light in 0..1.

    >>> srgb_from_linear(np.array([0.0, 0.214, 1.0])).round(3).tolist()
    [0.0, 0.5, 1.0]
    """
    light = np.clip(light, 0.0, 1.0)
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
