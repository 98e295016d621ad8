"""Arithmetic functions. Angles are in degrees, as in all of CGA.

Single numbers use the same array loops as columns: NumPy's scalar functions may differ in the last bit.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.functions.text import text_function
from grammarlab.derivation.state.shapes import Value, kind_of
from grammarlab.errors import DerivationError

Floats = NDArray[np.float64]


def elementwise(apply: Callable[..., NDArray], least: int, most: int | None = None) -> Builtin:
    """A function of numbers from a function of arrays."""

    def evaluate(call: FunctionCall) -> Value:
        columns = [_numbers(call, argument) for argument in call.arguments]
        result = apply(*columns)
        if any(isinstance(argument, np.ndarray) for argument in call.arguments):
            return result
        return bool(result[0]) if result.dtype.kind == "b" else float(result[0])

    return Builtin(evaluate, (least, least if most is None else most))


def _numbers(call: FunctionCall, argument: Value) -> Floats:
    if kind_of(argument) == "string":
        raise DerivationError(f"{call.name} expected a number, found a string", call.location)
    if isinstance(argument, np.ndarray):
        return argument.astype(np.float64, copy=False)
    return np.array([float(argument)])


def _chosen(numbers: Callable[..., NDArray], texts: Callable[..., str], count: int) -> Builtin:
    """A function that returns one of its arguments: of numbers, or of strings by their order."""
    of_numbers, of_texts = elementwise(numbers, count), text_function(texts, (count, count))

    def evaluate(call: FunctionCall) -> Value:
        are_texts = kind_of(call.arguments[0]) == "string"
        return (of_texts if are_texts else of_numbers).evaluate(call)

    return Builtin(evaluate, (count, count))


def _clamp(x: Floats, low: Floats, high: Floats) -> Floats:
    return np.minimum(np.maximum(x, low), high)


BUILTINS: dict[str, Builtin] = {
    "abs": elementwise(np.abs, 1),
    "acos": elementwise(lambda x: np.degrees(np.arccos(x)), 1),
    "asin": elementwise(lambda x: np.degrees(np.arcsin(x)), 1),
    "atan": elementwise(lambda x: np.degrees(np.arctan(x)), 1),
    "atan2": elementwise(lambda y, x: np.degrees(np.arctan2(y, x)), 2),
    "ceil": elementwise(np.ceil, 1),
    "clamp": _chosen(_clamp, lambda x, low, high: min(max(x, low), high), 3),
    "cos": elementwise(lambda x: np.cos(np.radians(x)), 1),
    "exp": elementwise(np.exp, 1),
    "floor": elementwise(np.floor, 1),
    "isinf": elementwise(np.isinf, 1),
    "isnan": elementwise(np.isnan, 1),
    "ln": elementwise(np.log, 1),
    "log10": elementwise(np.log10, 1),
    "max": _chosen(np.maximum, max, 2),
    "min": _chosen(np.minimum, min, 2),
    "pow": elementwise(np.power, 2),
    "rint": elementwise(np.rint, 1),
    "sin": elementwise(lambda x: np.sin(np.radians(x)), 1),
    "sqrt": elementwise(np.sqrt, 1),
    "tan": elementwise(lambda x: np.tan(np.radians(x)), 1),
}
