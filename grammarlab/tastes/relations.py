"""Productions about parts of trees: roles, pairs that are made alike, one choice beside another, shares and kinds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from grammarlab.arrays import MOST_COLUMNS, Flags, Ints
from grammarlab.features.patterns.pattern import Below, Formula, Pattern
from grammarlab.tastes.basic_quantities import Elements
from grammarlab.tastes.choice_pairs import Pairs, of_neighbours, of_three, pairs_below
from grammarlab.tastes.choice_places import summed
from grammarlab.tastes.quantities import Block, Quantities, Recipe, as_block, blocks, nearest_pairs


def roles(elements: Elements) -> Iterator[Block]:
    """How often an alternative is chosen, under any of the symbols of its role."""
    return as_block(_of_roles(elements)[0])


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
    rows, above = [lower[:0]], [lower[:0]]
    upper = nodes.parent[lower]
    while (upper >= 0).any():  # a pattern of places below another one has no largest depth
        lower, upper = lower[upper >= 0], upper[upper >= 0]
        rows.append(lower)
        above.append(upper)
        upper = nodes.parent[upper]
    yield from as_block(_contexts(elements, np.concatenate(above), np.concatenate(rows), chosen, deep=True))


def shares(elements: Elements) -> Iterator[Block]:
    """The share of an alternative among all choices of its symbol."""
    counts, totals, indices = _alternatives(elements)
    return blocks(lambda do, a, total: do("/", a, total), [counts, totals], indices)


def kinds(elements: Elements) -> Iterator[Block]:
    """How many alternatives of a choice or of a role occur, and how many results are not the most frequent one."""
    counts, totals, indices = _alternatives(elements)
    for total in np.unique(indices[:, 1]).tolist():
        members = indices[indices[:, 1] == total, 0]
        yield from blocks(lambda do, *parts: do("count", *parts), [counts] * len(members), members[None])
        recipe: Recipe = lambda do, whole, *parts: do("-", whole, do("max", *parts))  # noqa: E731
        yield from blocks(recipe, [totals, *[counts] * len(members)], np.array([[total, *members]]))
    sums, kind = _of_roles(elements)
    for members in (np.flatnonzero(kind == one) for one in np.unique(kind)):
        yield from blocks(lambda do, *parts: do("count", *parts), [sums] * len(members), members[None])
        yield from blocks(_not_most, [sums] * len(members), members[None])


def conditional(elements: Elements) -> Iterator[Block]:
    """A draw, a number or another flag where a condition holds, else 0."""
    recipe: Recipe = lambda do, flag, a: do("*", flag, a)  # noqa: E731
    flags = elements.flags
    for others in (elements.draws, elements.numerals):
        yield from blocks(recipe, [flags, others], nearest_pairs(len(flags), len(others), MOST_COLUMNS))
    yield from blocks(recipe, [flags, flags], nearest_pairs(len(flags), most=MOST_COLUMNS))


def _of_roles(elements: Elements) -> tuple[Quantities, Ints]:
    """Counts of K alternatives under all symbols of their roles, and [K] the roles."""
    nodes, role = elements.nodes, elements.lines.roles
    inside = np.flatnonzero(role.number[nodes.label] > 0)
    most = int(role.number.max(initial=0)) + 1
    code = role.kind * most + role.number
    counts = nodes.count(nodes.model[inside], code[nodes.label[inside]], most * (int(role.kind.max(initial=0)) + 1))
    sums: dict[int, Pattern | Formula] = {}
    for kind, number in product(role.shared, range(1, most)):
        labels = np.flatnonzero(code == kind * most + number).tolist()
        total = summed([nodes.pattern(label) for label in labels])
        if total is not None:
            sums[kind * most + number] = total
    codes = np.array(list(sums), dtype=np.int64)
    return Quantities(tuple(sums.values()), counts[:, codes]), codes // most


def _not_most(do: Any, *parts: Any) -> Any:
    """All parts but the largest."""
    total = parts[0]
    for part in parts[1:]:
        total = do("+", total, part)
    return do("-", total, do("max", *parts))


def _contexts(elements: Elements, first: Ints, second: Ints, chosen: Flags, *, deep: bool) -> Quantities:
    """Counts of the labels of pairs of nodes that are both choices."""
    nodes, size = elements.nodes, elements.nodes.labels.unknown + 1
    inside = chosen[first] & chosen[second]
    codes = nodes.label[first[inside]] * size + nodes.label[second[inside]]
    kinds, index, number = np.unique(codes, return_inverse=True, return_counts=True)
    frequent = np.sort(np.argsort(-number, kind="stable")[:MOST_COLUMNS])
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
