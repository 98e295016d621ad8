"""A grid of units as a stochastic CGA grammar: its rows and columns in other numbers and the same orders."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import FacadeError
from grammarlab.facade.grammar.contents import Cell
from grammarlab.facade.grammar.family import Around, Range, WrittenFamily, write_pattern
from grammarlab.facade.grammar.walks import KindPattern, KindSequence
from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import LEAF
from grammarlab.synthesis.label_grid import LabelGrid, Labels
from grammarlab.synthesis.labels.ground_floor import ground_labels

_DIGITS = 6


@dataclass(frozen=True, slots=True)
class Units:
    """Units in the cells of a grid."""

    widths: NDArray[np.float64]
    """[columns] widths, metres."""
    heights: NDArray[np.float64]
    """[rows] heights, metres, from the bottom up."""
    bodies: tuple[str, ...]
    """For each unit, CGA that makes it in its scope, such as ``i("unit-3.glb")``."""
    unit: Labels | None = None
    """[rows, columns] unit of each cell; its label if left out."""


def write_label_family(
    grid: LabelGrid,
    units: Units,
    widths: Range,
    heights: Range,
    around: Callable[[KindSequence], Around] | None = None,
) -> WrittenFamily:
    """The family of a grid, as rules whose every derivation is a facade of its rows and columns.

    Columns are a Markov chain with the transition frequencies of the grid. The first and the last stay at the ends; the
    lowest and the highest row stay in place, and runs of rows between them are repeated any number of times. A unit
    that occurs once on the ground floor, such as its door, occurs once in every facade.

    Args:
        grid: an example, or a result of synthesis; without holes.
        units: units in its cells.
        widths: least and largest width of facades, metres.
        heights: least and largest height, metres.
        around: function that makes the building around facades from the rows of the grid.

    Raises:
        FacadeError: If there are holes, sizes or bodies do not fit the grid, or no facade is within the ranges.
    """
    pattern, bodies = label_pattern(grid, units)
    outside = around(pattern.rows) if around else None
    return write_pattern(pattern, widths, heights, lambda cell: bodies[cell.label], outside)


def label_pattern(grid: LabelGrid, units: Units) -> tuple[KindPattern, dict[str, str]]:
    """The rows and columns of a grid in kinds, and the CGA of each element by its label.

    Columns are of one kind if their labels are equal, and rows if their units are equal: bands run along rows. The
    first and the last have kinds of their own.

    Raises:
        FacadeError: If there are holes, or sizes or bodies do not fit the grid.
    """
    _check(grid, units)
    once = [label for label, alone in ground_labels([grid]) if alone]
    door = np.isin(grid.labels, once)
    columns, column = _lines(grid.labels.T, units.widths, np.any(door, axis=0))
    unit_grid = grid.labels if units.unit is None else units.unit
    rows, row = _lines(unit_grid[:, column], units.heights, np.any(door, axis=1))
    names = _unit_names(grid, unit_grid, len(units.bodies))
    cells = tuple(tuple(Cell(names[unit_grid[r, c]], LEAF, ()) for c in column) for r in row)
    return KindPattern(columns, rows, cells), dict(zip(names, units.bodies, strict=True))


def _unit_names(grid: LabelGrid, unit_grid: Labels, num_units: int) -> list[str]:
    """A name for each unit: its label, with a number if that is taken.

    Labels of walls, which are stretched and joined, get another name.
    """
    label = np.arange(num_units)
    label[unit_grid.ravel()] = grid.labels.ravel()
    names: list[str] = []
    for unit in label.tolist():
        name = f"unit {unit}" if look_of(grid.names[unit]).is_flexible else grid.names[unit]
        free = (f"{name} {k}" for k in count(2))
        names.append(
            name if name not in names else next(alternative for alternative in free if alternative not in names)
        )
    return names


def _lines(labels: Labels, sizes: NDArray[np.float64], door: NDArray[np.bool_]) -> tuple[KindSequence, list[int]]:
    """Classes of equal lines, with classes of their own for both end lines; and the first line of each class."""
    kinds: list[int] = []
    first: list[int] = []
    class_index: dict[tuple[int, bytes], int] = {}
    for index, line in enumerate(labels):
        end = 1 if index == 0 else 2 if index == len(labels) - 1 else 0
        key = (end, np.ascontiguousarray(line).tobytes())
        if key not in class_index:
            class_index[key] = len(first)
            first.append(index)
        kinds.append(class_index[key])
    size = tuple(float(sizes[index]) for index in first)
    doors = tuple(bool(door[index]) for index in first)
    ends = (kinds[0], kinds[-1]) if len(kinds) > 1 else ()
    return KindSequence(tuple(kinds), size, (True,) * len(first), doors, ends), first


def _check(grid: LabelGrid, units: Units) -> None:
    if (grid.labels < 0).any():
        raise FacadeError("labels: a grammar needs a label in every cell; fill the holes first.")
    _fits("widths", units.widths, grid.columns)
    _fits("heights", units.heights, grid.rows)
    if units.unit is None and len(units.bodies) != len(grid.names):
        raise FacadeError(f"units: expected {len(grid.names)} bodies, one for each label; found {len(units.bodies)}.")


def _fits(name: str, sizes: Sequence[float] | NDArray[np.float64], count: int) -> None:
    values = np.asarray(sizes, dtype=np.float64)
    if values.shape != (count,) or not (np.isfinite(values) & (values > 0.0)).all():
        raise FacadeError(f"units: expected {count} {name} above 0 metres, found {values.tolist()}.")
