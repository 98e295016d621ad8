"""Candidates that scores choose, as formulas: tables of pairs, orders by which sequences never fall, mixed sets."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from functools import partial, reduce
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.features.patterns.pattern import Atom, Feature, Formula
from grammarlab.preference.judge.learned_orders import LearnedOrder, learned_orders
from grammarlab.preference.judge.pair_tables import MixedSets, PairTable, mixed_sets, pair_tables
from grammarlab.tastes.basic_quantities import Elements, distinct
from grammarlab.tastes.choice_places import Choice, Outcome
from grammarlab.tastes.quantities import Quantities, is_short
from grammarlab.tastes.sequences import sequences_of


class ChosenCandidate(NamedTuple):
    """A column that some scores suggest."""

    values: Floats
    """[n]"""
    price: float
    """Description length in nats."""
    formula: Callable[[], Feature]
    """Makes what it is."""


def chosen_candidates(elements: Elements, scores: Floats) -> Iterator[ChosenCandidate]:
    """Columns that may explain scores [n] of the designs of some elements."""
    productions = (_tables, _orders, _mixtures)
    for make in productions:
        for candidate in make(elements, scores):
            if is_short(candidate.formula()):
                # As if votes and weighted sums had no share (`grammarlab.preference.judge.judge`).
                yield candidate._replace(price=candidate.price + float(np.log(2.0) + np.log(len(productions))))


def _tables(elements: Elements, scores: Floats) -> Iterator[ChosenCandidate]:
    """Which alternatives of two choices go together."""
    choices = (*elements.outcomes, *elements.choices)
    numbers = _numbers(choices, elements.num)
    for table in pair_tables(numbers, scores):
        formula = partial(_of_table, choices[table.first], choices[table.second], table)
        yield ChosenCandidate(table.values(numbers), table.price, formula)


def _orders(elements: Elements, scores: Floats) -> Iterator[ChosenCandidate]:
    """Whether a sequence of choices never falls in an order of their alternatives."""
    numbers = _numbers(elements.choices, elements.num)
    for order in learned_orders(numbers, sequences_of(elements), scores):
        yield ChosenCandidate(order.values(numbers), order.price, partial(_of_order, elements, order))


def _mixtures(elements: Elements, scores: Floats) -> Iterator[ChosenCandidate]:
    """Whether a design has parts of two sets."""
    counts = elements.counts
    parts = distinct(Quantities(counts.formulas, (counts.values > 0.0).astype(np.float64)))
    has = parts.values > 0.0
    for mixed in mixed_sets(has, scores):
        yield ChosenCandidate(mixed.values(has), mixed.price, partial(_of_sets, parts.formulas, mixed))


def _numbers(choices: Sequence[Choice | Outcome], num: int) -> Ints:
    """[num, K] numbers of the alternatives of K choices."""
    return np.array([choice.number for choice in choices], dtype=np.int64).reshape(len(choices), num).T


def _of_table(first: Choice | Outcome, second: Choice | Outcome, table: PairTable) -> Atom | Formula:
    """Whether one of the pairs occurs."""
    ones_of: dict[frozenset[int], set[int]] = {}
    for one in dict.fromkeys(one for one, _ in table.cells):
        ones_of.setdefault(frozenset(b for a, b in table.cells if a == one), set()).add(one)
    pairs = [[*_any(first, ones), *_any(second, others)] for others, ones in ones_of.items()]
    rows = [reduce(partial(Formula.of, "and"), pair[1:], pair[0]) for pair in pairs if pair]
    return reduce(partial(Formula.of, "or"), rows[1:], rows[0])


def _of_sets(parts: Sequence[Atom | Formula], mixed: MixedSets) -> Formula:
    """Whether there is any part of either set."""
    first, second = (
        reduce(partial(Formula.of, "+"), (parts[index] for index in members[1:]), parts[members[0]])
        for members in (mixed.first, mixed.second)
    )
    return Formula.of("and", first, second)


def _any(choice: Choice | Outcome, numbers: Collection[int]) -> list[Atom | Formula]:
    """Whether a choice has any of some alternatives, 0 for none; nothing if it cannot be otherwise."""
    has_none = 0 in numbers
    listed = [
        count
        for number, count in enumerate(choice.alternatives, 1)
        if count is not None and (number in numbers) != has_none
    ]
    if not listed:
        return []
    some = reduce(partial(Formula.of, "+"), listed[1:], listed[0])
    return [Formula.of("not", some) if has_none else some]


def _of_order(elements: Elements, order: LearnedOrder) -> Formula:
    choices = [elements.choices[index] for index in order.sequence]
    return Formula.of("ascending", *(replace(choice, order=order.order).formula for choice in choices))
