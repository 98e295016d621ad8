"""A new building: units on other grids of labels, the rest stretched around them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.examples.analysis.example import Example, Region
from grammarlab.facade.examples.building.stretching import Stretch
from grammarlab.facade.examples.building.units import Cut
from grammarlab.facade.examples.label_grid import LabelGrid
from grammarlab.facade.examples.mesh.surface import Floats, Ints, Surface, joined
from grammarlab.facade.examples.mesh.views import placed_from, plane_of

_LEAST = 0.05
"""Metres that a cell is wide and high at least."""


@dataclass(frozen=True, eq=False)
class Tiling:
    """A region with other rows and columns."""

    region: Region
    grid: LabelGrid
    columns: Floats
    """[C + 1] metres, lines between columns in the coordinates of the view."""
    rows: Floats
    """[R + 1] metres."""
    plane: float
    """Metres towards the viewer, of the wall."""
    sources: Ints
    """[R, C, 2] row and column of the unit of the example that stands in each cell."""

    def cell(self, row: int, column: int) -> tuple[Floats, Floats]:
        """Lower left and upper right corner [2] of a cell, in metres."""
        return (
            np.array([self.columns[column], self.rows[row]]),
            np.array([self.columns[column + 1], self.rows[row + 1]]),
        )


def natural(region: Region, grid: LabelGrid) -> tuple[Floats, Floats]:
    """[C] widths and [R] heights: those of the unit that most cells of a column or row have, of equals the first."""
    sources = region.sources(grid)
    places = sources[..., 0] * len(region.columns) + sources[..., 1]
    columns = np.array([np.bincount(each).argmax() for each in places.T]) % len(region.columns)
    rows = np.array([np.bincount(each).argmax() for each in places]) // len(region.columns)
    return np.diff(region.columns.line)[columns], np.diff(region.rows.line)[rows]


def stretch_for(example: Example, grid: LabelGrid, box: tuple[float | None, float | None, float | None]) -> Stretch:
    """How the building is stretched for a grid of its main region.

    Args:
        example: the building.
        grid: of the main region.
        box: width, height and depth of the new building in metres; as the units make it where None.

    Raises:
        FacadeError: where the box leaves no room for units.
    """
    main = example.main
    beside = [each for each in example.regions if each.side % 2]
    points = example.surface.points
    extent = np.ptp(points, axis=0)
    low, high = np.array([*main.low, points[:, 2].min()]), np.array([*main.high, points[:, 2].max()])
    if beside:
        largest = max(beside, key=lambda each: len(each.elements))
        ends = sorted(plane_of(largest.side, 0, float(each[0])).at for each in (largest.low, largest.high))
        low[2], high[2] = ends
    width, height = natural(main, grid)
    size = np.array([width.sum(), height.sum(), high[2] - low[2]])
    for axis, wanted in enumerate(box):
        if wanted is not None:
            size[axis] = wanted - (extent[axis] - (high - low)[axis])
    least = np.array([grid.columns, grid.rows, 1]) * _LEAST
    for axis, name in enumerate(("width", "height", "depth")):
        if size[axis] < least[axis]:
            kept = extent[axis] - (high - low)[axis]
            raise FacadeError(
                f"--box: a {name} of {box[axis]:g} m has no room for the units; the rest keeps {kept:.2f} m of it, "
                f"and units need {least[axis]:.2f} m. Give more."
            )
    middle = (low + high) / 2.0
    new_low = np.array([middle[0] - size[0] / 2.0, low[1], middle[2] - size[2] / 2.0])
    return Stretch(low, high, new_low, new_low + size)


def place_of(region: Region, stretch: Stretch) -> tuple[Floats, Floats, float]:
    """Low and high corner [2] of a region in the new building, and the depth of its wall, in its view."""
    found = []
    for axis, ends in (
        (0, (region.low[0], region.high[0])),
        (1, (region.low[1], region.high[1])),
        (2, (region.plane,)),
    ):
        planes = [plane_of(region.side, axis, float(end)) for end in ends]
        new = [float(stretch.along(each.axis, np.array([each.at]))[0]) for each in planes]
        found.append([plane_of_view(region.side, axis, at) for at in new])
    low = np.array([found[0][0], found[1][0]])
    return low, np.array([found[0][1], found[1][1]]), found[2][0]


def plane_of_view(side: int, axis: int, at: float) -> float:
    """The coordinate in a view of a plane of the building across the axis of the building that the view's axis has."""
    sign = plane_of(side, axis, 1.0).at
    return at * sign


def counts_for(region: Region, stretch: Stretch) -> tuple[int, int]:
    """Rows and columns that fit where a region comes to lie."""
    low, high, _ = place_of(region, stretch)
    columns, rows = (high - low) / (region.high - region.low) * [len(region.columns), len(region.rows)]
    return max(1, round(float(rows))), max(1, round(float(columns)))


def tile(region: Region, grid: LabelGrid, stretch: Stretch) -> Tiling:
    """The rows and columns of a grid where a region comes to lie: in proportion to their natural sizes."""
    low, high, plane = place_of(region, stretch)
    lines = []
    for axis, sizes in enumerate(natural(region, grid)):
        part = np.concatenate([[0.0], np.cumsum(sizes)]) / sizes.sum()
        line = low[axis] + part * (high - low)[axis]
        line[-1] = high[axis]
        lines.append(line)
    return Tiling(region, grid, lines[0], lines[1], plane, region.sources(grid))


@dataclass(frozen=True, eq=False)
class Pieces:
    """All pieces of a new building where they stand, not yet stitched."""

    surface: Surface
    first: Ints
    """[N + 1] first point of each piece: of the rest, then of the cells of each tiling, row by row."""


def assemble(cut: Cut, tilings: Sequence[Tiling], stretch: Stretch) -> Pieces:
    """The pieces of the new building.

    Args:
        cut: the example in pieces.
        tilings: for each of its regions, in their order.
        stretch: of the rest.
    """
    pieces = [cut.rest.moved(stretch.points(cut.rest.points))]
    for cells, tiling in zip(cut.cells, tilings, strict=True):
        for row, column in np.ndindex(tiling.grid.labels.shape):
            source = tiling.sources[row, column].tolist()
            low, high = tiling.region.cell(*source)
            new_low, new_high = tiling.cell(row, column)
            unit = cells[source[0]][source[1]]
            points = np.empty_like(unit.points)
            part = (unit.points[:, :2] - low) / (high - low)
            # Both ends are exact, so that what meets at a line meets there.
            points[:, :2] = np.where(part == 1.0, new_high, new_low + part * (new_high - new_low))
            points[:, 2] = unit.points[:, 2] - tiling.region.plane + tiling.plane
            pieces.append(unit.moved(placed_from(tiling.region.side, points)))
    return Pieces(joined(pieces), np.cumsum([0, *(len(each.points) for each in pieces)]))
