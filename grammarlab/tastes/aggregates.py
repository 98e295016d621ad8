"""Productions about several draws at once: the largest, the smallest, the sum and the mean, whichever draws they are.

Draws are comparable if they are declared side by side and their names share a word: firstHeight and secondHeight, or
h1, h2 and h3. A model may use some of them only, such as the heights of the blocks that a tower has.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import reduce
from itertools import permutations, product
from typing import Any, TypeAlias

import numpy as np

from grammarlab.arrays import MANY_COLUMNS, MOST_COLUMNS
from grammarlab.tastes.basic_quantities import Elements, distinct
from grammarlab.tastes.quantities import (
    Block,
    Quantities,
    Recipe,
    as_block,
    blocks,
    joined,
    nearest_sets,
)
from grammarlab.tastes.roles import words_of

_OfLargest: TypeAlias = Callable[[Recipe], Recipe]
"""Recipe for draws that a model uses, given that of the largest."""


def extremes(elements: Elements) -> Iterator[Block]:
    """The largest and the smallest of a few draws, one beside the other, and another draw beside one of them."""
    for size in (2, 3, 4):
        sets = nearest_sets(len(elements.draws), size, MANY_COLUMNS)
        for recipe in (_applying("max"), _applying("min"), _range, _slenderness):
            yield from blocks(recipe, [elements.draws] * size, sets)
    sets = nearest_sets(len(elements.draws), 3, MANY_COLUMNS)
    for order, outer, inner in product(([0, 1, 2], [1, 0, 2], [2, 0, 1]), "/-", ("max", "min")):
        yield from blocks(_beside(outer, inner), [elements.draws] * 3, sets[:, order])


def orders_of_draws(elements: Elements) -> Iterator[Block]:
    """Three draws in an order by size, and comparable draws that a model uses that never fall, or never rise."""
    sets = nearest_sets(len(elements.draws), 3, MANY_COLUMNS)
    for order in permutations(range(3)):
        yield from blocks(_applying("ascending"), [elements.draws] * 3, sets[:, list(order)])
    for run in _comparable(elements):
        for indices in (np.array([run]), np.array([run[::-1]])):
            yield from blocks(_applying("ascending"), [elements.used] * len(run), indices)


def aggregates(elements: Elements) -> Iterator[Block]:
    """The sum, the mean, the largest and the smallest of the comparable draws that a model uses, and their range."""
    wholes = [_wholes(elements, run, _AGGREGATES) for run in _comparable(elements)]
    yield from as_block(distinct(joined(wholes, elements.num)))


def parts_of_wholes(elements: Elements) -> Iterator[Block]:
    """A draw beside the sum, the largest or the smallest of comparable draws: by ratio and difference.

    Of too many, those of draws whose names share a word with the comparable ones come first, heights beside heights,
    then those that are declared nearest to them.
    """
    runs, ends = _comparable(elements), range(len(_SUM_AND_ENDS))
    named = [set(words_of(str(draw))) for draw in elements.draws.formulas]
    ranked = [
        (not named[part] & set.intersection(*(named[other] for other in run)), distance, part, len(ends) * index + end)
        for index, run in enumerate(runs)
        for part, distance in enumerate(max(run[0] - part, part - run[-1], 0) for part in range(len(named)))
        for end in ends
    ]
    indices = np.array([rank[2:] for rank in sorted(ranked)[:MOST_COLUMNS]], dtype=np.int64)
    wholes = [_wholes(elements, run, _SUM_AND_ENDS) for run in runs]
    for operation in "/-":
        yield from blocks(_applying(operation), [elements.used, joined(wholes, elements.num)], indices.reshape(-1, 2))


def _wholes(elements: Elements, run: range, recipes: Sequence[_OfLargest]) -> Quantities:
    """What recipes make of comparable draws that a model uses."""
    largest, indices = _largest_used(elements, run), np.array([run])
    made = [block for recipe in recipes for block in blocks(recipe(largest), [elements.used] * len(run), indices)]
    return joined([Quantities((block.formula(0),), block.values()) for block in made], elements.num)


def _largest_used(elements: Elements, run: range) -> Recipe:
    """The largest of the draws that a model uses: 0 stands for those that it does not, and is above negative ones."""
    return _applying("max") if elements.used.values[:, run].min(initial=0.0) >= 0.0 else _negated_least


def _comparable(elements: Elements) -> list[range]:
    """Draws side by side whose names share a word, two or more."""
    named = [words_of(str(draw)) for draw in elements.draws.formulas]
    runs: dict[range, None] = {}
    for word in dict.fromkeys(word for words in named for word in words if not word.isdigit()):
        start = 0
        for end, words in enumerate([*named, ()]):
            if word not in words:
                if end - start > 1:
                    runs.setdefault(range(start, end))
                start = end + 1
    return list(runs)


def _applying(operation: str) -> Recipe:
    return lambda do, *parts: do(operation, *parts)


def _beside(outer: str, inner: str) -> Recipe:
    return lambda do, draw, *others: do(outer, draw, do(inner, *others))


def _range(do: Any, *parts: Any) -> Any:
    return do("-", do("max", *parts), do("min", *parts))


def _slenderness(do: Any, *parts: Any) -> Any:
    return do("/", do("max", *parts), do("min", *parts))


def _negated_least(do: Any, *parts: Any) -> Any:
    return do("-", 0.0, do("least", *(do("-", 0.0, part) for part in parts)))


def _beside_least(operation: str) -> _OfLargest:
    return lambda largest: lambda do, *parts: do(operation, largest(do, *parts), do("least", *parts))


def _sum(do: Any, *parts: Any) -> Any:
    return reduce(lambda total, part: do("+", total, part), parts)


def _mean(do: Any, *parts: Any) -> Any:
    return do("/", _sum(do, *parts), do("count", *parts))


_SUM_AND_ENDS: tuple[_OfLargest, ...] = (lambda _: _sum, lambda largest: largest, lambda _: _applying("least"))
_AGGREGATES = (*_SUM_AND_ENDS, lambda _: _mean, _beside_least("-"), _beside_least("/"))
