"""Expressions of template text: a constant and a coefficient for each parameter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np
from lark import Token, Tree

from grammarlab.errors import LanguageError
from grammarlab.facade.templates.elements import Floats

Complain = Callable[[str, str, Token | Tree], LanguageError]
_LARGEST = 1e6


@dataclass(frozen=True, slots=True)
class NameScope:
    """Known names."""

    names: tuple[str, ...]
    """[D] parameters."""
    values: Mapping[str, int]
    """Values of counts and of counters of repeats."""
    inner: bool = False
    """Whether this is inside a repeat."""


def evaluate(tree: Tree, scope: NameScope, complain: Complain) -> Floats:
    """[1 + D] constant and coefficients of an expression.

    Raises:
        LanguageError: If there are unknown names, products or quotients of parameters, divisions by 0, or huge numbers.
    """
    value = _value(tree, scope, complain)
    if not (np.abs(value) <= _LARGEST).all():
        raise complain("too-large", f"expected numbers up to {_LARGEST:g}", tree)
    return value


def _value(tree: Tree, scope: NameScope, complain: Complain) -> Floats:
    size = 1 + len(scope.names)
    if tree.data == "number":
        # A text may hold 1e999: not infinity, which times 0 is no number.
        return np.eye(size)[0] * min(float(str(tree.children[0])), 2.0 * _LARGEST)
    if tree.data == "name":
        return _named(cast("Token", tree.children[0]), scope, complain)
    parts = [evaluate(each, scope, complain) for each in tree.children]
    if tree.data == "negative":
        return -parts[0]
    left, right = parts
    if tree.data == "add":
        return left + right
    if tree.data == "subtract":
        return left - right
    constant = not right[1:].any()
    if tree.data == "divide":
        if not constant or right[0] == 0.0:
            raise complain("linear", "expected a divisor that is a number other than 0", tree)
        return left / right[0]
    if not constant and left[1:].any():
        raise complain("linear", "expected linear expressions: one factor of a product must be a number", tree)
    return left * right[0] if constant else right * left[0]


def _named(name: Token, scope: NameScope, complain: Complain) -> Floats:
    size = 1 + len(scope.names)
    if str(name) in scope.values:
        return np.eye(size)[0] * scope.values[str(name)]
    if str(name) in scope.names:
        return np.eye(size)[1 + scope.names.index(str(name))]
    known = ", ".join((*scope.names, *scope.values)) or "none here"
    raise complain("unknown-name", f"unknown name {str(name)!r}; expected one of {known}", name)


def whole(value: Floats, place: Tree, complain: Complain) -> int:
    """The value, if it is an integer without parameters."""
    if value[1:].any() or value[0] != round(value[0]):
        raise complain("whole", "expected a whole number without parameters", place)
    return round(value[0])
