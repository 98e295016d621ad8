"""Operators of CGA over constants and columns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.state.shapes import Value, kind_of
from grammarlab.derivation.strings import StringTable
from grammarlab.errors import BudgetError, DerivationError, Location

UnaryOperator = Callable[[Value, Location], Value]
BinaryOperator = Callable[[Value, Value, StringTable, Location], Value]


def number_text(value: float) -> str:
    """A number as CGA writes it into strings: up to 15 significant digits, very large and small ones with an exponent.

    >>> number_text(3.0), number_text(0.25), number_text(1 / 3), number_text(1e20)
    ('3', '0.25', '0.333333333333333', '1.0e20')
    """
    is_usual = value == 0.0 or 1e-5 < abs(value) < 1e16
    text = f"{value:.{15 if is_usual else 16}g}"
    mantissa, mark, exponent = text.partition("e")
    if not mark:
        return text
    if is_usual and exponent.startswith("-"):
        return np.format_float_positional(float(text), trim="-")
    return f"{mantissa}{'' if '.' in mantissa else '.0'}e{exponent.removeprefix('+')}"


def value_texts(value: Value, strings: StringTable) -> str | NDArray[np.int32]:
    """Any value as a string, or as string ids [N]."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float | int):
        return number_text(value)
    if value.dtype.kind == "i":
        return value  # type: ignore[return-value, ty:invalid-explicit-return]
    if value.dtype.kind == "b":
        return np.where(value, strings.id("true"), strings.id("false")).astype(np.int32)
    unique, inverse = np.unique(value, return_inverse=True)
    return strings.ids(number_text(number) for number in unique)[inverse]


MAX_TEXT = 1_000_000
"""Largest number of characters of a string, since recursive rules could double it repeatedly."""


def check_length(length: int, location: Location | None = None) -> None:
    """Refuse a string that is too long before it is made.

    Raises:
        BudgetError: If it would have more characters than `MAX_TEXT`.
    """
    if length > MAX_TEXT:
        raise BudgetError(f"a string would have {length:,} characters, more than {MAX_TEXT:,}", location)


def concatenated(left: Value, right: Value, strings: StringTable, location: Location | None = None) -> Value:
    """The texts of two values, one after the other."""

    def joined(first_text: str, second_text: str) -> str:
        check_length(len(first_text) + len(second_text), location)
        return first_text + second_text

    first, second = value_texts(left, strings), value_texts(right, strings)
    if isinstance(first, str):
        return (
            joined(first, second) if isinstance(second, str) else strings.map(second, lambda text: joined(first, text))
        )
    if isinstance(second, str):
        return strings.map(first, lambda text: joined(text, second))
    pairs, inverse = np.unique(np.stack([first, second]), axis=1, return_inverse=True)
    return strings.ids(joined(strings[a], strings[b]) for a, b in pairs.T.tolist())[inverse]


def _arithmetic(symbol: str, apply: Callable) -> BinaryOperator:
    exact = symbol in "+-*"

    def evaluate(left: Value, right: Value, strings: StringTable, location: Location) -> Value:
        if type(left) is float and type(right) is float:
            return apply(left, right) if exact else float(apply(np.array([left]), right)[0])
        if kind_of(left) == "string" or kind_of(right) == "string":
            if symbol == "+":
                return concatenated(left, right, strings, location)
            raise DerivationError(f"{symbol} expects numbers, found a {kind_of(left)} and a {kind_of(right)}", location)
        return apply(_number(left), _number(right))

    return evaluate


def _number(value: Value) -> float | NDArray[np.float64]:
    if isinstance(value, np.ndarray):
        return value.astype(np.float64, copy=False)
    return float(value)


def _equality(symbol: str) -> BinaryOperator:
    is_equality = symbol == "=="

    def evaluate(left: Value, right: Value, strings: StringTable, location: Location) -> Value:
        if (kind_of(left) == "string") != (kind_of(right) == "string"):
            raise DerivationError(
                f"{symbol} compares values of one type, found a {kind_of(left)} and a {kind_of(right)}", location
            )
        if isinstance(left, str) and isinstance(right, np.ndarray):
            left = strings.id(left)
        elif isinstance(right, str) and isinstance(left, np.ndarray):
            right = strings.id(right)
        equal = left == right
        if isinstance(equal, np.ndarray):
            return equal if is_equality else np.logical_not(equal)
        return equal == is_equality

    return evaluate


def _ordering(symbol: str, apply: Callable) -> BinaryOperator:
    def evaluate(left: Value, right: Value, strings: StringTable, location: Location) -> Value:
        kinds = {kind_of(left), kind_of(right)}
        if kinds == {"string"}:
            left, right = _letters(left, strings), _letters(right, strings)
        elif "string" in kinds:
            raise DerivationError(
                f"{symbol} compares values of one type, found a {kind_of(left)} and a {kind_of(right)}", location
            )
        truth = apply(left, right)
        return truth if isinstance(truth, np.ndarray) else bool(truth)

    return evaluate


def _letters(value: Value, strings: StringTable) -> Any:
    """Strings as an array that NumPy can sort."""
    if not isinstance(value, np.ndarray):
        return np.str_(value)
    codes, inverse = np.unique(value, return_inverse=True)
    return np.array([strings[code] for code in codes.tolist()])[inverse]


def _negative(value: Value, location: Location) -> Value:
    if kind_of(value) == "string":
        raise DerivationError("- expects a number, found a string", location)
    return -_number(value)


def _not(value: Value, location: Location) -> Value:
    if kind_of(value) != "bool":
        raise DerivationError(f"! expects true or false, found a {kind_of(value)}", location)
    return np.logical_not(value) if isinstance(value, np.ndarray) else not value


def _positive(value: Value, location: Location) -> Value:
    return -_negative(value, location)  # type: ignore[operator, ty:unsupported-operator]


UNARY: dict[str, UnaryOperator] = {"-": _negative, "+": _positive, "!": _not}
BINARY: dict[str, BinaryOperator] = {
    "+": _arithmetic("+", lambda a, b: a + b),
    "-": _arithmetic("-", lambda a, b: a - b),
    "*": _arithmetic("*", lambda a, b: a * b),
    "/": _arithmetic("/", np.divide),
    "%": _arithmetic("%", np.fmod),
    "==": _equality("=="),
    "!=": _equality("!="),
    "<": _ordering("<", np.less),
    "<=": _ordering("<=", np.less_equal),
    ">": _ordering(">", np.greater),
    ">=": _ordering(">=", np.greater_equal),
}
