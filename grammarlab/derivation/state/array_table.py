"""CGA's arrays as integers: a column of arrays is a column of ids into one table.

An array has rows and columns of numbers, truth values or strings; one written without semicolons has one row.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.state.operators import number_text
from grammarlab.derivation.state.shapes import Value
from grammarlab.errors import BudgetError, Location

MAX_CELLS = 100_000
"""Largest number of cells of an array."""
MAX_CELLS_IN_ALL = 5_000_000
"""Largest number of cells of all different arrays of one derivation."""

Cell: TypeAlias = "float | bool | str"
DEFAULTS: dict[str, Cell] = {"float": 0.0, "bool": False, "string": ""}
"""Default value of missing cells, by the type of the others."""


class Table(NamedTuple):
    """One array."""

    kind: str
    """``float``, ``bool`` or ``string``."""
    rows: int
    columns: int
    cells: tuple[Cell, ...]
    """Cells row by row."""

    def text(self) -> str:
        r"""The text that ``print`` shows: several rows with the cells of each column aligned at their ends.

        >>> Table("float", 1, 3, (1.0, 2.5, 3.0)).text(), Table("string", 2, 2, ("a", "b", "cd", "e")).text()
        ('(3)[1,2.5,3]', '(2x2)\n    a   b\n   cd   e')
        """
        texts = [cell_text(cell) for cell in self.cells]
        if self.rows == 1:
            return f"({self.columns})[{','.join(texts)}]"
        widths = [3 + max(map(len, texts[column :: self.columns])) for column in range(self.columns)]
        rows = [texts[first : first + self.columns] for first in range(0, len(texts), self.columns)]
        lines = ["".join(text.rjust(width) for text, width in zip(row, widths, strict=True)) for row in rows]
        return "\n".join([f"({self.rows}x{self.columns})", *lines])


class ArrayTable:
    """The different arrays of one derivation."""

    def __init__(self) -> None:
        self._ids: dict[tuple[object, ...], int] = {}
        self._tables: list[Table] = []
        self._cells = 0

    def __getitem__(self, index: int) -> Table:
        return self._tables[index]

    def ids(self, tables: Sequence[Table]) -> NDArray[np.uint32]:
        """Ids of several arrays, new or known.

        Raises:
            BudgetError: If all together would have more cells than `MAX_CELLS_IN_ALL`.
        """
        return np.array([self._id(table) for table in tables], dtype=np.uint32)

    def _id(self, table: Table) -> int:
        index = self._ids.get(table)
        if index is None:
            self._cells += len(table.cells)
            if self._cells > MAX_CELLS_IN_ALL:
                raise BudgetError(f"all arrays together would have more than {MAX_CELLS_IN_ALL:,} cells")
            index = self._ids[table] = len(self._tables)
            self._tables.append(table)
        return index


def cell_text(cell: Cell) -> str:
    """Text of a cell in strings of CGA."""
    return cell if isinstance(cell, str) else str(cell).lower() if isinstance(cell, bool) else number_text(cell)


def table_of(kind: str, rows: int, columns: int, cells: Sequence[Cell], location: Location) -> Table:
    """An array of bounded size.

    Raises:
        BudgetError: If it has more cells than `MAX_CELLS`.
    """
    if rows * columns > MAX_CELLS:
        raise BudgetError(f"an array would have {rows * columns:,} cells, more than {MAX_CELLS:,}", location)
    return Table(kind, rows, columns, tuple(cells))


def is_table(value: Value) -> bool:
    """Whether a value is a column of arrays."""
    return isinstance(value, np.ndarray) and value.dtype.kind == "u"
