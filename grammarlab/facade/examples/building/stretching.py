"""What is no unit follows: each axis is stretched where the units of the main walls are, and moved elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.mesh.surface import Floats


@dataclass(frozen=True, slots=True)
class Stretch:
    """For each axis a piece [low, high] that becomes [new_low, new_high]; beyond it all keeps its size."""

    low: Floats
    """[3] metres."""
    high: Floats
    """[3] metres, above `low`."""
    new_low: Floats
    """[3] metres."""
    new_high: Floats
    """[3] metres."""

    def along(self, axis: int, places: Floats) -> Floats:
        """[N] where places on an axis come to lie."""
        low, high = self.low[axis], self.high[axis]
        scale = (self.new_high[axis] - self.new_low[axis]) / (high - low)
        inside = self.new_low[axis] + (places - low) * scale
        outside = np.where(places < low, places - low + self.new_low[axis], places - high + self.new_high[axis])
        return np.where((places < low) | (places > high), outside, inside)

    def points(self, points: Floats) -> Floats:
        """[P, 3] where points come to lie."""
        return np.stack([self.along(axis, points[:, axis]) for axis in range(3)], axis=1)
