"""Arguments of operations, and heads of parts, compiled to values that are evaluated for shapes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from grammarlab.derivation.calls.calls import Argument, Compiler, Condition, Head
from grammarlab.derivation.state.shapes import Shapes, Value, kind_of
from grammarlab.derivation.state.workspace import Code, Workspace
from grammarlab.errors import DerivationError, Location
from grammarlab.language.syntax.printing import expression
from grammarlab.language.syntax.syntax_tree import (
    Binary,
    Boolean,
    Call,
    Expression,
    Floating,
    Name,
    Number,
    Part,
    Relative,
    String,
    Unary,
    walk,
)

_T = TypeVar("_T")
Late: TypeAlias = "Callable[[Shapes, Workspace], _T]"
"""A value that is evaluated for shapes."""


@dataclass(frozen=True, slots=True)
class Constant(Generic[_T]):
    """A value that is known from the text."""

    value: _T

    def __call__(self, shapes: Shapes, workspace: Workspace) -> _T:
        """The value, for any shapes."""
        return self.value


NO_ARGUMENT = Argument("")
_COUNTING = frozenset({"+", "-", "*", "/", "%"})


def argument(expressions: Compiler, node: Expression, keywords: frozenset[str]) -> Late[Argument]:
    """One argument; keywords are not evaluated."""
    if word(node) in keywords:
        return Constant(Argument(word(node), keyword=True))
    if isinstance(node, Call) and node.function == "sel" and len(node.arguments) == 1:
        text = expressions.expression(node.arguments[0])
        return lambda shapes, workspace: Argument(_same_text(text(shapes, workspace), node.location), keyword=True)
    inner, prefixes = _without_prefixes(node)
    floating, relative = Floating in prefixes, Relative in prefixes
    if isinstance(inner, Number | Boolean | String):
        return Constant(Argument(inner.value, False, relative, floating))
    code: Code = expressions.expression(inner)
    if not keywords:
        return lambda shapes, workspace: Argument(code(shapes, workspace), False, relative, floating)

    def evaluate(shapes: Shapes, workspace: Workspace) -> Argument:
        value = code(shapes, workspace)
        if isinstance(value, np.ndarray) and value.dtype.kind == "i" and len(value) and (value == value[0]).all():
            value = workspace.strings[int(value[0])]
        return Argument(value, isinstance(value, str) and value in keywords, relative, floating)

    return evaluate


def head(expressions: Compiler, part: Part, group: int, words: frozenset[str], block: int) -> Late[Head]:
    """Head of a part: the text before its colon.

    Args:
        expressions: compiler of its expression.
        part: the part.
        group: index of the repeated group that contains it; -1 for none.
        words: allowed selectors.
        block: number of the block, for random keys.
    """
    node = part.head
    if words and not _is_selector_or_index(node, words):
        code = expressions.with_selectors(words).expression(node)
        used = frozenset(inner.identifier for inner in walk(node) if isinstance(inner, Name)) & words
        condition = Condition(code, used, block)
        return Constant(
            Head(
                argument=NO_ARGUMENT,
                joined=part.inclusive,
                group=group,
                connected=part.connected,
                condition=condition,
                text=expression(node),
            )
        )
    value = argument(expressions, node, words)
    constant_head = Head(
        argument=NO_ARGUMENT,
        joined=part.inclusive,
        group=group,
        connected=part.connected,
        condition=None,
        text=expression(node) if words else "",
    )
    if part.depth is not None:
        depth = argument(expressions, part.depth, frozenset())
        return lambda shapes, workspace: constant_head._replace(
            argument=value(shapes, workspace), depth=depth(shapes, workspace)
        )
    if isinstance(value, Constant):
        return Constant(constant_head._replace(argument=value.value))
    return lambda shapes, workspace: constant_head._replace(argument=value(shapes, workspace))


def _is_selector_or_index(node: Expression, words: frozenset[str]) -> bool:
    """Whether the head of a part is one selector, or a number that does not depend on the component."""
    if isinstance(node, Name):
        return node.identifier in words
    return isinstance(node, Number) or (isinstance(node, Binary | Unary) and node.operator in _COUNTING)


def _without_prefixes(node: Expression) -> tuple[Expression, frozenset[type]]:
    """A size without its prefixes ``~`` and ``'``, which apply to the whole size: ``~height - 0.3``, ``-'0.5``."""
    if isinstance(node, Floating | Relative):
        inner, prefixes = _without_prefixes(node.operand)
        return inner, prefixes | {type(node)}
    if isinstance(node, Unary):
        inner, prefixes = _without_prefixes(node.operand)
        return (replace(node, operand=inner), prefixes) if prefixes else (node, prefixes)
    if isinstance(node, Binary):
        left, prefixes = _without_prefixes(node.left)
        return (replace(node, left=left), prefixes) if prefixes else (node, prefixes)
    return node, frozenset()


def word(node: Expression) -> str:
    """The keyword of an argument, with quotes (as in older files) or without; otherwise empty."""
    return node.identifier if isinstance(node, Name) else node.value if isinstance(node, String) else ""


def _same_text(value: Value, location: Location) -> str:
    if isinstance(value, str):
        return value
    raise DerivationError(f"sel expects one string for all shapes, found a {kind_of(value)}", location)


def all_values(codes: Sequence[Late[_T]]) -> Late[tuple[_T, ...]]:
    """All these values for shapes."""
    constants = tuple([code.value for code in codes if isinstance(code, Constant)])
    if len(constants) == len(codes):
        return Constant(constants)
    return lambda shapes, workspace: tuple([code(shapes, workspace) for code in codes])
