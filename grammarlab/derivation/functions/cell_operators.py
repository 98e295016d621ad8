"""Operators of CGA that begin with a dot: ``a .+ b``, ``a .== b``, ``.!a``, for each cell of arrays."""

from __future__ import annotations

import operator
from collections.abc import Callable

import numpy as np

from grammarlab.derivation.functions.array_editing import as_table
from grammarlab.derivation.state.array_table import Cell, Table, cell_text
from grammarlab.errors import DerivationError, Location


def _of_numbers(apply: np.ufunc) -> Callable[[float, float], float]:
    """A function of arrays for two numbers: division by 0 is infinite, as everywhere in CGA."""
    return lambda left, right: float(apply(np.array([left]), np.array([right]))[0])


_ARITHMETIC: dict[str, Callable[[float, float], Cell]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _of_numbers(np.divide),
    "%": _of_numbers(np.fmod),
}
_COMPARISONS: dict[str, Callable[[Cell, Cell], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_LOGIC: dict[str, Callable[[Cell, Cell], bool]] = {
    "&&": lambda left, right: bool(left and right),
    "||": lambda left, right: bool(left or right),
}


def for_cells(sign: str, left: Cell | Table, right: Cell | Table, location: Location) -> Table:
    """``a .+ b``: an array with the result for each cell; a single value stands for as many equal cells.

    Args:
        sign: the operator without its dot.
        left: left side.
        right: right side.
        location: place of the operator.

    Raises:
        DerivationError: If the arrays have different sizes, or cells of types that the operator does not take.
    """
    first, second = as_table(left), as_table(right)
    shape = first if isinstance(left, Table) else second
    if isinstance(left, Table) and isinstance(right, Table) and first[1:3] != second[1:3]:
        sizes = f"{first.rows} x {first.columns} and {second.rows} x {second.columns}"
        raise DerivationError(f".{sign} expects arrays of one size, found {sizes}", location)
    kind, apply = _operation(sign, first.kind, second.kind, location)
    count = len(shape.cells)
    lefts = first.cells if isinstance(left, Table) else first.cells * count
    rights = second.cells if isinstance(right, Table) else second.cells * count
    return Table(kind, shape.rows, shape.columns, tuple(apply(a, b) for a, b in zip(lefts, rights, strict=True)))


def _operation(sign: str, left: str, right: str, location: Location) -> tuple[str, Callable[..., Cell]]:
    """Type of the results and function of two cells, for an operator between cells of two types."""
    if sign == "+" and "string" in (left, right):
        return "string", lambda a, b: cell_text(a) + cell_text(b)
    if sign in _ARITHMETIC and left == right == "float":
        return "float", _ARITHMETIC[sign]
    if sign in _COMPARISONS and left == right and (left != "bool" or sign in ("==", "!=")):
        return "bool", _COMPARISONS[sign]
    if sign in _LOGIC and left == right == "bool":
        return "bool", _LOGIC[sign]
    raise DerivationError(f".{sign} does not take cells of the types {left} and {right}", location)


def for_each_cell(sign: str, value: Cell | Table, location: Location) -> Table:
    """``.-a``, ``.+a``, ``.!a``: an array with the result for each cell.

    Raises:
        DerivationError: If the cells have another type.
    """
    table = as_table(value)
    expected = "bool" if sign == "!" else "float"
    if table.kind != expected:
        raise DerivationError(f".{sign} expects cells of the type {expected}, found {table.kind}", location)
    cells = tuple(not cell if sign == "!" else -float(cell) if sign == "-" else cell for cell in table.cells)
    return table._replace(cells=cells)
