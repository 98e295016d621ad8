"""Functions over columns of arrays, evaluated once for each different combination of arguments.

The functions take plain Python values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.state.array_table import MAX_CELLS_IN_ALL, Cell, Table, is_table
from grammarlab.derivation.state.operators import value_texts
from grammarlab.derivation.state.shapes import ARRAY, Value, as_column, kind_of
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.errors import BudgetError, DerivationError, Location


def texts_of(value: Value, workspace: Workspace) -> str | NDArray[np.int32]:
    """Any value as a string, or as string ids [N]."""
    if not is_table(value):
        return value_texts(value, workspace.strings)
    different, inverse = np.unique(np.asarray(value), return_inverse=True)
    return workspace.strings.ids(workspace.tables[i].text() for i in different.tolist())[inverse]


def for_each(
    values: Sequence[Value], count: int, workspace: Workspace, apply: Callable[..., Cell | Table], location: Location
) -> Value:
    """Column [count] of a function of Python values, evaluated once for each different combination of values.

    Raises:
        DerivationError: If its results have different types.
        BudgetError: If they have more than `MAX_CELLS_IN_ALL` cells.
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
