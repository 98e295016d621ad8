"""CGA's arrays as integers: a column of arrays is a column of ids into one pool.

An array has rows and columns of numbers, truth values or strings; one written without semicolons has one row. Whatever
is done with arrays is done once for each different combination of arguments, on plain Python values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.operators import number_text, value_texts
from grammarlab.derivation.shapes import ARRAY, Value, as_column, kind_of
from grammarlab.errors import BudgetError, DerivationError, Location

if TYPE_CHECKING:
    from grammarlab.derivation.workspace import Workspace

MAX_CELLS = 100_000
"""Cells of the largest array."""
MAX_CELLS_IN_ALL = 5_000_000
"""Cells of all different arrays of one derivation."""

Cell: TypeAlias = "float | bool | str"
DEFAULTS: dict[str, Cell] = {"float": 0.0, "bool": False, "string": ""}
"""What stands where there is no cell, by the type of the others."""


class Table(NamedTuple):
    """One array."""

    kind: str
    """``float``, ``bool`` or ``string``."""
    rows: int
    columns: int
    cells: tuple[Cell, ...]
    """Row by row."""

    def text(self) -> str:
        r"""As ``print`` shows it.

        >>> Table("float", 1, 3, (1.0, 2.5, 3.0)).text(), Table("string", 2, 1, ("a", "b")).text()
        ('(3)[1,2.5,3]', '(2x1)\na\nb')
        """
        texts = [cell_text(cell) for cell in self.cells]
        if self.rows == 1:
            return f"({self.columns})[{','.join(texts)}]"
        lines = ["\t".join(texts[first : first + self.columns]) for first in range(0, len(texts), self.columns)]
        return "\n".join([f"({self.rows}x{self.columns})", *lines])


class TablePool:
    """The different arrays met in one derivation."""

    def __init__(self) -> None:
        self._ids: dict[tuple[object, ...], int] = {}
        self._tables: list[Table] = []
        self._cells = 0

    def __getitem__(self, index: int) -> Table:
        return self._tables[index]

    def ids(self, tables: Sequence[Table]) -> NDArray[np.uint32]:
        """The ids of several arrays, new or known.

        Raises:
            BudgetError: all together would have more cells than `MAX_CELLS_IN_ALL`.
        """
        return np.array([self._id(table) for table in tables], dtype=np.uint32)

    def _id(self, table: Table) -> int:
        known = self._ids.get(table)
        if known is None:
            self._cells += len(table.cells)
            if self._cells > MAX_CELLS_IN_ALL:
                raise BudgetError(f"all arrays together would have more than {MAX_CELLS_IN_ALL:,} cells")
            known = self._ids[table] = len(self._tables)
            self._tables.append(table)
        return known


def cell_text(cell: Cell) -> str:
    """A cell as CGA writes it into strings."""
    return cell if isinstance(cell, str) else str(cell).lower() if isinstance(cell, bool) else number_text(cell)


def table_of(kind: str, rows: int, columns: int, cells: Sequence[Cell], location: Location) -> Table:
    """An array of bounded size.

    Raises:
        BudgetError: it has more cells than `MAX_CELLS`.
    """
    if rows * columns > MAX_CELLS:
        raise BudgetError(f"an array would have {rows * columns:,} cells, more than {MAX_CELLS:,}", location)
    return Table(kind, rows, columns, tuple(cells))


def is_table(value: Value) -> bool:
    """Whether a value is a column of arrays."""
    return isinstance(value, np.ndarray) and value.dtype.kind == "u"


def texts_of(value: Value, workspace: Workspace) -> str | NDArray[np.int32]:
    """Any value as a string, or as string ids [N]."""
    if not is_table(value):
        return value_texts(value, workspace.strings)
    different, which = np.unique(np.asarray(value), return_inverse=True)
    return workspace.strings.ids(workspace.tables[i].text() for i in different.tolist())[which]


def for_each(
    values: Sequence[Value], count: int, workspace: Workspace, apply: Callable[..., Cell | Table], location: Location
) -> Value:
    """A function of Python values applied to each different combination of values; the column [count] it gives.

    Raises:
        DerivationError: when it gives results of different types.
        BudgetError: when they have more than `MAX_CELLS_IN_ALL` cells.
    """
    columns = [as_column(value, count, workspace.strings) for value in values]
    table = np.stack([column.astype(np.float64) for column in columns], axis=1) if columns else np.zeros((count, 0))
    unique, inverse = np.unique(table, axis=0, return_inverse=True) if columns else (table[:1], np.zeros(count, int))
    kinds = [kind_of(column) for column in columns]
    results: list[Cell | Table] = []
    cells = 0
    for row in unique.tolist():
        result = apply(*(_plain(kind, number, workspace) for kind, number in zip(kinds, row, strict=True)))
        cells += len(result.cells) if isinstance(result, Table) else 0
        if cells > MAX_CELLS_IN_ALL:
            raise BudgetError(f"all arrays together would have more than {MAX_CELLS_IN_ALL:,} cells", location)
        results.append(result)
    return column_of(results, workspace, location)[inverse.ravel()]


def column_of(results: Sequence[Cell | Table], workspace: Workspace, location: Location) -> NDArray:
    """Python values of one type as a column."""
    kinds = sorted({_kind(result) for result in results})
    if len(kinds) > 1:
        raise DerivationError(f"expected values of one type, found {' and '.join(kinds)}", location)
    tables = [result for result in results if isinstance(result, Table)]
    if tables:
        return workspace.tables.ids(tables)
    if kinds == ["string"]:
        return workspace.strings.ids(str(result) for result in results)
    return np.array(results, dtype=bool if kinds == ["bool"] else np.float64)


def _plain(kind: str, number: float, workspace: Workspace) -> Cell | Table:
    if kind == "string":
        return workspace.strings[int(number)]
    if kind == ARRAY:
        return workspace.tables[int(number)]
    return bool(number) if kind == "bool" else number


def _kind(result: Cell | Table) -> str:
    if isinstance(result, Table):
        return ARRAY
    return "bool" if isinstance(result, bool) else "string" if isinstance(result, str) else "float"
