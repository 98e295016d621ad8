"""A solved grid of units as a stochastic grammar: facades of other sizes with its rows and columns."""

from __future__ import annotations

import numpy as np

from grammarlab.facade.examples.building.assembly import Tiling
from grammarlab.facade.examples.building.grammar import Terminal, Written, unit_body
from grammarlab.facade.examples.building.stock import UnitStock
from grammarlab.facade.examples.grammar import Units, write_label_family
from grammarlab.facade.writing.family import Range, WrittenFamily


def unit_family(stock: UnitStock, tiling: Tiling, widths: Range, heights: Range) -> tuple[WrittenFamily, Written]:
    """The family of a new wall, and the same rules with the meshes that they insert.

    Args:
        stock: units of the wall.
        tiling: the wall.
        widths: least and largest width of facades, metres.
        heights: least and largest height, metres.

    Raises:
        FacadeError: If no facade of the family has such a size.
    """
    terminals: list[Terminal] = []
    bodies = []
    for label in range(len(tiling.grid.names)):
        source = _source(stock, tiling, label)
        bodies.append(unit_body(stock.cut, stock.walls, source, stock.colors, terminals) if source else "NIL")
    units = Units(np.diff(tiling.columns), np.diff(tiling.rows), tuple(bodies))
    family = write_label_family(tiling.grid, units, widths, heights)
    return family, Written(family.text, tuple(terminals))


def _source(stock: UnitStock, tiling: Tiling, label: int) -> list[int] | None:
    """The unit of most cells with a label; if there is none, that of a wall; None for a name without a unit."""
    used = tiling.sources[tiling.grid.labels == label]
    if len(used):
        units, often = np.unique(used, axis=0, return_counts=True)
        return units[often.argmax()].tolist()
    wall = next((each for each in stock.choice if (stock.walls[each].grid.labels == label).any()), None)
    return None if wall is None else [wall, *stock.walls[wall].source(label)]
