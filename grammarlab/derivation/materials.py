"""Materials: what a surface looks like, interned so that a shape carries one integer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CHANNELS = {
    "color.r": 1.0,
    "color.g": 1.0,
    "color.b": 1.0,
    "opacity": 1.0,
    "metallic": 0.0,
    "roughness": 0.8,
    "emissive.r": 0.0,
    "emissive.g": 0.0,
    "emissive.b": 0.0,
}
"""The numbers of a material and their values on a fresh shape, all in 0..1; colours are sRGB, as in CGA."""


@dataclass(frozen=True, slots=True)
class Materials:
    """K materials as columns."""

    channels: NDArray[np.float64]
    """[K, 9] in the order of `CHANNELS`."""
    textures: tuple[str, ...]
    """[K] path of the colour map relative to the asset folder, empty for none."""

    def __len__(self) -> int:
        return len(self.textures)

    @property
    def color(self) -> NDArray[np.float64]:
        """[K, 3] sRGB in 0..1."""
        return self.channels[:, 0:3]

    @property
    def opacity(self) -> NDArray[np.float64]:
        return self.channels[:, 3]

    @property
    def metallic(self) -> NDArray[np.float64]:
        return self.channels[:, 4]

    @property
    def roughness(self) -> NDArray[np.float64]:
        return self.channels[:, 5]

    @property
    def emissive(self) -> NDArray[np.float64]:
        """[K, 3] sRGB in 0..1."""
        return self.channels[:, 6:9]
