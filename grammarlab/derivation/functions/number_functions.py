"""Arithmetic and random functions. Angles are in degrees, as in all of CGA.

Single numbers use the same array loops as columns: NumPy's scalar functions may differ in the last bit. Every random
draw has an address and is recorded with its log-density.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats
from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.calls.table_columns import for_each
from grammarlab.derivation.functions.array_editing import as_table
from grammarlab.derivation.functions.asset_functions import matching_files, root_of
from grammarlab.derivation.functions.text_functions import items, joined, text_function
from grammarlab.derivation.state.array_table import Cell, Table, is_table
from grammarlab.derivation.state.shapes import NUM_LANES, SITE_LANE, Value, kind_of
from grammarlab.errors import DerivationError, Location
from grammarlab.randomness import uniforms


def one_of(call: FunctionCall, lists: Value) -> Value:
    """One of the items of a list, all equally likely; empty when there is none."""
    strings = call.workspace.strings
    column = lists if isinstance(lists, np.ndarray) else np.full(call.shapes.num, strings.id(str(lists)))
    codes, inverse = np.unique(column, return_inverse=True)
    choices = [items(strings[code]) or [""] for code in codes.tolist()]
    counts = np.array([len(choice) for choice in choices])
    first = np.cumsum(counts) - counts
    chosen = np.floor(_draw(call) * counts[inverse])
    call.workspace.recorder.add_draw(call.shapes, call.site, chosen, -np.log(counts[inverse]))
    table = strings.ids(item for choice in choices for item in choice)
    return table[first[inverse] + chosen.astype(np.int64)]


def _draw(call: FunctionCall) -> Floats:
    """One uniform number in [0, 1) for each shape."""
    return uniforms(call.shapes.random_key(), NUM_LANES * call.address + SITE_LANE)


def _rand(call: FunctionCall) -> Value:
    """``rand()`` in [0, 1), ``rand(b)`` in [0, b), ``rand(a, b)`` in [a, b)."""
    bounds = [_finite(call, argument) for argument in call.arguments]
    low = bounds[0] if len(bounds) == 2 else 0.0
    high = bounds[-1] if bounds else 1.0
    values = low + (high - low) * _draw(call)
    call.workspace.recorder.add_draw(call.shapes, call.site, values, _log_density(np.abs(high - low)))
    return values


def _log_density(extent: Floats | float) -> Floats | float:
    """Log-density of a uniform draw over an interval of this length; 0 for a single value."""
    if isinstance(extent, np.ndarray):
        return -np.log(np.where(extent > 0.0, extent, 1.0))
    return -float(np.log(np.array([extent]))[0]) if extent > 0.0 else 0.0


def _bernoulli(call: FunctionCall) -> Value:
    """``p(x)``: true with probability x."""
    probability = np.clip(_finite(call, call.arguments[0]), 0.0, 1.0)
    outcome = _draw(call) < probability
    chance = np.where(outcome, probability, 1.0 - probability)
    call.workspace.recorder.add_draw(call.shapes, call.site, outcome.astype(np.float64), np.log(chance))
    return outcome


def _file_random(call: FunctionCall) -> Value:
    """``fileRandom("folder/*.jpg")``: one of the matching asset files, all equally likely; empty if there is none."""
    pattern = call.arguments[0]
    if not isinstance(pattern, str):
        match_names = partial(matching_files, root_of(call))
        return one_of(call, text_function(lambda text: joined(match_names(text))).evaluate(call))
    files = matching_files(root_of(call), pattern)
    if not files:
        return ""
    chosen = np.floor(_draw(call) * len(files))
    call.workspace.recorder.add_draw(call.shapes, call.site, chosen, -np.log(len(files)))
    return call.workspace.strings.ids(files)[chosen.astype(np.int64)]


def _list_random(call: FunctionCall) -> Value:
    """``listRandom("a;b;c;")``: one of the items, all equally likely; empty when there is none."""
    lists = call.arguments[0]
    if kind_of(lists) != "string":
        raise DerivationError(f"listRandom expected a string, found a {kind_of(lists)}", call.location)
    return one_of(call, lists)


def _refuse_texts(call: FunctionCall, value: Value) -> None:
    if kind_of(value) == "string":
        raise DerivationError(f"{call.name} expected a number, found a string", call.location)


def _finite(call: FunctionCall, value: Value) -> Floats | float:
    _refuse_texts(call, value)
    if isinstance(value, float | bool) and math.isfinite(value):
        return float(value)
    column = np.atleast_1d(value)
    if not np.isfinite(column).all():
        raise DerivationError(
            f"{call.name} expected a finite number, found {column[~np.isfinite(column)][0]}", call.location
        )
    return column.astype(np.float64, copy=False)


def elementwise(apply: Callable[..., NDArray], least: int, most: int | None = None) -> Builtin:
    """A function of numbers from a function of arrays."""

    def evaluate(call: FunctionCall) -> Value:
        columns = [_numbers(call, argument) for argument in call.arguments]
        result = apply(*columns)
        if any(isinstance(argument, np.ndarray) for argument in call.arguments):
            return result
        return bool(result[0]) if result.dtype.kind == "b" else float(result[0])

    return Builtin(evaluate, (least, least if most is None else most))


def _cellwise(apply: Callable[..., NDArray]) -> Builtin:
    """A function of one number, or of each cell of an array of numbers."""
    single = elementwise(apply, 1)

    def of_cells(location: Location, value: Cell | Table) -> Table:
        table = as_table(value)
        if table.kind != "float":
            raise DerivationError(f"expected numbers in an array, found cells of the type {table.kind}", location)
        results = apply(np.array(table.cells, dtype=np.float64))
        kind = "bool" if results.dtype.kind == "b" else "float"
        return table._replace(kind=kind, cells=tuple(results.tolist()))

    def evaluate(call: FunctionCall) -> Value:
        if not is_table(call.arguments[0]):
            return single.evaluate(call)
        return for_each(
            call.arguments,
            call.shapes.num,
            call.workspace,
            lambda value: of_cells(call.location, value),
            call.location,
        )

    return Builtin(evaluate, (1, 1), takes_arrays=True)


def _numbers(call: FunctionCall, argument: Value) -> Floats:
    _refuse_texts(call, argument)
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
    "abs": _cellwise(np.abs),
    "acos": elementwise(lambda x: np.degrees(np.arccos(x)), 1),
    "asin": elementwise(lambda x: np.degrees(np.arcsin(x)), 1),
    "atan": elementwise(lambda x: np.degrees(np.arctan(x)), 1),
    "atan2": elementwise(lambda y, x: np.degrees(np.arctan2(y, x)), 2),
    "ceil": _cellwise(np.ceil),
    "clamp": _chosen(_clamp, lambda x, low, high: min(max(x, low), high), 3),
    "cos": elementwise(lambda x: np.cos(np.radians(x)), 1),
    "exp": elementwise(np.exp, 1),
    "fileRandom": Builtin(_file_random, (1, 1), random=True),
    "floor": _cellwise(np.floor),
    "isinf": _cellwise(np.isinf),
    "isnan": _cellwise(np.isnan),
    "listRandom": Builtin(_list_random, (1, 1), random=True),
    "ln": elementwise(np.log, 1),
    "log10": elementwise(np.log10, 1),
    "max": _chosen(np.maximum, max, 2),
    "min": _chosen(np.minimum, min, 2),
    "p": Builtin(_bernoulli, (1, 1), random=True),
    "pow": elementwise(np.power, 2),
    "rand": Builtin(_rand, (0, 2), random=True),
    "rint": _cellwise(np.rint),
    "sin": elementwise(lambda x: np.sin(np.radians(x)), 1),
    "sqrt": elementwise(np.sqrt, 1),
    "tan": elementwise(lambda x: np.tan(np.radians(x)), 1),
}
