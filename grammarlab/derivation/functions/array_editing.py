"""Arrays changed as wholes: ``setElems``, ``transpose``, ``sum``, ``sortIndices``, conversions between types."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite

import numpy as np

from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.calls.table_columns import for_each
from grammarlab.derivation.functions.text_functions import is_true, items, joined, to_number
from grammarlab.derivation.state.array_table import DEFAULTS, MAX_CELLS, Cell, Table, cell_text, table_of
from grammarlab.derivation.state.shapes import Value
from grammarlab.errors import BudgetError, DerivationError, Location


def as_table(value: Cell | Table) -> Table:
    """An array; a single value is an array of one cell."""
    if isinstance(value, Table):
        return value
    kind = "bool" if isinstance(value, bool) else "string" if isinstance(value, str) else "float"
    return Table(kind, 1, 1, (value,))


def _rows_of(table: Table) -> list[tuple[Cell, ...]]:
    return [table.cells[first : first + table.columns] for first in range(0, len(table.cells), max(table.columns, 1))]


def _transposed(table: Table) -> Table:
    cells = tuple(table.cells[i * table.columns + j] for j in range(table.columns) for i in range(table.rows))
    return Table(table.kind, table.columns, table.rows, cells) if cells else table


def _sorted_order(values: Sequence[Cell] | Sequence[tuple[Cell, ...]]) -> list[int]:
    """Indices of values from the smallest to the largest; equal ones keep their order."""
    return sorted(range(len(values)), key=lambda index: values[index])


def _sort_indices(table: Table) -> Table:
    """``sortIndices(array)``: the indices of the cells of each row, sorted."""
    cells = [
        float(row * table.columns + index)
        for row, values in enumerate(_rows_of(table))
        for index in _sorted_order(values)
    ]
    return Table("float", table.rows, table.columns, tuple(cells))


def _sort_row_indices(table: Table) -> Table:
    """``sortRowIndices(array)``: the indices of the rows, sorted by their first cells, then by the next ones."""
    order = _sorted_order(_rows_of(table))
    return Table("float", 1, len(order), tuple(map(float, order)))


def _sum(table: Table) -> Cell:
    """``sum(array)``: numbers added, or strings joined, in order."""
    if table.kind == "string":
        return "".join(map(str, table.cells))
    # Left to right, since the last bits of other orders differ.
    total = 0.0
    for cell in table.cells:
        total += float(cell)
    return total


def _positions(index: Table, location: Location) -> list[int]:
    """Indices of the cells, rows or columns that an index names; -1 for those that are ignored."""
    if index.kind == "bool":
        return [number for number, cell in enumerate(index.cells) if cell]
    if index.kind == "string":
        raise DerivationError("setElems expects numbers or truth values as indices", location)
    return [round(float(cell)) if isfinite(float(cell)) else -1 for cell in index.cells]


def _set_elems(location: Location, array: Cell | Table, *rest: Cell | Table) -> Table:
    """``setElems(array, indices, values)``, ``setElems(array, rows, columns, values)``: an array with other cells.

    Negative indices are ignored, and indices behind the end enlarge the array by cells with 0, "" or false.
    """
    table, values = as_table(array), as_table(rest[-1])
    if table.cells and values.kind != table.kind:
        raise DerivationError(f"setElems expects values of the type {table.kind}, found {values.kind}", location)
    positions = [_positions(as_table(index), location) for index in rest[:-1]]
    if len(positions) == 1:
        places = [(None if index < 0 else index) for index in positions[0]]
        height, width = table.rows, table.columns
        last = max((index for index in places if index is not None), default=-1)
        if last >= height * width:
            # An array of one row grows along it, any other one by whole rows.
            height, width = (1, last + 1) if height <= 1 else (last // width + 1, width)
    else:
        down, across = positions
        height = max(table.rows, max(down, default=-1) + 1)
        width = max(table.columns, max(across, default=-1) + 1)
        places = [(i * width + j if i >= 0 and j >= 0 else None) for i in down for j in across]
    if len(values.cells) not in (1, len(places)):
        message = f"setElems expects one value, or one for each of {len(places)} cells, found {len(values.cells)}"
        raise DerivationError(message, location)
    if height * width > MAX_CELLS:
        raise BudgetError(f"an array would have {height * width:,} cells, more than {MAX_CELLS:,}", location)
    cells: list[Cell] = [DEFAULTS[values.kind]] * (height * width)
    for row, line in enumerate(_rows_of(table)):
        cells[row * width : row * width + len(line)] = line
    for place, value in zip(places, values.cells * (len(places) if len(values.cells) == 1 else 1), strict=False):
        if place is not None:
            cells[place] = value
    return Table(values.kind, height, width, tuple(cells))


def _of_arrays(apply: Callable[..., Cell | Table], least: int, most: int | None = None) -> Builtin:
    """A function whose arguments may be arrays or single values, called with the place of the call first."""

    def evaluate(call: FunctionCall) -> Value:
        def on(*values: Cell | Table) -> Cell | Table:
            return apply(call.location, *values)

        return for_each(call.arguments, call.shapes.num, call.workspace, on, call.location)

    return Builtin(evaluate, (least, least if most is None else most), takes_arrays=True)


def _of_array(apply: Callable[[Table], Cell | Table]) -> Builtin:
    return _of_arrays(lambda location, value: apply(as_table(value)), 1)


def _converted(kind: str, convert: Callable[[Cell], Cell]) -> Builtin:
    """``floatArray(values)`` and similar functions; without an argument, an empty array."""

    def apply(location: Location, value: Cell | Table | None = None) -> Table:
        if value is None:
            return Table(kind, 1, 0, ())
        table = as_table(value)
        return Table(kind, table.rows, table.columns, tuple(convert(cell) for cell in table.cells))

    def evaluate(call: FunctionCall) -> Value:
        if not call.arguments:
            return np.broadcast_to(call.workspace.tables.ids([apply(call.location)]), call.shapes.num).copy()
        return _of_arrays(apply, 1).evaluate(call)

    return Builtin(evaluate, (0, 1), takes_arrays=True)


def _find_first(location: Location, text: Cell | Table, sought: Cell | Table, start: Cell | Table = 0.0) -> float:
    """``findFirst(array, value, start)``: the index of the first equal cell; in a string, of the first such text."""
    if isinstance(sought, Table) or isinstance(start, Table | str):
        raise DerivationError("findFirst expects a single value to search for", location)
    first = max(0, int(start)) if isfinite(start) else 0
    if isinstance(text, Table):
        return float(next((i for i, cell in enumerate(text.cells) if i >= first and cell == sought), -1))
    if not isinstance(text, str) or not isinstance(sought, str):
        raise DerivationError("findFirst expected a string and a text in it, or an array and a value", location)
    return float(text.find(sought, first))


def _list_to_array(location: Location, text: Cell | Table) -> Table:
    parts = items(str(text))
    return table_of("string", 1, len(parts), parts, location)


BUILTINS: dict[str, Builtin] = {
    "boolArray": _converted("bool", lambda cell: is_true(cell) if isinstance(cell, str) else bool(cell)),
    "findFirst": _of_arrays(_find_first, 2, 3),
    "floatArray": _converted("float", lambda cell: to_number(cell) if isinstance(cell, str) else float(cell)),
    "listFromArray": _of_array(lambda table: joined([cell_text(cell) for cell in table.cells])),
    "listToArray": _of_arrays(_list_to_array, 1),
    "setElems": _of_arrays(_set_elems, 3, 4),
    "sortIndices": _of_array(_sort_indices),
    "sortRowIndices": _of_array(_sort_row_indices),
    "stringArray": _converted("string", cell_text),
    "sum": _of_array(_sum),
    "transpose": _of_array(_transposed),
}
