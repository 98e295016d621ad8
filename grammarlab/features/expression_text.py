"""Expressions as texts that need no definitions, for files that hold one expression."""

from __future__ import annotations

from grammarlab.errors import UsageError
from grammarlab.features.expression import MAX_CHARACTERS, Expression
from grammarlab.features.patterns.pattern import step_text


def plain_text(expression: Expression) -> str:
    """A text of an expression in which the parts stand instead of their names.

    Raises:
        UsageError: If it is longer than an expression may be.

    >>> high = Expression.parse("$height > 3")
    >>> plain_text(Expression.parse("100 * high", {"high": high}))
    '(100 * (not ($height < 3.0000000000000004)))'
    """
    texts: list[str] = []
    for step in expression.steps:
        text = step_text(step, expression.steps, texts)
        if len(text) > MAX_CHARACTERS:
            raise UsageError(
                f"the expression has more than {MAX_CHARACTERS:,} characters with the definitions that it uses written "
                "out; use simpler ones"
            )
        texts.append(text)
    return texts[-1]
