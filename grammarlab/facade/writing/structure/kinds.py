"""Kinds of columns and rows of a facade that look alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from grammarlab.facade.looks import is_door
from grammarlab.facade.tree import Facade, X, Y
from grammarlab.facade.writing.structure.bands import SAME_PLACE, Band, bands
from grammarlab.facade.writing.structure.cells import Cell, alike, cell_of, nodes_between
from grammarlab.facade.writing.structure.repeats import repeated_runs

WALL_STRETCH = 1.0 / 3.0
"""Largest relative difference of walls between equal elements."""


@dataclass(frozen=True, slots=True)
class KindSequence:
    """The bands of a facade along one axis."""

    kind: tuple[int, ...]
    """[B] kind of each band, numbered by first occurrence."""
    size: tuple[float, ...]
    """[K] size of each kind, metres: that of its first band of elements, or the mean of bands of wall."""
    stands: tuple[bool, ...]
    """[K] whether it contains elements."""
    doors: tuple[bool, ...]
    """[K] whether it contains doors."""
    ends: tuple[int, ...] = ()
    """Kinds at an end, which never follow themselves."""
    edges: tuple[float, ...] = ()
    """[B + 1] bounds of the bands of a facade, metres; empty for a pattern without a facade."""


@dataclass(frozen=True, slots=True)
class KindPattern:
    """A facade as columns and rows of kinds."""

    columns: KindSequence
    rows: KindSequence
    """Rows from the bottom up."""
    cells: tuple[tuple[Cell, ...], ...]
    """[row kinds][column kinds] content at each crossing."""


def pattern_of(facade: Facade, stretch: float) -> KindPattern:
    """The pattern of a facade.

    Args:
        facade: the facade.
        stretch: largest relative difference of equal elements.
    """
    across, up = bands(facade, X), bands(facade, Y)
    joined = _joined(across, _column_kinds(across, _cells(facade, across, up), stretch))
    while len(joined) < len(across):
        across = joined
        joined = _joined(across, _column_kinds(across, _cells(facade, across, up), stretch))
    cells = _cells(facade, across, up)
    columns = _column_kinds(across, cells, stretch)
    rows = _kinds(up, stretch, lambda a, b: all(map(alike, cells[a], cells[b], [stretch] * len(across))))
    first_column = [columns.index(kind) for kind in range(max(columns) + 1)]
    first_row = [rows.index(kind) for kind in range(max(rows) + 1)]
    return KindPattern(
        _sequence(columns, across, [[row[place] for row in cells] for place in first_column]),
        _sequence(rows, up, [cells[place] for place in first_row]),
        tuple(tuple(cells[row][column] for column in first_column) for row in first_row),
    )


def _cells(facade: Facade, across: list[Band], up: list[Band]) -> list[list[Cell]]:
    """[rows][columns] content at each crossing of bands."""
    least = (SAME_PLACE * facade.size[0]).tolist()
    cells = []
    for row in up:
        nodes = nodes_between(facade, Y, row.start, row.end, least[Y])
        corners = [((column.start, row.start), (column.end, row.end)) for column in across]
        cells.append([cell_of(facade, nodes, low, high, least) for low, high in corners])
    return cells


def _column_kinds(across: list[Band], cells: list[list[Cell]], stretch: float) -> list[int]:
    return _kinds(across, stretch, lambda a, b: all(alike(row[a], row[b], stretch) for row in cells))


def _joined(found: list[Band], kinds: list[int]) -> list[Band]:
    """The bands, with each repeated group of several columns, such as a bay of windows, merged into one."""
    for run in repeated_runs(kinds):
        if sum(band.stands for band in found[run.start : run.start + run.period]) > 1:
            turns = range(run.start, run.end, run.period)
            bays = [Band(found[k].start, found[k + run.period - 1].end, stands=True) for k in turns]
            return [*found[: run.start], *bays, *found[run.end :]]
    return found


def _kinds(found: list[Band], stretch: float, same: Callable[[int, int], bool]) -> list[int]:
    """[B] the kind of each band. Walls may differ more in size, but each wall at an end has its own kind."""
    kinds: list[int] = []
    first: list[int] = []
    """The first band of each kind."""
    ends = {0, len(found) - 1}
    for place, band in enumerate(found):
        for earlier in first:
            other = found[earlier]
            if band.stands != other.stands or (not band.stands and (place in ends or earlier in ends)):
                continue
            differ = stretch if band.stands else WALL_STRETCH
            if abs(band.size - other.size) <= differ * max(band.size, other.size) and same(earlier, place):
                kinds.append(kinds[earlier])
                break
        else:
            kinds.append(len(first))
            first.append(place)
    return kinds


def _sequence(kinds: list[int], found: list[Band], cells: list[list[Cell]]) -> KindSequence:
    """The bands as kinds, with the cells of the first of each."""
    size, stands = [], []
    for kind in range(max(kinds) + 1):
        those = [band for band, of in zip(found, kinds, strict=True) if of == kind]
        stands.append(those[0].stands)
        size.append(those[0].size if those[0].stands else sum(band.size for band in those) / len(those))
    doors = [any(is_door(thing) for cell in column for thing in cell.things()) for column in cells]
    edges = (found[0].start, *(band.end for band in found))
    return KindSequence(tuple(kinds), tuple(size), tuple(stands), tuple(doors), edges=edges)
