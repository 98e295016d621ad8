"""Constant arithmetic, and percentages that must sum to 100."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from grammarlab.language.checking.symbols import Remarks
from grammarlab.language.syntax.syntax_tree import Binary, Expression, Number, Stochastic, Unary

TOLERANCE = 1e-6
"""Largest difference from 100 that is accepted, since thirds are written with few digits."""


def constant(node: Expression) -> float | None:
    """Value of an expression of numbers; NaN if undefined, None if the expression is not constant."""
    match node:
        case Number(value=value):
            return value
        case Unary(operator="-", operand=operand):
            value = constant(operand)
            return None if value is None else -value
        case Binary(operator="+" | "-" | "*" | "/" as operator):
            left, right = constant(node.left), constant(node.right)
            if left is None or right is None:
                return None
            return _combine(operator, left, right)
    return None


def _combine(operator: str, left: float, right: float) -> float:
    if operator == "+":
        return left + right
    if operator == "-":
        return left - right
    if operator == "*":
        return left * right
    return left / right if right else math.nan


def weights_of_percentages(percentages: NDArray[np.float64], has_else: bool) -> NDArray[np.float64]:
    """Weights of branches [..., B]: their percentages; ``else`` has the rest to 100, at least 0.

    Args:
        percentages: [..., B] percentages in 0..100; 0 for ``else``.
        has_else: whether the last branch is ``else``.
    """
    if not has_else:
        return percentages
    rest = np.maximum(0.0, 100.0 - percentages.sum(axis=-1, keepdims=True))
    return np.concatenate([percentages[..., :-1], rest], axis=-1)


def probabilities(choice: Stochastic) -> tuple[float, ...] | None:
    """Probabilities of the branches of a choice, summing to 1; None if a percentage is not constant."""
    percentages = [0.0 if node is None else constant(node) for node in choice.percentages]
    if any(value is None or not value >= 0.0 for value in percentages):
        return None
    weights = weights_of_percentages(np.array(percentages, dtype=np.float64), choice.percentages[-1] is None)
    total = weights.sum()
    return tuple((weights / total).tolist()) if 0.0 < total < np.inf else None


def check_percentages(choice: Stochastic, remarks: Remarks) -> None:
    """Report percentages below 0, and constant percentages that do not sum to 100."""
    values = [constant(percentage) for percentage in choice.percentages if percentage is not None]
    for percentage, value in zip(choice.percentages, values, strict=False):
        if percentage is not None and value is not None and not value >= 0:
            message = f"expected a percentage of at least 0, found {value:g}"
            remarks.error("bad-percentage", percentage.location, message)
    constants = [value for value in values if value is not None]
    if len(constants) < len(values) or any(not value >= 0 for value in constants):
        return
    total = sum(constants)  # infinite if it is too large, where math.fsum raises
    has_else = choice.percentages[-1] is None
    excess = max(total - 100, 0) if has_else else abs(total - 100)
    if excess > TOLERANCE:
        expected = "at most 100 before 'else'" if has_else else "100"
        message = f"the percentages sum to {total:g}, expected {expected}"
        hint = "end with else : …, which gets the rest to 100" if total < 100 else "lower some of them"
        add = remarks.error if excess > 1 else remarks.warning
        add("percentages", choice.location, message, hint)
    elif has_else and total >= 100 - TOLERANCE:
        message = "this 'else' is never chosen: the percentages before it sum to 100"
        remarks.warning("empty-else", choice.branches[-1].location, message)
