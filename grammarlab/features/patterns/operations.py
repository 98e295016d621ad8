"""Operations of expressions and formulas over columns of numbers.

Relations of sequences take the elements in their order; an element 0 is missing and does not count. They are false for
fewer than two elements, so that no relation only says that something is absent; taking turns needs three.

>>> columns = [np.array(column) for column in ([1.0, 2.0, 1.0], [0.0, 1.0, 1.0], [1.0, 2.0, 0.0])]
>>> {name: apply(name, columns).tolist() for name in ("equal", "mirrored", "distinct", "which")}
{'equal': [1.0, 0.0, 1.0], 'mirrored': [1.0, 1.0, 1.0], 'distinct': [1.0, 2.0, 1.0], 'which': [1.0, 1.0, 1.0]}
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.features.patterns.pattern import Atom, ConstantTerm, Measure, Step

_Operation: TypeAlias = Callable[[Sequence[Floats]], NDArray[Any]]


def apply(operation: str, operands: Sequence[Floats]) -> Floats:
    """An operation [...] on columns [...] of the same shape; 0 where its result is not finite."""
    with np.errstate(all="ignore"):
        result = np.asarray(OPERATIONS[operation](operands), dtype=np.float64)
    return np.where(np.isfinite(result), result, 0.0)


def evaluate(steps: Sequence[Step], columns: Mapping[Atom, Floats], num: int) -> Floats:
    """[num] the result of the last step for every model.

    Args:
        steps: steps of an expression or a formula.
        columns: [num] values of the features that they read.
        num: number of models.
    """
    results: list[Floats] = []
    for step in steps:
        if isinstance(step, ConstantTerm):
            results.append(np.full(num, step.value))
        elif isinstance(step, Measure):
            results.append(columns[step.feature])
        else:
            results.append(apply(step.operation, [results[i] for i in step.operands]))
    return results[-1]


def _chosen(operands: Sequence[Floats]) -> Floats:
    """The value behind the first condition that holds, else the last operand."""
    *pairs, otherwise = operands
    return np.select([when != 0 for when in pairs[::2]], pairs[1::2], otherwise)


def _which(operands: Sequence[Floats]) -> Ints:
    held = np.stack(operands) != 0
    return np.where(held.any(axis=0), held.argmax(axis=0) + 1, 0)


def _count(operands: Sequence[Floats]) -> Ints:
    return np.asarray(np.count_nonzero(np.stack(operands), axis=0), dtype=np.int64)


def _followed(operands: Sequence[Floats]) -> NDArray[np.bool_]:
    first, second, *elements = operands
    earlier = np.logical_or.accumulate(np.stack(elements) == first, axis=0)
    return (earlier[:-1] & (np.stack(elements[1:]) == second)).any(axis=0)


def _present(operands: Sequence[Floats]) -> tuple[Floats, Ints]:
    """[k, ...] the elements of sequences, the missing ones last, and the number [...] of the others."""
    values = np.stack(operands)
    order = np.argsort(values == 0, axis=0, kind="stable")
    return np.take_along_axis(values, order, axis=0), np.count_nonzero(values, axis=0)


def _equal(operands: Sequence[Floats]) -> NDArray[np.bool_]:
    values, number = _present(operands)
    return (number >= 2) & ((values == values[0]) | (values == 0)).all(axis=0)


def _distinct(operands: Sequence[Floats]) -> Ints:
    values = np.sort(np.stack(operands), axis=0)
    starts = np.concatenate([np.ones((1, *values.shape[1:]), dtype=bool), values[1:] != values[:-1]])
    return (starts & (values != 0)).sum(axis=0)


def _changes(operands: Sequence[Floats]) -> Ints:
    values, _ = _present(operands)
    return ((values[1:] != values[:-1]) & (values[1:] != 0)).sum(axis=0)


def _unequal_neighbours(operands: Sequence[Floats]) -> NDArray[np.bool_]:
    number = np.count_nonzero(np.stack(operands), axis=0)
    return (number >= 2) & (_changes(operands) == number - 1)


def _alternating(operands: Sequence[Floats]) -> NDArray[np.bool_]:
    values, number = _present(operands)
    repeated = (values[2:] == values[:-2]) | (values[2:] == 0)
    return (number >= 3) & _unequal_neighbours(operands) & repeated.all(axis=0)


def _mirrored(operands: Sequence[Floats]) -> NDArray[np.bool_]:
    values, number = _present(operands)
    index = np.arange(len(values)).reshape(-1, *(1 for _ in number.shape))
    opposite = np.take_along_axis(values, np.maximum(number - 1 - index, 0), axis=0)
    return (number >= 2) & ((values == opposite) | (values == 0)).all(axis=0)


def _odd(operands: Sequence[Floats]) -> Ints:
    values, number = _present(operands)
    alike = np.array([((values == value) & (value != 0)).sum(axis=0) for value in values])
    return number - alike.max(axis=0)


def _ascending(operands: Sequence[Floats]) -> NDArray[np.bool_]:
    values, number = _present(operands)
    return (number >= 2) & ((values[1:] >= values[:-1]) | (values[1:] == 0)).all(axis=0)


def _longest_run(operands: Sequence[Floats]) -> Ints:
    values, number = _present(operands)
    length = longest = np.minimum(number, 1)
    for before, value in pairwise(values):
        length = np.where((value == before) & (value != 0), length + 1, 1)
        longest = np.where(value != 0, np.maximum(longest, length), longest)
    return longest


def _same_ends(operands: Sequence[Floats]) -> NDArray[np.bool_]:
    values, number = _present(operands)
    last = np.take_along_axis(values, np.maximum(number - 1, 0)[None], axis=0)[0]
    return (number >= 2) & (values[0] == last)


def _like_first(operands: Sequence[Floats]) -> Ints:
    first, *others = operands
    return np.asarray(((np.stack(others) == first) & (first != 0)).sum(axis=0), dtype=np.int64)


def _balance(operands: Sequence[Floats]) -> Floats:
    values, number = _present(operands)
    index = np.arange(len(values)).reshape(-1, *(1 for _ in number.shape))
    return (values * np.sign(number - 1 - 2 * index)).sum(axis=0)


def _least(operands: Sequence[Floats]) -> Floats:
    values = np.stack(operands)
    return np.where(values == 0, np.inf, values).min(axis=0)


OPERATIONS: Mapping[str, _Operation] = {
    "+": lambda x: x[0] + x[1],
    "-": lambda x: x[0] - x[1],
    "*": lambda x: x[0] * x[1],
    "/": lambda x: x[0] / x[1],
    "%": lambda x: x[0] % x[1],
    "<": lambda x: x[0] < x[1],
    "<=": lambda x: x[0] <= x[1],
    ">": lambda x: x[0] > x[1],
    ">=": lambda x: x[0] >= x[1],
    "==": lambda x: x[0] == x[1],
    "!=": lambda x: x[0] != x[1],
    "and": lambda x: (x[0] != 0) & (x[1] != 0),
    "or": lambda x: (x[0] != 0) | (x[1] != 0),
    "not": lambda x: x[0] == 0,
    "min": lambda x: reduce(np.minimum, x),
    "max": lambda x: reduce(np.maximum, x),
    "abs": lambda x: np.abs(x[0]),
    "log": lambda x: np.log(x[0]),
    "exp": lambda x: np.exp(x[0]),
    "sqrt": lambda x: np.sqrt(x[0]),
    "floor": lambda x: np.floor(x[0]),
    "ceil": lambda x: np.ceil(x[0]),
    "rint": lambda x: np.rint(x[0]),
    "choose": _chosen,
    "which": _which,
    "count": _count,
    "followed": _followed,
    "equal": _equal,
    "distinct": _distinct,
    "changes": _changes,
    "odd": _odd,
    "unequal_neighbours": _unequal_neighbours,
    "alternating": _alternating,
    "mirrored": _mirrored,
    "ascending": _ascending,
    "longest_run": _longest_run,
    "same_ends": _same_ends,
    "like_first": _like_first,
    "balance": _balance,
    "least": _least,
}
"""Operations, by their sign or name."""

SEQUENCE_RELATIONS = (
    "equal",
    "unequal_neighbours",
    "alternating",
    "mirrored",
    "ascending",
    "distinct",
    "changes",
    "odd",
    "longest_run",
    "same_ends",
    "like_first",
    "balance",
)
"""Operations on sequences of elements, of which those that are 0 are missing."""

FUNCTIONS: Mapping[str, str] = {
    "min": "min(a, b, ...)",
    "max": "max(a, b, ...)",
    "abs": "abs(x)",
    "log": "log(x)",
    "exp": "exp(x)",
    "sqrt": "sqrt(x)",
    "floor": "floor(x)",
    "ceil": "ceil(x)",
    "rint": "rint(x)",
    "choose": "choose(when, value, ..., otherwise)",
    "which": "which(a, b, ...)",
    "count": "count(a, b, ...)",
    "least": "least(a, b, ...)",
    "followed": "followed(first, second, a, b, ...)",
    **{name: f"{name}(a, b, ...)" for name in SEQUENCE_RELATIONS},
}
"""Functions of the language, with their call syntax."""


def takes(function: str, number: int) -> bool:
    """Whether a function accepts a number of values.

    >>> takes("choose", 4), takes("equal", 2)
    (False, True)
    """
    if function == "choose":
        return number >= 3 and number % 2 == 1
    if function == "followed":
        return number >= 4
    return number >= 2 if FUNCTIONS[function].endswith("(a, b, ...)") else number == 1
