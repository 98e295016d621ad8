"""Productions of arithmetic: sums, differences, products and ratios of counts and draws, and computed sizes.

A bound, a band or a level of what they make is no candidate: cells find these themselves. So ``a + b < 12`` is a
level of ``a + b``; only ``a > b`` of draws is one. Of more candidates than a production may have, those whose parts are
declared nearest to each other are kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from grammarlab.arrays import MANY, MOST_COLUMNS, SEVERAL, Ints
from grammarlab.tastes.basic_quantities import Elements, distinct
from grammarlab.tastes.quantities import (
    Block,
    Quantities,
    Recipe,
    blocks,
    joined,
    nearest_pairs,
    nearest_sets,
)

_MOST_SIZES = 3_000
"""Largest number of computed sizes of one form."""


def sums_of_two(elements: Elements) -> Iterator[Block]:
    """``a + b`` of two counts, or of two draws."""
    for quantities in (elements.draws, elements.used, elements.counts):
        yield from _of_pairs("+", quantities)


def differences(elements: Elements) -> Iterator[Block]:
    """``a - b`` of two counts, or of two draws."""
    for quantities in (elements.draws, elements.counts):
        yield from _of_pairs("-", quantities)


def comparisons(elements: Elements) -> Iterator[Block]:
    """``a > b`` of two draws: the bound on their difference is 0, and not any number."""
    yield from _of_pairs(">", elements.draws)


def products(elements: Elements) -> Iterator[Block]:
    """``a * b`` of two draws, of two counts, or of a count and a draw."""
    yield from _of_pairs("*", elements.draws)
    yield from _of_pairs("*", _numerals(elements))
    yield from _crossed(lambda do, n, a: do("*", n, a), [_numerals(elements), elements.used], MOST_COLUMNS)


def ratios(elements: Elements) -> Iterator[Block]:
    """``a / b`` of two draws, of two counts, or of a count and a draw."""
    yield from _of_pairs("/", elements.draws)
    yield from _of_pairs("/", elements.counts)
    yield from _crossed(lambda do, n, a: do("/", a, n), [_numerals(elements), elements.draws], MOST_COLUMNS)


def parities(elements: Elements) -> Iterator[Block]:
    """``n % 2`` of a count, or of the sum of two."""
    counts = elements.counts
    yield from blocks(lambda do, n: do("%", n, 2.0), [counts], np.arange(len(counts))[:, None])
    recipe: Recipe = lambda do, n, m: do("%", do("+", n, m), 2.0)  # noqa: E731  # one line per recipe
    yield from blocks(recipe, [counts, counts], nearest_pairs(len(counts), most=MOST_COLUMNS))


def longer_products(elements: Elements) -> Iterator[Block]:
    """``a * b * c`` and ``a * b / c`` of draws, and ``n * a * b``: so many floors of an area."""
    draws = elements.draws
    sets = nearest_sets(len(draws), 3, MOST_COLUMNS // 4)
    yield from blocks(lambda do, a, b, c: do("*", do("*", a, b), c), [draws] * 3, sets)
    for order in ([0, 1, 2], [0, 2, 1], [1, 2, 0]):
        yield from blocks(lambda do, a, b, c: do("/", do("*", a, b), c), [draws] * 3, sets[:, order])
    recipe: Recipe = lambda do, n, a, b: do("*", n, do("*", a, b))  # noqa: E731
    numerals, pairs = _numerals(elements), nearest_pairs(len(draws), most=MOST_COLUMNS)
    indices = np.array([(n, *pair) for n in range(len(numerals)) for pair in pairs.tolist()][:_MOST_SIZES])
    yield from blocks(recipe, [numerals, draws, draws], indices.reshape(-1, 3))


def mixed_products(elements: Elements) -> Iterator[Block]:
    """``(a + b) / c``, ``(a - b) / c``, ``(a + b) * c`` and ``(a - b) * c`` of draws."""
    sets = nearest_sets(len(elements.used), 3, MOST_COLUMNS // 3)
    sets = np.concatenate([sets[:, order] for order in ([0, 1, 2], [0, 2, 1], [1, 2, 0])])
    for inner, outer in product("+-", "/*"):
        yield from blocks(_mixed(inner, outer), [elements.used] * 3, sets)


def linear_sizes(elements: Elements) -> Iterator[Block]:
    """``n * a + b``: so many storeys on a plinth."""
    recipe: Recipe = lambda do, n, a, b: do("+", do("*", n, a), b)  # noqa: E731
    yield from _crossed(recipe, [_numerals(elements), elements.used, elements.used], _MOST_SIZES)


def proportions(elements: Elements) -> Iterator[Block]:
    """``n * a / c`` and ``(n * a + b) / c``: the height of so many storeys on a plinth by the width."""
    numerals, draws = _numerals(elements), elements.used
    shorter: Recipe = lambda do, n, a, c: do("/", do("*", n, a), c)  # noqa: E731
    yield from _crossed(shorter, [numerals, draws, draws], MOST_COLUMNS)
    recipe: Recipe = lambda do, n, a, b, c: do("/", do("+", do("*", n, a), b), c)  # noqa: E731
    yield from _crossed(recipe, [numerals, draws, draws, draws], _MOST_SIZES)


def _of_pairs(operation: str, quantities: Quantities) -> Iterator[Block]:
    pairs = nearest_pairs(len(quantities), most=MOST_COLUMNS)
    return blocks(lambda do, a, b: do(operation, a, b), [quantities, quantities], pairs)


def _mixed(inner: str, outer: str) -> Recipe:
    return lambda do, a, b, c: do(outer, do(inner, a, b), c)


def _numerals(elements: Elements) -> Quantities:
    """Numbers of things that may multiply draws: counts, and chosen numbers that begin at 0, 1 or 2."""
    several = [len(np.unique(choice.number)) > 2 for choice in elements.choices]
    chosen = elements.numbers.take(np.flatnonzero(several)[:SEVERAL])
    fewer, more = (_shifted(chosen, shift) for shift in (-1.0, 1.0))
    every = distinct(joined([chosen, fewer, more, elements.numerals], elements.num))
    return every.take(np.arange(min(len(every), MANY)))


def _shifted(numbers: Quantities, shift: float) -> Quantities:
    """Numbers that begin elsewhere, and are 0 where there is none."""
    recipe: Recipe = lambda do, number: do("*", do("!=", number, 0.0), do("+", number, shift))  # noqa: E731
    made = blocks(recipe, [numbers], np.arange(len(numbers))[:, None])
    parts = [Quantities(tuple(block.formula(i) for i in range(block.size)), block.values()) for block in made]
    return joined(parts, len(numbers.values))


def _crossed(recipe: Recipe, tables: list[Quantities], most: int) -> Iterator[Block]:
    """A recipe on a count and one or more different draws, those declared nearest to each other first."""
    numerals, *draws = tables
    sets = _arrangements(len(draws[0]), len(draws), most // max(1, len(numerals)))
    indices = np.column_stack([np.tile(np.arange(len(numerals)), len(sets)), np.repeat(sets, len(numerals), axis=0)])
    return blocks(recipe, tables, indices)


def _arrangements(number: int, size: int, most: int) -> Ints:
    """[K, size] different elements in any order, those of the smallest extent first.

    >>> _arrangements(3, 2, 3).tolist()
    [[0, 1], [1, 2], [1, 0]]
    """
    if size == 1:
        return np.arange(min(number, most))[:, None]
    orders = [list(order) for order in product(range(size), repeat=size) if len(set(order)) == size]
    sets = nearest_sets(number, size, -(-most // len(orders)))
    return np.concatenate([sets[:, order] for order in orders])[:most]
