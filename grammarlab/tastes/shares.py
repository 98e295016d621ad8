"""Productions about parts of a whole: shares of alternatives, how many kinds there are, and products of conditions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.tastes.basic_quantities import Elements
from grammarlab.tastes.quantities import Block, Quantities, Recipe, blocks, nearest_pairs

_MOST_PRODUCTS = 800
"""Largest number of products of a condition of each kind."""


def shares(elements: Elements) -> Iterator[Block]:
    """The share of an alternative among all choices of its symbol."""
    counts, totals, indices = _alternatives(elements)
    return blocks(lambda do, a, total: do("/", a, total), [counts, totals], indices)


def kinds(elements: Elements) -> Iterator[Block]:
    """How many alternatives of a choice occur, and how many of its results are not the most frequent one."""
    counts, totals, indices = _alternatives(elements)
    for total in np.unique(indices[:, 1]).tolist():
        members = indices[indices[:, 1] == total, 0]
        yield from blocks(lambda do, *parts: do("count", *parts), [counts] * len(members), members[None])
        recipe: Recipe = lambda do, whole, *parts: do("-", whole, do("max", *parts))  # noqa: E731
        yield from blocks(recipe, [totals, *[counts] * len(members)], np.array([[total, *members]]))


def conditional(elements: Elements) -> Iterator[Block]:
    """A draw, a number or another flag where a condition holds, else 0."""
    recipe: Recipe = lambda do, flag, a: do("*", flag, a)  # noqa: E731
    flags = elements.flags
    for others in (elements.draws, elements.numerals):
        yield from blocks(recipe, [flags, others], nearest_pairs(len(flags), len(others), _MOST_PRODUCTS))
    yield from blocks(recipe, [flags, flags], nearest_pairs(len(flags), most=_MOST_PRODUCTS))


def _alternatives(elements: Elements) -> tuple[Quantities, Quantities, Ints]:
    """Counts of the alternatives of choices, counts of the choices of each symbol, and [K, 2] which belong together."""
    nodes, labels = elements.nodes, elements.nodes.labels
    wholes = {label: labels.alternatives(label) for label in nodes.alternatives}
    numbers = {members: number for number, members in enumerate(dict.fromkeys(wholes.values()))}
    counts = nodes.count(nodes.model, nodes.label, labels.unknown + 1)
    parts = Quantities(tuple(map(nodes.pattern, wholes)), counts[:, list(wholes)])
    patterns = tuple(replace(nodes.pattern(members[0]), branch=()) for members in numbers)
    total = [counts[:, list(members)].sum(axis=1) for members in numbers]
    totals = Quantities(patterns, np.stack([np.zeros(elements.num), *total], axis=1)[:, 1:])
    return parts, totals, np.array(list(enumerate(numbers[members] for members in wholes.values()))).reshape(-1, 2)
