"""Pieces of a building to one surface: welded, with common points along seams, closed where unlike units meet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammarlab.facade.examples.analysis.views import Plane, plane_of
from grammarlab.facade.examples.building.assembly import Tiling
from grammarlab.facade.examples.building.caps import capped
from grammarlab.facade.examples.building.conforming import conformed
from grammarlab.facade.examples.building.surface import Surface, num_boundary_edges, welded, without_slivers

TOLERANCE = 1e-5
"""Metres: of points on seams, and the width of T-junctions that may remain."""


def seams(tilings: Sequence[Tiling]) -> list[Plane]:
    """The planes where the pieces of a building meet."""
    planes = []
    for tiling in tilings:
        side = tiling.region.side
        planes += [plane_of(side, 0, float(at)) for at in tiling.columns]
        planes += [plane_of(side, 1, float(at)) for at in tiling.rows]
        planes.append(plane_of(side, 2, tiling.region.back - tiling.region.plane + tiling.plane))
    order = {(each.axis, round(each.at, 6)): each for each in planes}
    return [order[key] for key in sorted(order)]


def closed(surface: Surface, planes: Sequence[Plane]) -> Surface:
    """The surface of pieces [T] that stand side by side; its seams are closed as far as the pieces are."""
    surface = conformed(welded(surface, TOLERANCE), planes, TOLERANCE)
    if num_boundary_edges(surface):
        surface = conformed(welded(capped(surface, planes, TOLERANCE), TOLERANCE), planes, TOLERANCE)
    return without_slivers(rounded(surface), TOLERANCE / 10.0)


def rounded(surface: Surface) -> Surface:
    """The surface with coordinates that 32-bit floating point numbers have, as files keep them."""
    return welded(surface.moved(surface.points.astype(np.float32).astype(np.float64)), TOLERANCE / 10.0)
