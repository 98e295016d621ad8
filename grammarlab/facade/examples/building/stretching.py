"""Stretching of the rest of a building: each axis is stretched at the units of the main walls, and moved elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.facade.examples.building.units import SNAP
from grammarlab.facade.examples.mesh.slicing import sliced
from grammarlab.facade.examples.mesh.surface import Floats, Surface


@dataclass(frozen=True, slots=True)
class Knots:
    """Places on an axis and their new places; the map between them is linear."""

    old: Floats
    """[K] ascending places, metres."""
    new: Floats
    """[K] ascending new places, metres."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """For each axis, a piecewise linear map between knots; parts beyond the first and last knot keep their size."""

    axes: tuple[Knots, Knots, Knots]

    def along(self, axis: int, places: Floats) -> Floats:
        """[N] new positions on an axis."""
        old, new = self.axes[axis].old, self.axes[axis].new
        outside = np.where(places < old[0], places - old[0] + new[0], places - old[-1] + new[-1])
        return np.where((places < old[0]) | (places > old[-1]), outside, np.interp(places, old, new))

    def moved(self, surface: Surface) -> Surface:
        """A stretched surface, cut at inner knots, so that points on an edge stay on it."""
        for axis, knots in enumerate(self.axes):
            for at in knots.old[1:-1].tolist():
                surface = sliced(surface, axis, at, SNAP)
        return surface.moved(np.stack([self.along(axis, surface.points[:, axis]) for axis in range(3)], axis=1))


def row_knots(old: Floats, new: Floats) -> Knots:
    """Knots at lines of rows: the two lowest rows and the highest one stay rows, those between them share the change.

    So a ground floor, or a cornice above it, ends at the same height in a corner as in the units beside it.

    Args:
        old: [R + 1] lines of the example's rows, metres.
        new: [S + 1] new lines, metres.
    """
    kept = min(len(old), len(new)) - 2
    lowest = min(2, (kept + 1) // 2)
    highest = min(1, kept - lowest)
    places = [0, *range(1, lowest + 1), *range(-1 - highest, -1), -1]
    return Knots(old[places], new[places])
