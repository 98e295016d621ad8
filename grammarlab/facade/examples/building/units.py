"""A building cut into the units of its regions and the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grammarlab.facade.examples.analysis.example import Region
from grammarlab.facade.examples.mesh.slicing import sliced
from grammarlab.facade.examples.mesh.surface import Bools, Floats, Surface
from grammarlab.facade.examples.mesh.views import plane_of, seen_from

SNAP = 1e-6
"""Distance from a cutting plane within which points are moved onto it, metres."""


@dataclass(frozen=True, eq=False)
class BuildingCut:
    """A building in pieces that together make it up."""

    cells: tuple[tuple[tuple[Surface, ...], ...], ...]
    """[regions][rows][columns] the surface in each cell, in the coordinates of its view."""
    rest: Surface
    """The surface outside of all cells, in the coordinates of the building."""


def cut_up(surface: Surface, regions: Sequence[Region]) -> BuildingCut:
    """The units of all regions, and the rest; overlaps of regions belong to the earlier one."""
    for region in regions:
        surface = _framed(surface, region)
    cells = []
    for region in regions:
        own = _inside(surface, region)
        part = surface.part(own)
        surface = surface.part(~own)
        cells.append(_cells(part.moved(seen_from(region.side, part.points)), region))
    return BuildingCut(tuple(cells), surface)


def _framed(surface: Surface, region: Region) -> Surface:
    """The surface cut along the sides of a region, where these cross it."""
    planes = [plane_of(region.side, axis, float(end[axis])) for axis in (0, 1) for end in (region.low, region.high)]
    planes.append(plane_of(region.side, 2, region.back))
    for plane in planes:
        surface = sliced(surface, plane.axis, plane.at, SNAP)
    return surface


def _inside(surface: Surface, region: Region) -> Bools:
    middle = seen_from(region.side, surface.points)[surface.triangles].sum(axis=1) / 3.0
    flat = (middle[:, :2] > region.low) & (middle[:, :2] < region.high)
    return flat.all(axis=1) & (middle[:, 2] >= region.back) & (middle[:, 2] <= region.front)


def _cells(part: Surface, region: Region) -> tuple[tuple[Surface, ...], ...]:
    """[rows][columns] the part cut along the lines of the region."""
    rows = []
    for row in _strips(part, 1, region.rows.line):
        rows.append(tuple(_strips(row, 0, region.columns.line)))
    return tuple(rows)


def _strips(part: Surface, axis: int, line: Floats) -> list[Surface]:
    """The part cut along lines: the middle one first, so that each half is cut only along its own lines."""
    if len(line) < 3:
        return [part]
    middle = len(line) // 2
    part = sliced(part, axis, float(line[middle]), SNAP)
    below = part.points[part.triangles, axis].mean(axis=1) < line[middle]
    return [*_strips(part.part(below), axis, line[: middle + 1]), *_strips(part.part(~below), axis, line[middle:])]
