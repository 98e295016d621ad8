"""Units of one or several examples, with common labels, materials and file names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from grammarlab.facade.examples.analysis.example import Example, Region
from grammarlab.facade.examples.building.units import BuildingCut, cut_up
from grammarlab.facade.examples.label_grid import LabelGrid, joined

_SAME_SIZE, _SAME_DEPTH = 0.02, 0.03
"""Largest differences of the elements of equal units of two examples, metres; wider with noise."""
_NOISES = 4.0


@dataclass(frozen=True, eq=False)
class UnitStock:
    """Walls and their units."""

    walls: tuple[Region, ...]
    """All walls of the first example, the main one first; then the main wall of each other example."""
    cut: BuildingCut
    """Cells of all walls, and the rest of the first example."""
    choice: tuple[int, ...]
    """For each example, the index of the wall that gives the units of the main wall."""
    colors: tuple[tuple[float, float, float, float], ...]
    """Colors of materials."""

    @property
    def grids(self) -> list[LabelGrid]:
        """The grid of each example's main wall."""
        return [self.walls[each].grid for each in self.choice]


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


def _named(stock: UnitStock) -> UnitStock:
    """The stock with one numbering of the labels of its main walls."""
    seen: dict[str, tuple[int, int, int]] = {}
    walls = list(stock.walls)
    for wall in stock.choice:
        grid, names = walls[wall].grid, []
        taken = {*seen, *grid.names}
        for label, name in enumerate(grid.names):
            unit = (wall, *walls[wall].source(label)) if (grid.labels == label).any() else None
            # The name of another example is compared with window, window-2, window-3, ...
            head = _head(name)
            alike = [each for each in seen if each not in names and _head(each) == head]
            same = next((each for each in alike if unit and _same(stock, seen[each], unit)), None)
            if same is None and name in seen:
                same = next(new for k in range(2, 10_000) if (new := f"{head}-{k}") not in taken)
                taken.add(same)
            names.append(same or name)
            if unit:
                seen.setdefault(names[-1], unit)
        walls[wall] = replace(walls[wall], grid=LabelGrid(grid.labels, tuple(names)))
    for wall, grid in zip(stock.choice, joined([walls[each].grid for each in stock.choice]), strict=True):
        walls[wall] = replace(walls[wall], grid=grid)
    return replace(stock, walls=tuple(walls))


def _head(name: str) -> str:
    """The name of a label without its distinguishing number."""
    head, _, number = name.rpartition("-")
    return head if head and number.isdigit() else name


def _same(stock: UnitStock, one: tuple[int, int, int], other: tuple[int, int, int]) -> bool:
    """Whether two cells, given by wall, row and column, have equal elements."""
    noise = _NOISES * max(stock.walls[each[0]].noise for each in (one, other))
    sizes, depths = [], []
    for wall, row, column in (one, other):
        boxes = stock.walls[wall].elements_in(row, column)
        boxes = boxes[np.lexsort(boxes.T[::-1])]
        sizes.append(boxes[:, 2:] - boxes[:, :2])
        depth = stock.cut.cells[wall][row][column].points[:, 2] - stock.walls[wall].plane
        depths.append([depth.min(initial=0.0), depth.max(initial=0.0)])
    if len(sizes[0]) != len(sizes[1]) or np.abs(np.subtract(*depths)).max() > _SAME_DEPTH + noise:
        return False
    return bool((np.abs(sizes[0] - sizes[1]) <= _SAME_SIZE + noise).all())
