"""Stretching of the rest of a building: each axis is stretched at the units of the main walls, and moved elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.mesh.surface import Floats


@dataclass(frozen=True, slots=True)
class Stretch:
    """For each axis, a piece [low, high] that becomes [new_low, new_high]; parts beyond it keep their size."""

    low: Floats
    """[3] start of the piece, metres."""
    high: Floats
    """[3] end of the piece, metres, above `low`."""
    new_low: Floats
    """[3] new start, metres."""
    new_high: Floats
    """[3] new end, metres."""

    def along(self, axis: int, places: Floats) -> Floats:
        """[N] new positions on an axis."""
        low, high = self.low[axis], self.high[axis]
        scale = (self.new_high[axis] - self.new_low[axis]) / (high - low)
        inside = self.new_low[axis] + (places - low) * scale
        outside = np.where(places < low, places - low + self.new_low[axis], places - high + self.new_high[axis])
        return np.where((places < low) | (places > high), outside, inside)

    def points(self, points: Floats) -> Floats:
        """[P, 3] new positions of points."""
        return np.stack([self.along(axis, points[:, axis]) for axis in range(3)], axis=1)
