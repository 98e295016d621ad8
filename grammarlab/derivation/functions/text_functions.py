"""Functions of strings and of lists, and conversions between types.

Lists are strings with a semicolon after each item, as in CGA.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite

import numpy as np

from grammarlab.derivation.calls.calls import Builtin, FunctionCall
from grammarlab.derivation.calls.table_columns import texts_of
from grammarlab.derivation.state.array_table import cell_text
from grammarlab.derivation.state.operators import check_length
from grammarlab.derivation.state.shapes import Shapes, Value, kind_of
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.errors import DerivationError
from grammarlab.language.syntax.builtins import functions


def text_function(apply: Callable[..., str | float | bool], num_arguments: tuple[int, int] = (1, 1)) -> Builtin:
    """A function whose first argument is a string; it is called once for each different combination of arguments."""

    def evaluate(call: FunctionCall) -> Value:
        _require_kinds(call)
        columns = [value for value in call.arguments if isinstance(value, np.ndarray)]
        if not columns:
            return _value(apply(*call.arguments))
        table = np.stack([column.astype(np.float64) for column in columns], axis=1)
        unique, inverse = np.unique(table, axis=0, return_inverse=True)
        return _column([apply(*_row(call, row)) for row in unique.tolist()], inverse, call)

    return Builtin(evaluate, num_arguments)


_NULL_TEXT = text_function(lambda text: text == "\ue000")
"""CGA's missing value among strings; among numbers it is NaN."""


def print_value(value: Value, shapes: Shapes, workspace: Workspace) -> None:
    """Collect the texts of ``print``, one per shape."""
    texts = texts_of(value, workspace)
    lines = [texts] * shapes.num if isinstance(texts, str) else [workspace.strings[text] for text in texts.tolist()]
    workspace.recorder.add_prints(lines)


def items(text: str) -> list[str]:
    """The items of a list; the last one may lack its semicolon."""
    parts = text.split(";")
    return parts[:-1] if parts[-1] == "" else parts


def joined(parts: list[str]) -> str:
    """A list of these items."""
    text = "".join(f"{part};" for part in parts)
    check_length(len(text))
    return text


def _require_kinds(call: FunctionCall) -> None:
    """Refuse arguments whose types differ from CGA's table of functions; ``any`` means string here."""
    form = max(functions()[call.name], key=lambda form: len(form.parameters))
    for index, (value, parameter) in enumerate(zip(call.arguments, form.parameters, strict=False)):
        kind = kind_of(value)
        types = ("string",) if index == 0 or "any" in parameter.types else parameter.types
        if kind not in types:
            expected = " or a ".join(types)
            raise DerivationError(
                f"{call.name} expected a {expected} as argument {index + 1}, found a {kind}", call.location
            )


def _value(result: str | float | bool) -> Value:
    return result if isinstance(result, str | bool) else float(result)


def _column(results: list[str | float | bool], inverse: np.ndarray, call: FunctionCall) -> Value:
    if isinstance(results[0], str):
        return call.workspace.strings.ids(str(result) for result in results)[inverse]
    return np.array(results, dtype=bool if isinstance(results[0], bool) else np.float64)[inverse]


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


def to_number(text: str) -> float:
    """Number from a text; NaN if it is not a number."""
    if "_" in text or not text.isascii():  # Python reads 1_000 as 1000
        return float("nan")
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
        return text_function(is_true).evaluate(call)
    return value != 0.0 if isinstance(value, np.ndarray) else bool(value)


def _is_null(call: FunctionCall) -> Value:
    value = call.arguments[0]
    if kind_of(value) == "string":
        return _NULL_TEXT.evaluate(call._replace(name="len"))
    return np.isnan(value) if isinstance(value, np.ndarray) else bool(np.isnan(value))


def is_true(text: str) -> bool:
    """Truth value of a text."""
    return text.strip().lower() not in {"", "f", "false"} and to_number(text) != 0.0


def _convert_to_text(call: FunctionCall) -> Value:
    return texts_of(call.arguments[0], call.workspace)


def _print(call: FunctionCall) -> Value:
    print_value(call.arguments[0], call.shapes, call.workspace)
    return call.arguments[0]


def _whole(number: float) -> int:
    """Integer part of a number; 0 if it is not finite."""
    return int(number) if isfinite(number) else 0


def _find(text: str, sought: str, nth: float = 0.0) -> float:
    index = -1
    for _ in range(max(0, _whole(nth)) + 1):
        index = text.find(sought, index + 1)
        if index < 0:
            return -1.0
    return float(index)


def _substring(text: str, start: float, end: float) -> str:
    return text[max(0, _whole(start)) : max(0, _whole(end))]


def _replace(text: str, old: str, new: str | float | bool) -> str:
    if not old:
        return text
    replacement = cell_text(new)
    check_length(len(text) + text.count(old) * (len(replacement) - len(old)))
    return text.replace(old, replacement)


def _prefix(text: str, separator: str) -> str:
    return text.partition(separator)[0] if separator else ""


def _suffix(text: str, separator: str) -> str:
    return text.rpartition(separator)[2] if separator and separator in text else ""


def _range(text: str, first: str, last: str) -> str:
    """Text between the first occurrence of one string and the last occurrence of another after it."""
    index = text.find(first)
    rest = text[index + len(first) :] if index >= 0 else ""
    end = rest.rfind(last)
    return rest[: max(0, end)]


def _fits(item: str, sought: str) -> bool:
    """Whether an item matches a pattern; a ``*`` at the start or the end matches any text.

    >>> _fits("floor_2", "*_2"), _fits("your", "*u*"), _fits("your", "u*")
    (True, True, False)
    """
    core = sought.removeprefix("*")
    at_start = core == sought
    core, at_end = core.removesuffix("*"), not core.endswith("*")
    if at_start and at_end:
        return item == core
    return item.startswith(core) if at_start else item.endswith(core) if at_end else core in item


def _item(text: str, index: float) -> str:
    parts = items(text)
    return parts[_whole(index)] if 0 <= index < len(parts) else ""


def _index(text: str, sought: str) -> float:
    return float(next((i for i, item in enumerate(items(text)) if _fits(item, sought)), -1))


def _remove(text: str, sought: str) -> str:
    parts, index = items(text), _whole(_index(text, sought))
    return joined(parts[:index] + parts[index + 1 :]) if index >= 0 else joined(parts)


def _filtered(text: str, sought: str, fitting: bool) -> str:
    return joined([item for item in items(text) if _fits(item, sought) == fitting])


def _part(text: str, first: float, last: float) -> str:
    return joined(items(text)[max(0, _whole(first)) : max(0, _whole(last))])


BUILTINS: dict[str, Builtin] = {
    "bool": Builtin(_convert_to_bool, (1, 1)),
    "count": text_function(lambda text, sought: float(text.count(sought)), (2, 2)),
    "find": text_function(_find, (2, 3)),
    "findLast": text_function(lambda text, sought: float(text.rfind(sought)), (2, 2)),
    "float": Builtin(_convert_to_float, (1, 1)),
    "getPrefix": text_function(_prefix, (2, 2)),
    "getRange": text_function(_range, (3, 3)),
    "getSuffix": text_function(_suffix, (2, 2)),
    "isNull": Builtin(_is_null, (1, 1)),
    "isnull": Builtin(_is_null, (1, 1)),
    "len": text_function(lambda text: float(len(text))),
    "listAdd": text_function(lambda text, item: joined([*items(text), item.removesuffix(";")]), (2, 2)),
    "listClean": text_function(lambda text: joined([item for item in items(text) if item])),
    "listCount": text_function(lambda text, sought: float(sum(_fits(item, sought) for item in items(text))), (2, 2)),
    "listFirst": text_function(lambda text: _item(text, 0.0)),
    "listIndex": text_function(_index, (2, 2)),
    "listItem": text_function(_item, (2, 2)),
    "listLast": text_function(lambda text: items(text)[-1] if items(text) else ""),
    "listRange": text_function(_part, (3, 3)),
    "listRemove": text_function(_remove, (2, 2)),
    "listRemoveAll": text_function(lambda text, sought: _filtered(text, sought, False), (2, 2)),
    "listRetainAll": text_function(lambda text, sought: _filtered(text, sought, True), (2, 2)),
    "listSize": text_function(lambda text: float(len(items(text)))),
    "listTerminate": text_function(lambda text: joined(items(text))),
    "print": Builtin(_print, (1, 1), takes_arrays=True),
    "replace": text_function(_replace, (3, 3)),
    "str": Builtin(_convert_to_text, (1, 1), takes_arrays=True),
    "substring": text_function(_substring, (3, 3)),
}
