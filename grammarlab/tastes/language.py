"""The candidates for what a person may like: columns of numbers with formulas and prices.

The price of a candidate is its description length in nats: log 2 to use a candidate at all, the log of the number of
productions and of the candidates of its own, and log 2 for each operation after the first, where an aggregate of
comparable draws counts as an element. So exp(-price) is a prior over the language, and sums to less than 1. Candidates
that are the same in all designs are left out, and of those that are equal up to a shift and a factor one is kept: an
element of the language, or else the cheapest. Of too many candidates each production keeps its cheapest, a fair share,
and the cheapest of the others fill what remains.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple, TypeAlias

import numpy as np

from grammarlab.arrays import ROUNDING, Floats
from grammarlab.features.patterns.pattern import Feature
from grammarlab.tastes import aggregates, arithmetic, relations, sequences
from grammarlab.tastes.basic_quantities import Elements
from grammarlab.tastes.quantities import Block, as_block

MAX_CANDIDATES = 20_000
"""Largest number of candidates."""
_DIGITS = round(-math.log10(ROUNDING))
"""Number of digits by which columns differ."""

Production: TypeAlias = Callable[[Elements], Iterator[Block]]


@dataclass(frozen=True)
class Candidates:
    """C candidates: elements in the order of the productions, then what is made of them, the cheapest first.

    Of too many, those beyond the fair share of their production come last.
    """

    makers: tuple[Callable[[], Feature], ...]
    """[C] functions that make what they are: few of many thousands are ever needed."""
    values: Floats
    """[n, C] their values for n designs."""
    prices: Floats
    """[C] their prices in nats."""
    elements: Elements
    """What they are made of."""

    @cached_property
    def formulas(self) -> tuple[Feature, ...]:
        """[C] what they are."""
        return tuple(make() for make in self.makers)


def counts(elements: Elements) -> Iterator[Block]:
    """Counts of nodes and of outcomes of choices."""
    return as_block(elements.counts)


def draws(elements: Elements) -> Iterator[Block]:
    """Random numbers."""
    return as_block(elements.draws)


PRODUCTIONS: Mapping[str, Production] = {
    "counts": counts,
    "draws": draws,
    "choices": sequences.choices,
    "roles": relations.roles,
    "positions": sequences.positions,
    "equal choices": sequences.equal_choices,
    "relations of sequences": sequences.relations,
    "likenesses": sequences.likenesses,
    "halves": sequences.halves,
    "gradations": sequences.gradations,
    "orders": sequences.orders,
    "matching sequences": sequences.matching_sequences,
    "sections": relations.sections,
    "neighbours": relations.neighbours,
    "alternations": relations.alternations,
    "contexts": relations.contexts,
    "shares": relations.shares,
    "kinds": relations.kinds,
    "conditional": relations.conditional,
    "sums of two": arithmetic.sums_of_two,
    "differences": arithmetic.differences,
    "comparisons": arithmetic.comparisons,
    "products": arithmetic.products,
    "ratios": arithmetic.ratios,
    "parities": arithmetic.parities,
    "longer products": arithmetic.longer_products,
    "mixed products": arithmetic.mixed_products,
    "linear sizes": arithmetic.linear_sizes,
    "proportions": arithmetic.proportions,
    "extremes": aggregates.extremes,
    "orders of draws": aggregates.orders_of_draws,
    "aggregates": aggregates.aggregates,
    "parts of wholes": aggregates.parts_of_wholes,
}
"""The productions of the language."""


class _Priced(NamedTuple):
    block: Block
    price: float


def candidates(elements: Elements, productions: Mapping[str, Production] = PRODUCTIONS) -> Candidates:
    """Candidates that distinguish designs.

    Args:
        elements: what the designs consist of.
        productions: productions of the language, by name.

    >>> import grammarlab as gl
    >>> forest = gl.derive(gl.Grammar.parse("attr w = rand(1, 2)  Lot --> 50% : A else : B"), 50, seed=1)
    >>> [str(formula) for formula in candidates(Elements.of([forest])).formulas[:2]]
    ['Lot:0', 'w']
    """
    return collected([priced(list(make(elements)), len(productions)) for make in productions.values()], elements)


def priced(blocks: Sequence[Block], num_productions: int) -> list[_Priced]:
    """The columns of one production with their prices."""
    size = sum(block.size for block in blocks)
    base = np.log(2.0) + np.log(num_productions) + np.log(max(size, 1))
    return [_Priced(block, float(base + np.log(2.0) * max(block.operators - 1, 0))) for block in blocks]


def collected(productions: Sequence[Sequence[_Priced]], elements: Elements) -> Candidates:
    """The different columns of productions for the designs of some elements."""
    place, makers, priors = dict[bytes, int](), list[Callable[[], Feature]](), list[float]()
    columns = np.empty((MAX_CANDIDATES, elements.num))
    for block, price in _in_order(productions, MAX_CANDIDATES):
        if len(makers) >= MAX_CANDIDATES:
            break
        values, prior = block.values(), math.exp(-price)
        for index, form in _forms(values):
            known = place.setdefault(form, len(makers))
            if known < len(makers):
                priors[known] += prior
            elif known < MAX_CANDIDATES:
                columns[known] = values[:, index]
                makers.append(partial(block.formula, index))
                priors.append(prior)
    return Candidates(tuple(makers), columns[: len(makers)].T, -np.log(np.array(priors)), elements)


def _in_order(productions: Sequence[Sequence[_Priced]], most: int) -> list[_Priced]:
    """The columns in the order of their prices, elements first; those beyond a fair share of their production last."""
    share = _fair_share([sum(part.block.size for part in parts) for parts in productions], most)
    fair, beyond = list[_Priced](), list[_Priced]()
    for parts in productions:
        room = share
        for block, price in sorted(parts, key=_rank):
            first, rest = block.split(min(room, block.size))
            fair.append(_Priced(first, price))
            beyond.append(_Priced(rest, price))
            room -= first.size
    return [part for group in (fair, beyond) for part in sorted(group, key=_rank) if part.block.size]


def _rank(part: _Priced) -> float:
    return part.price if part.block.operators else 0.0


def _fair_share(sizes: Sequence[int], most: int) -> int:
    """Largest number of columns that each production may have so that all have room.

    >>> _fair_share([10, 500, 300], 450)
    220
    """
    room = most
    for index, size in enumerate(sorted(sizes)):
        share = room // (len(sizes) - index)
        if size > share:
            return share
        room -= size
    return max(sizes, default=0)


def _forms(values: Floats) -> Iterator[tuple[int, bytes]]:
    """Index of each column [n, K] that is not constant, and what it has in common with its multiples and shifts."""
    if not len(values):
        return
    centred = values - values.mean(axis=0)
    size = np.abs(centred).max(axis=0)
    varying = np.flatnonzero(size > ROUNDING * np.maximum(1.0, np.abs(values).max(axis=0)))
    scaled = np.round(centred[:, varying] / size[varying], _DIGITS)
    first = (scaled != 0.0).argmax(axis=0)
    scaled = (scaled * np.sign(scaled[first, np.arange(len(varying))])).T + 0.0
    yield from zip(varying.tolist(), map(bytes, np.ascontiguousarray(scaled.astype(np.float32))), strict=True)
