"""A grid of units as a stochastic CGA grammar: its rows and columns in other numbers and the same orders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import FacadeError
from grammarlab.facade.examples.label_grid import LabelGrid, Labels
from grammarlab.facade.examples.labels.demands import ground_labels
from grammarlab.facade.looks import look_of
from grammarlab.facade.tree import LEAF
from grammarlab.facade.writing.family import Range, WrittenFamily, write_pattern
from grammarlab.facade.writing.rule_text import number
from grammarlab.facade.writing.structure.cells import Cell
from grammarlab.facade.writing.structure.kinds import KindPattern
from grammarlab.facade.writing.structure.kinds import KindSequence as Lines

_DIGITS = 6


@dataclass(frozen=True, slots=True)
class Units:
    """Units in the cells of a grid."""

    widths: NDArray[np.float64]
    """[columns] widths, metres."""
    heights: NDArray[np.float64]
    """[rows] heights, metres, from the bottom up."""
    bodies: tuple[str, ...]
    """By label: CGA that makes a unit in its scope, such as ``i("unit-3.glb")``."""


def inserted(name: str, depth: float) -> str:
    """CGA that inserts a mesh into the rectangle of its cell.

    >>> print(inserted("unit-3.glb", 0.35))
    s('1, '1, 0.35) i("unit-3.glb")
    """
    return f"s('1, '1, {number(depth, _DIGITS)}) i(\"{name}\")"


def write_label_family(grid: LabelGrid, units: Units, widths: Range, heights: Range) -> WrittenFamily:
    """The family of a grid, as rules whose every derivation is a facade of its rows and columns.

    Columns are a Markov chain with the transition frequencies of the grid. The first and the last stay at the ends; the
    lowest and the highest row stay in place, and runs of rows between them are repeated any number of times. A unit
    that occurs once on the ground floor, such as its door, occurs once in every facade.

    Args:
        grid: an example, or a result of synthesis; without holes.
        units: units in its cells.
        widths: least and largest width of facades, metres.
        heights: least and largest height, metres.

    Raises:
        FacadeError: If there are holes, sizes or bodies do not fit the grid, or no facade is within the ranges.
    """
    _check(grid, units)
    labels = grid.labels
    once = [label for label, alone in ground_labels([grid]) if alone]
    door = np.isin(labels, once)
    columns, column = _lines(labels.T, units.widths, np.any(door, axis=0))
    rows, row = _lines(labels, units.heights, np.any(door, axis=1))
    names = [_unit_name(name, label) for label, name in enumerate(grid.names)]
    cells = tuple(tuple(Cell(names[labels[r, c]], LEAF, ()) for c in column) for r in row)
    bodies = dict(zip(names, units.bodies, strict=True))
    return write_pattern(KindPattern(columns, rows, cells), widths, heights, lambda cell: bodies[cell.label])


def _unit_name(name: str, label: int) -> str:
    """The name of a unit: its label, or another name for the labels of walls, which are stretched and joined."""
    return f"unit {label}" if look_of(name).gives else name


def _lines(labels: Labels, sizes: NDArray[np.float64], door: NDArray[np.bool_]) -> tuple[Lines, list[int]]:
    """Classes of equal lines, with classes of their own for both end lines; and the first line of each class."""
    kinds: list[int] = []
    first: list[int] = []
    known: dict[tuple[int, bytes], int] = {}
    for place, line in enumerate(labels):
        end = 1 if place == 0 else 2 if place == len(labels) - 1 else 0
        key = (end, np.ascontiguousarray(line).tobytes())
        if key not in known:
            known[key] = len(first)
            first.append(place)
        kinds.append(known[key])
    size = tuple(float(sizes[place]) for place in first)
    doors = tuple(bool(door[place]) for place in first)
    ends = (kinds[0], kinds[-1]) if len(kinds) > 1 else ()
    return Lines(tuple(kinds), size, (True,) * len(first), doors, ends), first


def _check(grid: LabelGrid, units: Units) -> None:
    if (grid.labels < 0).any():
        raise FacadeError("labels: a grammar needs a label in every cell; fill the holes first.")
    _fits("widths", units.widths, grid.columns)
    _fits("heights", units.heights, grid.rows)
    if len(units.bodies) != len(grid.names):
        raise FacadeError(f"units: expected {len(grid.names)} bodies, one for each label; found {len(units.bodies)}.")


def _fits(name: str, sizes: Sequence[float] | NDArray[np.float64], count: int) -> None:
    values = np.asarray(sizes, dtype=np.float64)
    if values.shape != (count,) or not (np.isfinite(values) & (values > 0.0)).all():
        raise FacadeError(f"units: expected {count} {name} above 0 metres, found {values.tolist()}.")
