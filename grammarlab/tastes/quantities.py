"""Quantities of designs, and recipes that make further ones of them.

A recipe is a function of an operation and of operands, so that it makes columns and formulas alike:

>>> recipe: Recipe = lambda do, a, b: do("/", do("+", a, b), a)
>>> recipe(applied, np.array([1.0, 2.0]), np.array([3.0, 4.0])).tolist()
[4.0, 3.0]
>>> from grammarlab.features.patterns.pattern import Pattern
>>> print(recipe(Formula.of, Pattern("Window"), Pattern("Door")))
({Window} + {Door}) / {Window}
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import combinations
from typing import Any, NamedTuple, TypeAlias, overload

import numpy as np

from grammarlab.arrays import BATCH, MOST_COLUMNS, Floats, Ints
from grammarlab.features.expression import MAX_CHARACTERS, MAX_FEATURES
from grammarlab.features.patterns.operations import apply
from grammarlab.features.patterns.pattern import Atom, Feature, Formula

Recipe: TypeAlias = Callable[..., Any]
"""Function of an operation (`applied` or `Formula.of`) and of operands."""
MAX_TEXT = MAX_CHARACTERS // 4
"""Largest number of characters of a candidate: a function of it can be half an expression, and may name it twice."""


class Later(Sequence[Formula | Atom]):
    """Formulas that are made when they are needed: most quantities end in no column that anyone sees."""

    def __init__(self, makers: Sequence[Callable[[], Formula | Atom]]) -> None:
        """Formulas by functions that make them."""
        self._makers = makers

    def __len__(self) -> int:
        return len(self._makers)

    @overload
    def __getitem__(self, index: int) -> Formula | Atom: ...

    @overload
    def __getitem__(self, index: slice) -> Later: ...

    def __getitem__(self, index: int | slice) -> Formula | Atom | Later:
        return Later(self._makers[index]) if isinstance(index, slice) else self._makers[index]()


class Quantities(NamedTuple):
    """K numbers of each of n designs."""

    formulas: Sequence[Formula | Atom]
    """[K] what they are."""
    values: Floats
    """[n, K] their values."""

    def take(self, indices: Ints) -> Quantities:
        """Some of them."""
        return Quantities(tuple(self.formulas[index] for index in indices.tolist()), self.values[:, indices])

    def __len__(self) -> int:  # ty: ignore[incompatible-method-override]
        return len(self.formulas)


class Block(NamedTuple):
    """Columns that a production makes, when they are needed."""

    size: int
    """Number of columns."""
    operators: int
    """Number of operations in each."""
    values: Callable[[], Floats]
    """[n, size] the columns."""
    formula: Callable[[int], Formula | Atom]
    """What a column is."""

    def split(self, size: int) -> tuple[Block, Block]:
        """The first columns, and the others."""
        first = self._replace(size=size, values=lambda: self.values()[:, :size])
        rest = self._replace(
            size=self.size - size,
            values=lambda: self.values()[:, size:],
            formula=lambda index: self.formula(size + index),
        )
        return first, rest


def is_short(feature: Feature) -> bool:
    """Whether the text of a candidate is short enough for functions of it that are read back."""
    num_features = len(feature.features) if isinstance(feature, Formula) else 1
    return num_features <= MAX_FEATURES and len(str(feature)) <= MAX_TEXT


def applied(operation: str, *operands: Floats) -> Floats:
    """An operation on columns."""
    return apply(operation, operands)


def blocks(recipe: Recipe, tables: Sequence[Quantities], indices: Ints) -> Iterator[Block]:
    """Columns that a recipe makes of quantities.

    Args:
        recipe: function of an operation and one operand of each table.
        tables: [m] the quantities.
        indices: [K, m] which of them each column uses.
    """
    operators = 0

    def counted(*_: object) -> None:
        nonlocal operators
        operators += 1

    recipe(counted, *(None for _ in tables))
    for rows in np.split(indices, range(BATCH, len(indices), BATCH)) if len(indices) else ():
        yield Block(
            len(rows), operators, partial(_values, recipe, tables, rows), partial(_formula, recipe, tables, rows)
        )


def as_block(quantities: Quantities) -> Iterator[Block]:
    """Quantities as columns."""
    if len(quantities):
        yield Block(len(quantities), 0, lambda: quantities.values, quantities.formulas.__getitem__)


def joined(parts: Sequence[Quantities], num: int) -> Quantities:
    """All quantities of several tables of ``num`` designs."""
    values = np.concatenate([np.zeros((num, 0)), *(part.values for part in parts)], axis=1)
    return Quantities(tuple(formula for part in parts for formula in part.formulas), values)


def nearest_pairs(first: int, second: int | None = None, most: int = MOST_COLUMNS) -> Ints:
    """[K, 2] pairs of two of ``first``, or of one of ``first`` and one of ``second``, the nearest in order first.

    What is declared side by side belongs together more often than what is not, so that is what is kept of too many.

    >>> nearest_pairs(4, most=4).tolist()
    [[0, 1], [1, 2], [2, 3], [0, 2]]
    """
    if second is None:
        return _nearest(np.stack(np.triu_indices(first, 1), axis=1), most)
    return _nearest(np.indices((first, second)).reshape(2, -1).T, most)


def nearest_sets(number: int, size: int, most: int) -> Ints:
    """[K, size] ascending sets of ``number``, those of the smallest extent first.

    >>> nearest_sets(4, 3, 3).tolist()
    [[0, 1, 2], [1, 2, 3], [0, 1, 3]]
    """
    sets = [np.zeros((0, size), dtype=np.int64)]
    total = 0
    for extent in range(size - 1, number):
        inner = np.array(list(_inner(extent, size)), dtype=np.int64).reshape(-1, size)
        shifted = (np.arange(number - extent)[:, None, None] + inner[None]).reshape(-1, size)
        sets.append(shifted[: most - total])
        total += len(sets[-1])
        if total >= most:
            break
    return np.concatenate(sets)


def _inner(extent: int, size: int) -> Iterator[tuple[int, ...]]:
    """Sets from 0 to ``extent``, both included."""
    for middle in combinations(range(1, extent), size - 2):
        yield (0, *middle, extent)


def _nearest(pairs: Ints, most: int) -> Ints:
    distance = np.abs(pairs[:, 0] - pairs[:, 1])
    return pairs[np.argsort(distance, kind="stable")[:most]]


def _values(recipe: Recipe, tables: Sequence[Quantities], rows: Ints) -> Floats:
    return recipe(applied, *(table.values[:, rows[:, m]] for m, table in enumerate(tables)))


def _formula(recipe: Recipe, tables: Sequence[Quantities], rows: Ints, column: int) -> Formula:
    return recipe(Formula.of, *(table.formulas[rows[column, m]] for m, table in enumerate(tables)))
