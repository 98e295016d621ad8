"""Constants between a score and a grammar: each is described, and their number may only fall."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import grammarlab

PACKAGE = Path(grammarlab.__file__).parent
ROOMS = ("preference", "tastes", "learning", "features", "density")
MOST = 244
"""Largest number of constants. 120 is the target: a prior, a tolerance or a budget that nothing else implies."""
MOST_UNNAMED = 77
"""Largest number of lines inside of functions with other numbers than small whole ones and halves: tolerances of
rounding, sizes of caches and formats, and a dozen choices of a search, such as the weights it starts with."""


def numbers(node: ast.AST) -> Iterator[ast.Constant]:
    """Numbers of an expression, without those that only choose one of other constants."""
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        yield node
    if isinstance(node, ast.JoinedStr):
        return
    for child in ast.iter_child_nodes(node):
        if not (isinstance(node, ast.Subscript) and child is node.slice):
            yield from numbers(child)


def names(node: ast.stmt) -> list[str]:
    """Names of the constants that a statement defines by numbers."""
    if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None or not any(numbers(node.value)):
        return []
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    parts = [part for target in targets for part in (target.elts if isinstance(target, ast.Tuple) else [target])]
    return [part.id for part in parts if isinstance(part, ast.Name) and part.id.isupper()]


def is_text(node: ast.stmt | None) -> bool:
    """Whether a statement is a description."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def constants(file: Path) -> Iterator[tuple[str, bool]]:
    """Constants of a module, and whether each is described."""
    body = ast.parse(file.read_text(encoding="utf-8")).body
    for node, after in zip(body, [*body[1:], None], strict=True):
        yield from ((name, is_text(after)) for name in names(node))


def inside(tree: ast.Module) -> Iterator[int]:
    """Lines inside of functions with numbers that have no name.

    Not counted are small whole numbers (how many operands something has), halves, and what stands in a text, an index
    or a doctest. Numbers of arithmetic, such as the 12 of the variance of an even distribution, are counted.
    """
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.Lambda))
    parts = (part for function in functions for part in (function.body, function.args) if part)
    nodes = (node for part in parts for node in (part if isinstance(part, list) else [part]))
    return iter(sorted({number.lineno for node in nodes for number in numbers(node) if is_tuned(number.value)}))


def is_tuned(value: object) -> bool:
    """Whether a number may be a choice."""
    return not (isinstance(value, int | float) and (value == 0.5 or (value == int(value) and abs(value) <= 4)))


def test_numbers_inside_of_functions_are_counted():
    lines = [
        "def f(x, y=7):",
        "    z = x[9] + 2.0 * y + 0.5 - 4",
        "    return f'{z:9}', g(lambda v: 1e-6 * v), z - 0.7",
    ]
    assert list(inside(ast.parse("\n".join(["A = 9.5", *lines])))) == [2, 4]


def test_constants_are_counted():
    body = ast.parse("A = 1.0\nB = A[0]\n_C, D = 1, 2\nE: int = len(A)\nf = 3\nG = (A, -2.5)\nH = -A[1:3]").body
    assert [name for node in body for name in names(node)] == ["A", "_C", "D", "G"]


def test_constants_between_a_score_and_a_grammar_are_few_and_described():
    files = [file for room in ROOMS for file in sorted((PACKAGE / room).rglob("*.py"))]
    found = [(f"{file.relative_to(PACKAGE)}: {name}", told) for file in files for name, told in constants(file)]
    # What rooms below these define for them counts as well.
    found += [(f"arrays.py: {name}", told) for name, told in constants(PACKAGE / "arrays.py") if name[0] != "_"]
    assert [name for name, told in found if not told] == []
    assert len(found) <= MOST, "\n".join(name for name, _ in found)
    unnamed = [
        f"{file.relative_to(PACKAGE)}:{line}"
        for file in files
        for line in inside(ast.parse(file.read_text(encoding="utf-8")))
    ]
    assert len(unnamed) <= MOST_UNNAMED, "\n".join(unnamed)
