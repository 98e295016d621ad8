"""Expressions as texts that need no definitions, for files that hold one expression."""

from __future__ import annotations

from grammarlab.errors import UsageError
from grammarlab.features.expression import FUNCTIONS, MAX_CHARACTERS, Apply, ConstantTerm, Expression, Step
from grammarlab.features.patterns.pattern import Threshold

_ZERO = ConstantTerm(0.0)


def plain_text(expression: Expression) -> str:
    """A text of an expression in which the parts stand instead of their names.

    Raises:
        UsageError: If it is longer than an expression may be.

    >>> high = Expression.parse("$height > 3")
    >>> plain_text(Expression.parse("100 * high", {"high": high}))
    '(100.0 * (not ($height < 3.0000000000000004)))'
    """
    texts: list[str] = []
    for step in expression.steps:
        text = _text(step, expression.steps, texts)
        if len(text) > MAX_CHARACTERS:
            raise UsageError(
                f"the expression has more than {MAX_CHARACTERS:,} characters with the definitions that it uses written "
                "out; use simpler ones"
            )
        texts.append(text)
    return texts[-1]


def _text(step: Step, steps: tuple[Step, ...], texts: list[str]) -> str:
    if isinstance(step, ConstantTerm):
        return f"({step.value!r})" if step.value < 0.0 else repr(step.value)
    if isinstance(step, Apply):
        return _application(step, steps, [texts[index] for index in step.operands])
    if isinstance(step.feature, Threshold):
        return f"(${step.feature.site} < {step.feature.bound!r})"
    text = str(step.feature)
    return f"${text}" if hasattr(step.feature, "site") else f"{{{text}}}"


def _application(step: Apply, steps: tuple[Step, ...], operands: list[str]) -> str:
    if step.operation in FUNCTIONS:
        return f"{step.operation}({', '.join(operands)})"
    if step.operation == "not":
        return f"(not {operands[0]})"
    first, second = (steps[index] for index in step.operands)
    # A comparison of a draw with a number is read as "its threshold > 0".
    is_threshold = not isinstance(first, ConstantTerm | Apply) and isinstance(first.feature, Threshold)
    if step.operation == ">" and second == _ZERO and is_threshold:
        return operands[0]
    return f"({operands[0]} {step.operation} {operands[1]})"
