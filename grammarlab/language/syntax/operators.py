"""Precedence of CGA's operators: one table for the parser and the formatter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from grammarlab.errors import Location
from grammarlab.language.syntax.tree import Binary, BinaryOperator, Expression, Floating

_LEVELS = (("||",), ("&&",), ("==", "!="), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/", "%"))
"""Operators by increasing precedence; all are left-associative."""

BINARY_PRECEDENCE: dict[str, int] = {
    dot + operator: level for level, operators in enumerate(_LEVELS, 1) for operator in operators for dot in ("", ".")
}
FLOATING_PRECEDENCE = 0
"""``~`` applies to the whole size: ``~a * b`` is about ``a * b``."""
PREFIX_PRECEDENCE = len(_LEVELS) + 1
POSTFIX_PRECEDENCE = PREFIX_PRECEDENCE + 1


def span(first: Location, last: Location) -> Location:
    """From the beginning of one place to the end of another, or to the end of the first line."""
    if last.line != first.line or last.column < first.column:
        return first
    return Location(first.line, first.column, last.column + last.length - first.column, first.file)


def group_operands(operands: Sequence[Expression], operators: Sequence[str]) -> Expression:
    """Tree of ``operands[0] operators[0] operands[1] …`` (precedence climbing with two stacks)."""
    first = operands[0]
    if isinstance(first, Floating) and operators:
        inner = group_operands([first.operand, *operands[1:]], operators)
        return Floating(inner, location=span(first.location, inner.location))
    values = [first]
    pending: list[str] = []

    def reduce() -> None:
        right, left = values.pop(), values.pop()
        operator = cast(BinaryOperator, pending.pop())
        values.append(Binary(operator, left, right, location=span(left.location, right.location)))

    for operator, operand in zip(operators, operands[1:], strict=True):
        while pending and BINARY_PRECEDENCE[pending[-1]] >= BINARY_PRECEDENCE[operator]:
            reduce()
        pending.append(operator)
        values.append(operand)
    while pending:
        reduce()
    return values[0]
