"""Expressions that make arrays, or take cells out of them, compiled to functions over columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from grammarlab.derivation.calls.arguments import all_values, argument, head
from grammarlab.derivation.calls.calls import BoundCall, Compiler
from grammarlab.derivation.calls.table_columns import column_of, for_each, texts_of
from grammarlab.derivation.functions.array_functions import counted, picked, written
from grammarlab.derivation.functions.cell_operators import for_cells, for_each_cell
from grammarlab.derivation.operations.comp import BLOCKS, SelectedComponents, select_components
from grammarlab.derivation.state.array_table import DEFAULTS, Cell, Table, is_table, table_of
from grammarlab.derivation.state.operators import concatenated
from grammarlab.derivation.state.shapes import ARRAY, NUM_LANES, SITE_LANE, Shapes, Value, as_column, kind_of
from grammarlab.derivation.state.workspace import Code, Workspace
from grammarlab.errors import DerivationError, Location
from grammarlab.language.syntax.builtins import blocks, functions
from grammarlab.language.syntax.syntax_tree import Array, Binary, Block, Components, Index, Number, Span, Unary
from grammarlab.randomness import fold

_GIVE_ARRAYS = frozenset({"setElems", "transpose"}) | frozenset(
    name for name, forms in functions().items() if all(kind.endswith("[]") for kind in forms[0].result)
)
"""Functions whose results are arrays, whatever their arguments are."""
_COMPONENT = 2**40
"""Numbers of components begin here among those of the random expressions that share a key with them."""


def compiled(compiler: Compiler, node: Array | Span | Index | Components) -> Code:
    """Code for an array, or for what is taken out of one."""
    match node:
        case Array():
            return _array(compiler, node)
        case Span():
            return _span(compiler, node)
        case Index():
            return _index(compiler, node)
    return _components(compiler, node)


def _array(compiler: Compiler, node: Array) -> Code:
    """Code for ``[a, b; c : d]``."""
    codes = [[compiler.expression(cell) for cell in row] for row in node.rows]
    lengths, location = [len(row) for row in codes], node.location

    def build(*cells: Cell | Table) -> Table:
        rest = list(cells)
        return written([[rest.pop(0) for _ in range(length)] for length in lengths], location)

    return _plainly([code for row in codes for code in row], build, location)


def _span(compiler: Compiler, node: Span) -> Code:
    """Code for ``a : step : b``."""
    step = Number(1.0, location=node.location) if node.step is None else node.step
    codes = [compiler.expression(part) for part in (node.first, step, node.last)]
    location = node.location
    return _plainly(codes, lambda first, step, last: counted(first, step, last, location), location)


def _index(compiler: Compiler, node: Index) -> Code:
    """Code for ``a[i]`` and ``a[row, column]``."""
    codes = [compiler.expression(part) for part in (node.array, *node.indices)]
    location = node.location
    return _plainly(codes, lambda array, *indices: picked(array, indices, location), location)


def _components(compiler: Compiler, node: Components) -> Code:
    """Code for ``comp(f) { front : a | all = b }`` where a value stands."""
    forms = [form for form in blocks()["comp"] if form.takes(len(node.arguments))]
    words = [frozenset[str]().union(*(f.parameters[i].keywords for f in forms)) for i in range(len(node.arguments))]
    arguments = all_values([argument(compiler, a, w) for a, w in zip(node.arguments, words, strict=True)])
    heads = all_values([head(compiler, part, -1, BLOCKS["comp"].selectors, 0) for part in node.parts])
    codes = [compiler.choice(part.body) for part in node.parts]
    location = node.location

    def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
        call = BoundCall(
            name="comp",
            shapes=shapes,
            arguments=arguments(shapes, workspace),
            origin=shapes,
            workspace=workspace,
            location=location,
        )
        selections, counts = select_components(call, heads(shapes, workspace))
        return _of_components(call, selections, counts, codes)

    return evaluate


def _of_components(
    call: BoundCall,
    selections: Sequence[SelectedComponents],
    counts: np.ndarray,
    codes: Sequence[Code],
) -> Value:
    """``comp(f) { front : a | side = b }``: for each shape [N] an array with one cell for each of its components.

    What no selector takes is 0, "" or false; with ``=`` all components of a selector have the value of the one shape
    that they make.

    Args:
        call: the function.
        selections: shapes of each part, and the components they are made of.
        counts: [N] components of each shape.
        codes: expression of each part, evaluated on its shapes.
    """
    workspace, location = call.workspace, call.location
    columns: list[np.ndarray] = []
    rows, indices = [], []
    for selection, code in zip(selections, codes, strict=True):
        shapes = selection.shapes
        if shapes.num == 0:
            continue
        word = NUM_LANES * (_COMPONENT + selection.number) + SITE_LANE
        keyed = shapes if shapes.key is None else shapes._replace(key=fold(shapes.key, word))
        columns.append(as_column(code(keyed, workspace), shapes.num, workspace.strings)[selection.new_shape])
        rows.append(selection.row)
        indices.append(selection.component)
    kinds = sorted({kind_of(column) for column in columns}) or ["float"]
    if len(kinds) > 1 or kinds == [ARRAY]:
        raise call.error(f"comp expects values of one type, found {' and '.join(kinds)}")
    kind = kinds[0]
    cells: list[list[Cell]] = [[DEFAULTS[kind]] * count for count in counts.tolist()]
    for column, row, index in zip(columns, rows, indices, strict=True):
        plain = [workspace.strings[i] for i in column.tolist()] if kind == "string" else column.tolist()
        for value, i, j in zip(plain, row.tolist(), index.tolist(), strict=True):
            cells[i][j] = value
    return column_of([table_of(kind, 1, len(line), line, location) for line in cells], workspace, location)


def cell_by_cell(compiler: Compiler, node: Unary | Binary) -> Code:
    """Code for an operator that begins with a dot."""
    sign, location = node.operator.removeprefix("."), node.location
    if isinstance(node, Unary):
        codes = [compiler.expression(node.operand)]
        return _plainly(codes, lambda value: for_each_cell(sign, value, location), location)
    codes = [compiler.expression(side) for side in (node.left, node.right)]
    return _plainly(codes, lambda left, right: for_cells(sign, left, right, location), location)


def makes_arrays(node: object) -> bool:
    """Whether a node of a syntax tree gives an array of itself."""
    if isinstance(node, Block):
        return node.name == "setbackPerEdge"
    if isinstance(node, Unary | Binary) and node.operator.startswith("."):
        return True
    name = getattr(node, "identifier", getattr(node, "function", ""))
    return isinstance(node, Array | Components) or name in _GIVE_ARRAYS


def binary(operator: str, left: Value, right: Value, workspace: Workspace, location: Location) -> Value:
    """``a == b``, ``a != b`` and ``"text" + a`` where one side is an array.

    Raises:
        DerivationError: for every other operator, and to compare an array with something else.
    """
    if operator == "+" and "string" in (kind_of(left), kind_of(right)):
        return concatenated(texts_of(left, workspace), texts_of(right, workspace), workspace.strings, location)
    if operator not in ("==", "!="):
        message = f"{operator} expects single values, found a {kind_of(left)} and a {kind_of(right)}"
        raise DerivationError(message, location, "take a cell of the array, as in a[0]")
    if not (is_table(left) and is_table(right)):
        message = f"{operator} compares values of one type, found a {kind_of(left)} and a {kind_of(right)}"
        raise DerivationError(message, location)
    equal = np.asarray(left) == np.asarray(right)
    return equal if operator == "==" else ~equal


def _plainly(codes: Sequence[Code], apply: Callable[..., Cell | Table], location: Location) -> Code:
    def evaluate(shapes: Shapes, workspace: Workspace) -> Value:
        return for_each([code(shapes, workspace) for code in codes], shapes.num, workspace, apply, location)

    return evaluate
