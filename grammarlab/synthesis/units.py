"""Buildings cut into the units of their regions and the rest.

Units of several examples have common labels, materials and file names. The rest is stretched along each axis at the
units of the main walls, and moved elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.arrays import Flags, Floats
from grammarlab.synthesis.analysis.example import Example, Region
from grammarlab.synthesis.label_grid import LabelGrid, joined, unnumbered
from grammarlab.synthesis.mesh.surface import Color, Surface, sliced
from grammarlab.synthesis.mesh.views import plane_of, seen_from

SNAP = 1e-6
"""Distance from a cutting plane within which points are moved onto it, metres."""
_SIZE_TOLERANCE_M, _DEPTH_TOLERANCE_M = 0.02, 0.03
"""Largest differences of the elements of equal units of two examples, metres; wider with noise."""
_NOISE_FACTOR = 4.0
"""Multiple of the noise by which these differences are wider."""
_MIN_WALL_SHARE = 0.5
"""Least share that is left of the wall around elements in a smaller cell; with less, elements become smaller, too."""
_EQUAL_SIZE_M = 1e-6
"""Difference of cells up to which they are equally large, metres."""


@dataclass(frozen=True, eq=False)
class BuildingCut:
    """A building in pieces that together make it up."""

    cells: tuple[tuple[tuple[Surface, ...], ...], ...]
    """[regions][rows][columns] the surface in each cell, in the coordinates of its view."""
    rest: Surface
    """The surface outside of all cells, in the coordinates of the building."""


@dataclass(frozen=True, eq=False)
class UnitStock:
    """Walls and their units."""

    walls: tuple[Region, ...]
    """All walls of the first example, the main one first; then the main wall of each other example."""
    cut: BuildingCut
    """Cells of all walls, and the rest of the first example."""
    choice: tuple[int, ...]
    """For each example, the index of the wall that gives the units of the main wall."""
    colors: tuple[Color, ...]
    """Colors of materials."""

    @property
    def grids(self) -> list[LabelGrid]:
        """The grid of each example's main wall."""
        return [self.walls[wall].grid for wall in self.choice]


@dataclass(frozen=True, slots=True)
class Knots:
    """Positions on an axis and their new positions; the map between them is linear, and what is beyond them moves."""

    old: Floats
    """[K] ascending positions, metres."""
    new: Floats
    """[K] ascending new positions, metres."""

    def at(self, positions: Floats) -> Floats:
        """[N] new positions of some on the axis, metres."""
        old, new = self.old, self.new
        outside = np.where(positions < old[0], positions - old[0] + new[0], positions - old[-1] + new[-1])
        return np.where((positions < old[0]) | (positions > old[-1]), outside, np.interp(positions, old, new))


@dataclass(frozen=True, slots=True)
class Stretch:
    """For each axis, a piecewise linear map between knots; parts beyond the first and last knot keep their size."""

    axes: tuple[Knots, Knots, Knots]

    def along(self, axis: int, positions: Floats) -> Floats:
        """[N] new positions on an axis."""
        return self.axes[axis].at(positions)

    def moved(self, surface: Surface) -> Surface:
        """A stretched surface, cut at inner knots, so that points on an edge stay on it."""
        for axis, knots in enumerate(self.axes):
            for position in knots.old[1:-1].tolist():
                surface = sliced(surface, axis, position, SNAP)
        return surface.moved(np.stack([self.along(axis, surface.points[:, axis]) for axis in range(3)], axis=1))


def cell_knots(region: Region, row: int, column: int, low: Floats, high: Floats) -> tuple[Knots, Knots]:
    """The map of a unit to another cell: elements, with what touches them, keep their size, and walls take the rest.

    A cell that is too small for this, or without elements, is scaled.

    Args:
        region: the wall of the unit.
        row: row of the unit.
        column: column of the unit.
        low: [2] lower left corner of the new cell, metres.
        high: [2] upper right corner, metres.
    """
    old_low, old_high = region.cell(row, column)
    boxes = region.whole_in(row, column)
    x, y = (
        _rigid_knots(boxes[:, [axis, axis + 2]], (old_low[axis], old_high[axis]), (low[axis], high[axis]))
        for axis in (0, 1)
    )
    return x, y


def _rigid_knots(parts: Floats, old: tuple[float, float], new: tuple[float, float]) -> Knots:
    """Knots between which some parts keep their size.

    Args:
        parts: [K, 2] starts and ends of the parts, metres.
        old: start and end of the cell, metres.
        new: start and end of the new cell, metres.
    """
    scaled = Knots(np.array(old), np.array(new))
    change = (new[1] - new[0]) - (old[1] - old[0])
    if abs(change) <= _EQUAL_SIZE_M or not len(parts):
        return scaled
    ends = np.unique(np.clip([*parts.ravel(), *old], *old))
    middle = (ends[1:] + ends[:-1]) / 2.0
    is_rigid = np.any((parts[:, :1] < middle) & (middle < parts[:, 1:]), axis=0)
    sizes = np.diff(ends)
    wall = float(sizes[~is_rigid].sum())
    if wall <= SNAP or wall + change < _MIN_WALL_SHARE * wall:
        return scaled
    sizes = np.where(is_rigid, sizes, sizes * (wall + change) / wall)
    return Knots(ends, np.array([new[0], *(new[0] + np.cumsum(sizes))[:-1], new[1]]))


def stock_of(examples: Sequence[Example]) -> UnitStock:
    """The units of examples.

    Units of two examples share a label if their names are equal and their elements agree: in size to 2 cm and in depth
    to 3 cm. Other units of equal names get different names.
    """
    first, *others = examples
    cut = cut_up(first.surface, first.regions)
    walls, cells, colors = list(first.regions), list(cut.cells), list(first.mesh.colors)
    choice = [0]
    for number, other in enumerate(others, start=2):
        surface = replace(other.surface, material=other.surface.material + len(colors))
        main = replace(other.main, name=f"{number}-{other.main.name}")
        cells.append(cut_up(surface, [main]).cells[0])
        colors += other.mesh.colors
        choice.append(len(walls))
        walls.append(main)
    stock = UnitStock(tuple(walls), BuildingCut(tuple(cells), cut.rest), tuple(choice), tuple(colors))
    return _named(stock) if others else stock


def cut_up(surface: Surface, regions: Sequence[Region]) -> BuildingCut:
    """The units of all regions, and the rest; overlaps of regions belong to the earlier one."""
    for region in regions:
        surface = _framed(surface, region)
    cells = []
    for region in regions:
        is_inside = _inside(surface, region)
        part = surface.part(is_inside)
        surface = surface.part(~is_inside)
        cells.append(_cells(part.moved(seen_from(region.side, part.points)), region))
    return BuildingCut(tuple(cells), surface)


def row_knots(old: Floats, new: Floats) -> Knots:
    """Knots at lines of rows: the two lowest rows and the highest one stay rows, those between them share the change.

    So a ground floor, or a cornice above it, ends at the same height in a corner as in the units beside it.

    Args:
        old: [R + 1] lines of the example's rows, metres.
        new: [S + 1] new lines, metres.
    """
    num_inner = min(len(old), len(new)) - 2
    lowest = min(2, (num_inner + 1) // 2)
    highest = min(1, num_inner - lowest)
    indices = [0, *range(1, lowest + 1), *range(-1 - highest, -1), -1]
    return Knots(old[indices], new[indices])


def _framed(surface: Surface, region: Region) -> Surface:
    """The surface cut along the sides of a region, where these cross it."""
    planes = [plane_of(region.side, axis, float(end[axis])) for axis in (0, 1) for end in (region.low, region.high)]
    planes.append(plane_of(region.side, 2, region.back))
    for plane in planes:
        surface = sliced(surface, plane.axis, plane.position, SNAP)
    return surface


def _inside(surface: Surface, region: Region) -> Flags:
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


def _named(stock: UnitStock) -> UnitStock:
    """The stock with one numbering of the labels of its main walls."""
    known_units: dict[str, tuple[int, int, int]] = {}
    walls = list(stock.walls)
    for wall in stock.choice:
        grid, names = walls[wall].grid, []
        reserved = {*known_units, *grid.names}
        for label, name in enumerate(grid.names):
            unit = (wall, *walls[wall].source(label)) if (grid.labels == label).any() else None
            # The name of another example is compared with window, window-2, window-3, ...
            head = unnumbered(name)
            namesakes = [
                candidate for candidate in known_units if candidate not in names and unnumbered(candidate) == head
            ]
            same = next(
                (candidate for candidate in namesakes if unit and _same(stock, known_units[candidate], unit)), None
            )
            if same is None and name in known_units:
                same = next(new for k in range(2, 10_000) if (new := f"{head}-{k}") not in reserved)
                reserved.add(same)
            names.append(same or name)
            if unit:
                known_units.setdefault(names[-1], unit)
        walls[wall] = replace(walls[wall], grid=LabelGrid(grid.labels, tuple(names)))
    for wall, grid in zip(stock.choice, joined([walls[index].grid for index in stock.choice]), strict=True):
        walls[wall] = replace(walls[wall], grid=grid)
    return replace(stock, walls=tuple(walls))


def _same(stock: UnitStock, first: tuple[int, int, int], second: tuple[int, int, int]) -> bool:
    """Whether two cells, given by wall, row and column, have equal elements."""
    noise = _NOISE_FACTOR * max(stock.walls[source[0]].noise for source in (first, second))
    sizes, depths = [], []
    for wall, row, column in (first, second):
        boxes = stock.walls[wall].elements_in(row, column)
        boxes = boxes[np.lexsort(boxes.T[::-1])]
        sizes.append(boxes[:, 2:] - boxes[:, :2])
        depth = stock.cut.cells[wall][row][column].points[:, 2] - stock.walls[wall].plane
        depths.append([depth.min(initial=0.0), depth.max(initial=0.0)])
    if len(sizes[0]) != len(sizes[1]) or np.abs(np.subtract(*depths)).max() > _DEPTH_TOLERANCE_M + noise:
        return False
    return bool((np.abs(sizes[0] - sizes[1]) <= _SIZE_TOLERANCE_M + noise).all())
