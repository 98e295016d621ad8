"""String functions and conversions between types. Lists are strings with a semicolon after each item, as in CGA."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grammarlab.derivation.calls import Builtin, FunctionCall
from grammarlab.derivation.operators import value_texts
from grammarlab.derivation.shapes import Value, kind_of
from grammarlab.errors import DerivationError


def text_function(apply: Callable[..., str | float | bool], num_arguments: tuple[int, int] = (1, 1)) -> Builtin:
    """A function whose first argument is a string; it is called once for each different combination of arguments."""

    def evaluate(call: FunctionCall) -> Value:
        if kind_of(call.arguments[0]) != "string":
            raise DerivationError(
                f"{call.name} expected a string first, found a {kind_of(call.arguments[0])}", call.location
            )
        columns = [value for value in call.arguments if isinstance(value, np.ndarray)]
        if not columns:
            return _value(apply(*call.arguments))
        table = np.stack([column.astype(np.float64) for column in columns], axis=1)
        unique, inverse = np.unique(table, axis=0, return_inverse=True)
        return _column([apply(*_row(call, row)) for row in unique.tolist()], inverse, call)

    return Builtin(evaluate, num_arguments)


def _row(call: FunctionCall, row: list[float]) -> list[str | float | bool]:
    """The arguments of one call, the columns replaced by the values of one row."""
    values = iter(row)
    arguments: list[str | float | bool] = []
    for value in call.arguments:
        if not isinstance(value, np.ndarray):
            arguments.append(value)
        elif value.dtype.kind == "i":
            arguments.append(call.workspace.strings[int(next(values))])
        else:
            number = next(values)
            arguments.append(bool(number) if value.dtype.kind == "b" else number)
    return arguments


def _value(result: str | float | bool) -> Value:
    return result if isinstance(result, str | bool) else float(result)


def _column(results: list[str | float | bool], inverse: np.ndarray, call: FunctionCall) -> Value:
    if isinstance(results[0], str):
        return call.workspace.strings.ids(str(result) for result in results)[inverse]
    return np.array(results, dtype=bool if isinstance(results[0], bool) else np.float64)[inverse]


def to_number(text: str) -> float:
    """The number a text spells; NaN when it spells none."""
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _convert_to_float(call: FunctionCall) -> Value:
    value = call.arguments[0]
    if kind_of(value) == "string":
        return text_function(to_number).evaluate(call)
    return value.astype(np.float64) if isinstance(value, np.ndarray) else float(value)


def _convert_to_bool(call: FunctionCall) -> Value:
    value = call.arguments[0]
    if kind_of(value) == "string":
        return text_function(lambda text: text.strip().lower() not in {"", "0", "f", "false"}).evaluate(call)
    return value != 0.0 if isinstance(value, np.ndarray) else bool(value)


def _convert_to_text(call: FunctionCall) -> Value:
    return value_texts(call.arguments[0], call.workspace.strings)


def items(text: str) -> list[str]:
    """The items of a list."""
    parts = text.split(";")
    return parts[:-1] if parts[-1] == "" else parts


def joined(parts: list[str]) -> str:
    """A list of these items."""
    return "".join(f"{part};" for part in parts)


def _find(text: str, sought: str, nth: float = 0.0) -> float:
    place = -1
    for _ in range(max(0, int(nth)) + 1):
        place = text.find(sought, place + 1)
        if place < 0:
            return -1.0
    return float(place)


def _substring(text: str, start: float, end: float) -> str:
    return text[max(0, int(start)) : max(0, int(end))]


def _item(text: str, index: float) -> str:
    parts = items(text)
    return parts[int(index)] if 0 <= index < len(parts) else ""


def _index(text: str, item: str) -> float:
    parts = items(text)
    return float(parts.index(item)) if item in parts else -1.0


def _remove(text: str, item: str) -> str:
    return joined([part for part in items(text) if part != item])


def _prefix(text: str, separator: str) -> str:
    return text.partition(separator)[0]


def _suffix(text: str, separator: str) -> str:
    return text.rpartition(separator)[2] if separator in text else ""


def _range(text: str, first: str, last: str) -> str:
    _, found, rest = text.partition(first)
    return rest.partition(last)[0] if found and last in rest else ""


BUILTINS: dict[str, Builtin] = {
    "bool": Builtin(_convert_to_bool, (1, 1)),
    "count": text_function(lambda text, sought: float(text.count(sought)), (2, 2)),
    "find": text_function(_find, (2, 3)),
    "findFirst": text_function(lambda text, sought: float(text.find(sought)), (2, 2)),
    "findLast": text_function(lambda text, sought: float(text.rfind(sought)), (2, 2)),
    "float": Builtin(_convert_to_float, (1, 1)),
    "getPrefix": text_function(_prefix, (2, 2)),
    "getRange": text_function(_range, (3, 3)),
    "getSuffix": text_function(_suffix, (2, 2)),
    "len": text_function(lambda text: float(len(text))),
    "listAdd": text_function(lambda text, item: joined([*items(text), item]), (2, 2)),
    "listFirst": text_function(lambda text: _item(text, 0.0)),
    "listIndex": text_function(_index, (2, 2)),
    "listItem": text_function(_item, (2, 2)),
    "listLast": text_function(lambda text: items(text)[-1] if items(text) else ""),
    "listRange": text_function(lambda text, a, b: joined(items(text)[max(0, int(a)) : max(0, int(b))]), (3, 3)),
    "listRemove": text_function(_remove, (2, 2)),
    "listSize": text_function(lambda text: float(len(items(text)))),
    "replace": text_function(lambda text, old, new: text.replace(old, new) if old else text, (3, 3)),
    "str": Builtin(_convert_to_text, (1, 1)),
    "substring": text_function(_substring, (3, 3)),
}
