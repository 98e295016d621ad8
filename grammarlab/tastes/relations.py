"""Productions about parts of trees: roles, pairs that are made alike, one choice beside or below another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from grammarlab.arrays import Flags, Ints
from grammarlab.features.patterns.pattern import Below, Formula, Pattern
from grammarlab.tastes.basic_quantities import Elements
from grammarlab.tastes.choice_pairs import Pairs, of_neighbours, of_three, pairs_below
from grammarlab.tastes.choice_places import summed
from grammarlab.tastes.quantities import Block, Quantities, Recipe, as_block, blocks

_MOST_CONTEXTS = 1_000
"""Largest number of pairs of choices, one beside or below the other."""
_MAX_ANCESTORS = 32
"""Largest number of levels between a choice and another one below it."""


def roles(elements: Elements) -> Iterator[Block]:
    """How often an alternative is chosen, under any of the symbols of its role."""
    nodes, role = elements.nodes, elements.lines.roles
    inside = np.flatnonzero(role.number[nodes.label] > 0)
    most = int(role.number.max(initial=0)) + 1
    code = role.kind * most + role.number
    counts = nodes.count(nodes.model[inside], code[nodes.label[inside]], most * (int(role.kind.max(initial=0)) + 1))
    sums: dict[int, Pattern | Formula] = {}
    for kind, number in product(role.shared, range(1, most)):
        labels = np.flatnonzero(code == kind * most + number).tolist()
        total = summed([nodes.pattern(label) for label in labels])
        if len(labels) > 1 and total is not None:
            sums[kind * most + number] = total
    return as_block(Quantities(tuple(sums.values()), counts[:, list(sums)]))


def sections(elements: Elements) -> Iterator[Block]:
    """How many nodes of a symbol have two choices alike, how many unlike, and whether all have."""
    return _of_pairs(pairs_below(elements.lines), (_alike, _unlike, _all))


def neighbours(elements: Elements) -> Iterator[Block]:
    """How many neighbours are alike, how many changes there are, and whether all or none are alike."""
    return _of_pairs(of_neighbours(elements.beside, elements.num), (_alike, _unlike, _all, _none))


def alternations(elements: Elements) -> Iterator[Block]:
    """Whether neighbours take turns: none are alike, and all are like the one after the next."""
    near, far = of_three(elements.beside, elements.num)
    indices = np.repeat(np.arange(len(near.both))[:, None], 4, axis=1)

    def recipe(do: Any, alike: Any, both: Any, alike_far: Any, both_far: Any) -> Any:
        return do("and", _none(do, alike, both), _all(do, alike_far, both_far))

    return blocks(recipe, [near.alike, near.both, far.alike, far.both], indices)


def contexts(elements: Elements) -> Iterator[Block]:
    """How often a choice is made beside or anywhere below another one."""
    nodes = elements.nodes
    chosen = nodes.labels.chosen[nodes.label]
    lower = np.flatnonzero(chosen)
    first = lower[nodes.following[lower] >= 0]
    yield from as_block(_contexts(elements, first, nodes.following[first], chosen, deep=False))
    rows, above = list[Ints](), list[Ints]()
    upper = nodes.parent[lower]
    for _ in range(_MAX_ANCESTORS):
        lower, upper = lower[upper >= 0], upper[upper >= 0]
        rows.append(lower)
        above.append(upper)
        upper = nodes.parent[upper]
    yield from as_block(_contexts(elements, np.concatenate(above), np.concatenate(rows), chosen, deep=True))


def _contexts(elements: Elements, first: Ints, second: Ints, chosen: Flags, *, deep: bool) -> Quantities:
    """Counts of the labels of pairs of nodes that are both choices."""
    nodes, size = elements.nodes, elements.nodes.labels.unknown + 1
    inside = chosen[first] & chosen[second]
    codes = nodes.label[first[inside]] * size + nodes.label[second[inside]]
    kinds, index, number = np.unique(codes, return_inverse=True, return_counts=True)
    frequent = np.sort(np.argsort(-number, kind="stable")[:_MOST_CONTEXTS])
    rank = np.full(len(kinds), -1)
    rank[frequent] = np.arange(len(frequent))
    is_frequent = rank[index] >= 0
    counts = nodes.count(nodes.model[first[inside][is_frequent]], rank[index[is_frequent]], len(frequent))
    pairs = [[nodes.pattern(label) for label in divmod(kind, size)] for kind in kinds[frequent].tolist()]
    formulas = [
        replace(a, below=(Below((b,), deep=True),)) if deep else Pattern(below=(Below((a, b)),)) for a, b in pairs
    ]
    return Quantities(tuple(formulas), counts)


def _of_pairs(pairs: Pairs, recipes: tuple[Recipe, ...]) -> Iterator[Block]:
    indices = np.repeat(np.arange(len(pairs.both))[:, None], 2, axis=1)
    for recipe in recipes:
        yield from blocks(recipe, [pairs.alike, pairs.both], indices)


def _alike(_do: Any, alike: Any, _both: Any) -> Any:
    return alike


def _unlike(do: Any, alike: Any, both: Any) -> Any:
    return do("-", both, alike)


def _all(do: Any, alike: Any, both: Any) -> Any:
    return do("and", do(">", both, 0.0), do("==", alike, both))


def _none(do: Any, alike: Any, both: Any) -> Any:
    return do("and", do(">", both, 0.0), do("==", alike, 0.0))
