"""A new building: units on other grids of labels, the rest stretched around them; and its walls as facades."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.reading.annotation import annotate
from grammarlab.facade.reading.assembling import assemble as assemble_boxes
from grammarlab.facade.tree import Facade
from grammarlab.synthesis.analysis.example import OUTSIDE, Example, Region
from grammarlab.synthesis.label_grid import LabelGrid, unnumbered
from grammarlab.synthesis.mesh.surface import Surface, joined
from grammarlab.synthesis.mesh.views import placed_from, plane_of
from grammarlab.synthesis.units import BuildingCut, Knots, Stretch, cell_knots, row_knots

_MIN_CELL_M = 0.05
"""Least width and height of a cell, metres."""


@dataclass(frozen=True, eq=False)
class Tiling:
    """A region with new rows and columns."""

    region: Region
    walls: tuple[Region, ...]
    """Walls that the units come from."""
    grid: LabelGrid
    columns: Floats
    """[C + 1] lines between columns in the coordinates of the view, metres."""
    rows: Floats
    """[R + 1] lines between rows, metres."""
    plane: float
    """Depth of the wall, metres towards the viewer."""
    sources: Ints
    """[R, C, 3] source of the unit in each cell: index in `walls`, row and column."""

    @property
    def depths(self) -> tuple[float, float]:
        """Least and largest depth of all units, relative to the plane, metres."""
        used = [self.walls[wall] for wall in np.unique(self.sources[..., 0])]
        return min(region.back - region.plane for region in used), max(region.front - region.plane for region in used)

    def cell(self, row: int, column: int) -> tuple[Floats, Floats]:
        """Lower left and upper right corner [2] of a cell, in metres."""
        return (
            np.array([self.columns[column], self.rows[row]]),
            np.array([self.columns[column + 1], self.rows[row + 1]]),
        )


@dataclass(frozen=True, eq=False)
class UnstitchedPieces:
    """All pieces of a new building in place, not yet stitched."""

    surface: Surface
    first: Ints
    """[N + 1] first point of each piece: of the rest, then of the cells of each tiling, row by row."""


def sources_of(walls: Sequence[Region], choice: Sequence[int], grid: LabelGrid, regions: Ints | None = None) -> Ints:
    """[R, C, 3] wall, row and column of the unit for each cell of a grid.

    Args:
        walls: walls with units, labelled like the grid.
        choice: indices of walls whose units may be used; the first with a label is used for it.
        grid: labels of the new grid.
        regions: [R, C] index in `choice` of the preferred wall of each cell.
    """
    cache: dict[tuple[int, int, tuple[int, int, int, int]], tuple[int, int, int]] = {}
    sources = np.zeros((*grid.labels.shape, 3), dtype=np.int64)
    framed = np.pad(grid.labels, 1, constant_values=OUTSIDE).tolist()
    for row, column in np.ndindex(grid.labels.shape):
        label, first = int(grid.labels[row, column]), 0 if regions is None else int(regions[row, column])
        middle = framed[row + 1]
        key = label, first, (framed[row][column + 1], framed[row + 2][column + 1], middle[column], middle[column + 2])
        if key not in cache:
            wall = next(
                candidate for candidate in (choice[first], *choice) if (walls[candidate].grid.labels == label).any()
            )
            cache[key] = (wall, *walls[wall].source(label, key[2]))
        sources[row, column] = cache[key]
    return sources


def stretch_for(
    example: Example, sizes: tuple[Floats, Floats], box: tuple[float | None, float | None, float | None]
) -> Stretch:
    """The stretch of the building for a grid of its main region.

    Args:
        example: the building.
        sizes: widths of columns and heights of rows of the grid.
        box: width, height and depth of the new building, metres; None for those that follow from the units.

    Raises:
        FacadeError: If the box leaves no room for units.
    """
    main = example.main
    side_walls = [region for region in example.regions if region.side % 2]
    points = example.surface.points
    extent = np.ptp(points, axis=0)
    low, high = np.array([*main.low, points[:, 2].min()]), np.array([*main.high, points[:, 2].max()])
    if side_walls:
        largest = max(side_walls, key=lambda region: len(region.elements))
        ends = sorted(plane_of(largest.side, 0, float(corner[0])).position for corner in (largest.low, largest.high))
        low[2], high[2] = ends
    width, height = sizes
    size = np.array([width.sum(), height.sum(), high[2] - low[2]])
    for axis, length in enumerate(box):
        if length is not None:
            size[axis] = length - (extent[axis] - (high - low)[axis])
    least = np.array([len(width), len(height), 1]) * _MIN_CELL_M
    for axis, name in enumerate(("width", "height", "depth")):
        if size[axis] < least[axis]:
            rest = extent[axis] - (high - low)[axis]
            raise FacadeError(
                f"`box=`: a {name} of {box[axis]:g} m has no room for the units; the rest takes {rest:.2f} m of it, "
                f"and units need {least[axis]:.2f} m. Use a larger box."
            )
    middle = (low + high) / 2.0
    new_low = np.array([middle[0] - size[0] / 2.0, low[1], middle[2] - size[2] / 2.0])
    new_high = new_low + size
    across, deep = (
        Knots(np.array([low[axis], high[axis]]), np.array([new_low[axis], new_high[axis]])) for axis in (0, 2)
    )
    rows = new_low[1] + np.concatenate([[0.0], np.cumsum(height)]) / height.sum() * size[1]
    return Stretch((across, row_knots(main.rows.line, rows), deep))


def counts_for(region: Region, stretch: Stretch) -> tuple[int, int]:
    """Number of rows and columns that fit into the bounds of a region in the new building."""
    low, high, _ = _region_bounds(region, stretch)
    columns, rows = (high - low) / (region.high - region.low) * [len(region.columns), len(region.rows)]
    return max(1, round(float(rows))), max(1, round(float(columns)))


def tile(walls: Sequence[Region], region_index: int, grid: LabelGrid, sources: Ints, stretch: Stretch) -> Tiling:
    """The rows and columns of a grid in the new bounds of a region: in proportion to their natural sizes.

    Args:
        walls: walls that the units come from.
        region_index: index of the region in `walls`.
        grid: new labels.
        sources: [R, C, 3] the unit in each cell.
        stretch: stretch of the building.
    """
    region = walls[region_index]
    low, high, plane = _region_bounds(region, stretch)
    lines = []
    for axis, sizes in enumerate(natural(walls, sources)):
        part = np.concatenate([[0.0], np.cumsum(sizes)]) / sizes.sum()
        line = low[axis] + part * (high - low)[axis]
        line[-1] = high[axis]
        lines.append(line)
    return Tiling(
        region=region, walls=tuple(walls), grid=grid, columns=lines[0], rows=lines[1], plane=plane, sources=sources
    )


def natural(walls: Sequence[Region], sources: Ints) -> tuple[Floats, Floats]:
    """[C] widths and [R] heights: those of a line's most frequent unit, the first of equally frequent ones."""
    widths = [np.diff(walls[wall].columns.line)[column] for wall, _, column in _most(sources.swapaxes(0, 1))]
    heights = [np.diff(walls[wall].rows.line)[row] for wall, row, _ in _most(sources)]
    return np.array(widths), np.array(heights)


def assemble(cut: BuildingCut, tilings: Sequence[Tiling], stretch: Stretch) -> UnstitchedPieces:
    """The pieces of the new building.

    Args:
        cut: the example in pieces, with the cells of all walls that units come from.
        tilings: one for each of the example's regions, in their order.
        stretch: stretch of the rest.
    """
    pieces = [stretch.moved(cut.rest)]
    for tiling in tilings:
        for row, column in np.ndindex(tiling.grid.labels.shape):
            unit = unit_in(cut, tiling, row, column)
            pieces.append(unit.moved(placed_from(tiling.region.side, unit.points)))
    return UnstitchedPieces(joined(pieces), np.cumsum([0, *(len(piece.points) for piece in pieces)]))


def unit_in(cut: BuildingCut, tiling: Tiling, row: int, column: int) -> Surface:
    """The unit in a cell of a tiling, in the coordinates of the view.

    Both ends are exact, so that pieces that meet at a line have equal coordinates there.
    """
    wall, source_row, source_column = tiling.sources[row, column].tolist()
    region = tiling.walls[wall]
    unit = cut.cells[wall][source_row][source_column]
    depths = np.array([region.plane, region.plane + 1.0])
    moved = Knots(depths, depths - region.plane + tiling.plane)
    return Stretch((*cell_knots(region, source_row, source_column, *tiling.cell(row, column)), moved)).moved(unit)


def facade_of(region: Region) -> Facade:
    """The wall of an example."""
    boxes, names = [], []
    for row, column in np.ndindex(region.grid.labels.shape):
        elements = region.elements_in(row, column)
        boxes.append(elements)
        names += [unnumbered(region.grid.names[int(region.grid.labels[row, column])])] * len(elements)
    return _facade(np.concatenate(boxes), names, region.wall)


def facade_of_tiling(tiling: Tiling, stretch: Stretch) -> Facade:
    """The wall of a new building."""
    region, boxes, names = tiling.region, [], []
    for row, column in np.ndindex(tiling.grid.labels.shape):
        label = int(tiling.grid.labels[row, column])
        number, source_row, source_column = tiling.sources[row, column].tolist()
        source = tiling.walls[number]
        x, y = cell_knots(source, source_row, source_column, *tiling.cell(row, column))
        corners = source.elements_in(source_row, source_column).reshape(-1, 2)
        boxes.append(np.stack([x.at(corners[:, 0]), y.at(corners[:, 1])], axis=1).reshape(-1, 4))
        names += [unnumbered(tiling.grid.names[label])] * len(boxes[-1])
    wall = np.array(
        [[_stretched(region.side, axis, float(corner[axis]), stretch) for axis in (0, 1)] for corner in region.wall]
    )
    return _facade(np.concatenate(boxes), names, wall)


def _region_bounds(region: Region, stretch: Stretch) -> tuple[Floats, Floats, float]:
    """Low and high corner [2] of a region in the new building, and the depth of its wall, in its view."""
    bounds = []
    for axis, ends in (
        (0, (region.low[0], region.high[0])),
        (1, (region.low[1], region.high[1])),
        (2, (region.plane,)),
    ):
        bounds.append([_stretched(region.side, axis, float(end), stretch) for end in ends])
    low = np.array([bounds[0][0], bounds[1][0]])
    return low, np.array([bounds[0][1], bounds[1][1]]), bounds[2][0]


def _stretched(side: int, axis: int, coordinate: float, stretch: Stretch) -> float:
    """New coordinate of a plane across an axis of the view from a side, metres."""
    plane = plane_of(side, axis, coordinate)
    sign = plane_of(side, axis, 1.0).position
    return float(stretch.along(plane.axis, np.array([plane.position]))[0]) * sign


def _most(lines: Ints) -> list[tuple[int, int, int]]:
    """The most frequent unit of each line [L, N, 3], the first in its wall of equally frequent ones."""
    sources = []
    for line in lines:
        units, counts = np.unique(line, axis=0, return_counts=True)
        wall, row, column = units[counts.argmax()].tolist()
        sources.append((wall, row, column))
    return sources


def _facade(boxes: Floats, names: list[str], wall: Floats) -> Facade:
    low = np.minimum(wall[0], boxes.reshape(-1, 2).min(axis=0, initial=np.inf))
    high = np.maximum(wall[1], boxes.reshape(-1, 2).max(axis=0, initial=-np.inf))
    bounds = np.stack([np.zeros(2), high - low])
    everything = np.vstack([[0.0, 0.0, *(high - low)], boxes - np.tile(low, 2)])
    annotation = annotate(everything, ["wall", *names], "metres", bounds=bounds)
    try:
        return assemble_boxes(annotation, split=True).facade
    except FacadeError:
        # Elements that no straight cut divides: each is shown without the rest of its tree.
        return assemble_boxes(annotate(everything[:1], ["wall"], "metres", bounds=bounds)).facade
