"""Array literals, indexing, and sizes of arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import floor, isfinite

from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.calls.table_columns import for_each
from grammarlab.derivation.functions.array_editing import as_table
from grammarlab.derivation.state.array_table import DEFAULTS, MAX_CELLS, Cell, Table, table_of
from grammarlab.derivation.state.shapes import ARRAY, Value, kind_of
from grammarlab.errors import BudgetError, DerivationError, Location


def written(rows: Sequence[Sequence[Cell | Table]], location: Location) -> Table:
    """``[a, b; c, d]``: cells and arrays side by side, rows of them below each other.

    Raises:
        DerivationError: If cells have different types, or rows different lengths.
    """
    blocks = [_side_by_side([as_table(cell) for cell in row], location) for row in rows if row]
    blocks = [block for block in blocks if block.cells] or blocks[:1]
    if not blocks:
        return Table("float", 1, 0, ())
    first = blocks[0]
    if any(block.kind != first.kind or block.columns != first.columns for block in blocks):
        raise DerivationError("expected rows of one type and length in an array", location)
    cells = [cell for block in blocks for cell in block.cells]
    return table_of(first.kind, sum(block.rows for block in blocks), first.columns, cells, location)


def _side_by_side(tables: Sequence[Table], location: Location) -> Table:
    """Arrays of equal height, side by side."""
    filled = [table for table in tables if table.cells] or tables[:1]
    if len({(table.kind, table.rows) for table in filled}) > 1:
        raise DerivationError("expected cells of one type, and arrays of equal height, side by side", location)
    height = filled[0].rows
    cells = [
        cell
        for row in range(height)
        for table in filled
        for cell in table.cells[row * table.columns :][: table.columns]
    ]
    return table_of(filled[0].kind, height, sum(table.columns for table in filled), cells, location)


def counted(first: Cell | Table, step: Cell | Table, last: Cell | Table, location: Location) -> Table:
    """``first : step : last``: first, first + step, ... up to last; empty if the step points away from it.

    Raises:
        DerivationError: If one of them is not a finite number.
        BudgetError: If the array would be too large.
    """
    start, stride, end = (_number(value, location) for value in (first, step, last))
    if stride == 0.0 or (end - start) * stride < 0.0:
        return Table("float", 1, 0, ())
    steps = (end - start) / stride
    if steps >= MAX_CELLS:
        raise BudgetError(f"an array would have more than {MAX_CELLS:,} cells", location)
    count = floor(steps) + 1
    return Table("float", 1, count, tuple(start + i * stride for i in range(count)))


def _number(value: Cell | Table, location: Location) -> float:
    if isinstance(value, float) and not isinstance(value, bool) and isfinite(value):
        return value
    raise DerivationError(f"expected a finite number in an array's range, found {value}", location)


def picked(array: Cell | Table, indices: Sequence[Cell | Table], location: Location) -> Cell | Table:
    """``array[i]``, ``array[row, column]``: a cell, or an array if indices are arrays; 0, "" or false outside.

    One index counts cells row by row. Boolean indices select the cells, rows or columns that are true.
    """
    if not isinstance(array, Table):
        raise DerivationError("expected an array before '['", location)
    positions = [_positions(index, location) for index in indices]
    default = DEFAULTS[array.kind]
    if len(positions) == 1:
        cells = [array.cells[i] if 0 <= i < len(array.cells) else default for i in positions[0]]
        index = indices[0]
        if not isinstance(index, Table):
            return cells[0]
        rows, columns = (1, len(cells)) if index.kind == "bool" else (index.rows, index.columns)
        return table_of(array.kind, rows, columns, cells, location)
    down, across = positions
    if len(down) * len(across) > MAX_CELLS:
        raise BudgetError(f"an array would have {len(down) * len(across):,} cells", location)
    cells = [
        array.cells[i * array.columns + j] if 0 <= i < array.rows and 0 <= j < array.columns else default
        for i in down
        for j in across
    ]
    if not any(isinstance(index, Table) for index in indices):
        return cells[0]
    return Table(array.kind, len(down), len(across), tuple(cells))


def _positions(index: Cell | Table, location: Location) -> list[int]:
    cells = index.cells if isinstance(index, Table) else (index,)
    if isinstance(index, Table) and index.kind == "bool":
        return [i for i, cell in enumerate(cells) if cell]
    if any(isinstance(cell, str | bool) for cell in cells):
        raise DerivationError("expected numbers as indices of an array", location)
    return [round(float(cell)) if isfinite(float(cell)) else -1 for cell in cells]


def _measure(apply: Callable[[Table], float]) -> Builtin:
    def evaluate(call: FunctionCall) -> Value:
        if kind_of(call.arguments[0]) != ARRAY:
            message = f"{call.name} expected an array, found a {kind_of(call.arguments[0])}"
            raise DerivationError(message, call.location)
        return for_each(call.arguments, call.shapes.num, call.workspace, apply, call.location)

    return Builtin(evaluate, (1, 1), takes_arrays=True)


BUILTINS: dict[str, Builtin] = {
    "nColumns": _measure(lambda table: float(table.columns)),
    "nRows": _measure(lambda table: float(table.rows if table.cells else 0)),
    "size": _measure(lambda table: float(len(table.cells))),
}
