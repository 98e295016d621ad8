"""Units and the rest of closed examples as closed solids: cuts have faces, so that neighbours touch without gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from manifold3d import Manifold, Mesh64

from grammarlab.facade.examples.analysis.example import Example, Region
from grammarlab.facade.examples.building.stock import UnitStock
from grammarlab.facade.examples.building.units import SNAP
from grammarlab.facade.examples.mesh.slicing import sliced
from grammarlab.facade.examples.mesh.solids import solid_of, surface_of
from grammarlab.facade.examples.mesh.surface import Floats, Surface
from grammarlab.facade.examples.mesh.views import placed_from, seen_from

_CUT = 1_000_000_000
"""Material of the faces of cuts, until they get a material of their piece."""
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
_SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
_FACES = np.array([each for a, b, c, d in _SIDES for each in ((a, b, c), (a, c, d))], dtype=np.uint64)
"""[12, 3] triangles of a box, rows of `_CORNERS`, seen from outside."""


@dataclass(frozen=True, eq=False)
class BuildingParts:
    """Units and the rest of a building; closed if the examples are."""

    stock: UnitStock
    solids: tuple[Manifold, ...]
    """For each wall, all of its units as one solid; none if an example is open."""
    rest: Surface
    """The rest of the first example, in the coordinates of the building."""

    def cell(self, wall: int, row: int, column: int) -> Surface:
        """The unit in a cell of a wall, in the coordinates of its view."""
        if not self.solids:
            return self.stock.cut.cells[wall][row][column]
        region = self.stock.walls[wall]
        low, high = region.cell(row, column)
        found = _painted(self.solids[wall] ^ _box_before(region, low, high))
        return found.moved(seen_from(region.side, found.points))


def parts_of(examples: Sequence[Example], stock: UnitStock) -> BuildingParts:
    """The units and the rest: as solids if all examples are closed, else open where they were cut."""
    solids: list[Manifold] = []
    rest, num_colors = stock.cut.rest, 0
    for number, example in enumerate(examples):
        solid = solid_of(replace(example.surface, material=example.surface.material + num_colors))
        num_colors += len(example.mesh.colors)
        if solid is None:
            return BuildingParts(stock, (), stock.cut.rest)
        for region in example.regions if number == 0 else [example.main]:
            own, solid = solid.split(_box_before(region, region.low, region.high))
            solids.append(own)
        if number == 0:
            rest = _painted(solid)
    return BuildingParts(stock, tuple(solids), rest)


def halves(surface: Surface, axis: int, at: float) -> list[Surface]:
    """The parts of a surface on both sides of a plane across an axis; closed if the surface is."""
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    if not low[axis] + SNAP < at < high[axis] - SNAP:
        return [surface]
    solid = solid_of(surface)
    if solid is None:
        surface = sliced(surface, axis, at, SNAP)
        below = surface.points[surface.triangles, axis].mean(axis=1) < at
        return [surface.part(below), surface.part(~below)]
    low, high = low - 1.0, high + 1.0
    low[axis] = at
    return [_painted(each) for each in solid.split(_box(low, high)) if not each.is_empty()]


def _box_before(region: Region, low: Floats, high: Floats) -> Manifold:
    """The box of a rectangle in a wall, as deep as its units."""
    ends = placed_from(region.side, np.array([[*low, region.back], [*high, region.front]]))
    return _box(ends.min(axis=0), ends.max(axis=0))


def _box(low: Floats, high: Floats) -> Manifold:
    points = low + _CORNERS * (high - low)
    return Manifold(Mesh64(points, _FACES, face_id=np.full(len(_FACES), _CUT, dtype=np.uint64)))


def _painted(solid: Manifold) -> Surface:
    """The surface of a piece; faces of cuts get the material of most of its other area."""
    surface = surface_of(solid)
    cut = surface.material == _CUT
    if not cut.any():
        return surface
    a, b, c = surface.corners().swapaxes(0, 1)
    area = np.where(cut, 0.0, np.linalg.norm(np.cross(b - a, c - a), axis=1))
    usual = np.bincount(np.where(cut, 0, surface.material), weights=area).argmax()
    return replace(surface, material=np.where(cut, usual, surface.material))
