"""Pairs of comparable choices that a model may have many times: of one node, and of parts side by side.

Both are sums of patterns, whatever their number: how many pairs there are, and how many are made alike. So "both sides
of all sections alike" and "no two neighbours alike" are said of any number of sections and neighbours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, islice, product
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import MANY, MANY_COLUMNS, MOST_COLUMNS, Flags, Floats, Ints
from grammarlab.features.patterns.pattern import Below, Formula, Pattern
from grammarlab.tastes.choice_lines import Line, Lines
from grammarlab.tastes.choice_places import total
from grammarlab.tastes.labelled_nodes import LabelledNodes
from grammarlab.tastes.quantities import Later, Quantities

_MAX_LEVELS = 3
"""Largest number of levels from a node or a part down to its choice."""


class Pair(NamedTuple):
    """Pairs of one kind in n models."""

    alike: Callable[[], Formula | Pattern]
    """Makes the count of those that are made alike."""
    num_alike: Floats
    """[n] this count."""
    both: Callable[[], Formula | Pattern]
    """Makes the count of all."""
    num_both: Floats
    """[n] this count."""


class Pairs(NamedTuple):
    """K kinds of pairs of choices."""

    alike: Quantities
    """Number of pairs that are made alike."""
    both: Quantities
    """Number of pairs."""

    @classmethod
    def of(cls, pairs: Sequence[Pair], num: int) -> Pairs:
        """Pairs of ``num`` models."""
        none = np.zeros((num, 0))
        alike = np.column_stack([none, *(pair.num_alike for pair in pairs)])
        both = np.column_stack([none, *(pair.num_both for pair in pairs)])
        return cls(
            Quantities(Later([pair.alike for pair in pairs]), alike),
            Quantities(Later([pair.both for pair in pairs]), both),
        )


def pairs_below(lines: Lines) -> Pairs:
    """Two choices below one node, where models have several such nodes."""
    return Pairs.of(list(islice(_pairs_below(lines), MOST_COLUMNS)), lines.nodes.num_models)


def of_neighbours(beside: Sequence[tuple[Pair, Pair | None]], num: int) -> Pairs:
    """The choices of a part and of its next sibling, where both have such a choice."""
    return Pairs.of([near for near, _ in beside], num)


def of_three(beside: Sequence[tuple[Pair, Pair | None]], num: int) -> tuple[Pairs, Pairs]:
    """Pairs of parts side by side, and of parts with one of them between."""
    both = [(near, far) for near, far in beside if far is not None]
    near, far = ([pair[index] for pair in both] for index in (0, 1))
    return Pairs.of(near, num), Pairs.of(far, num)


def _pairs_below(lines: Lines) -> Iterator[Pair]:
    tops: dict[str, list[Line]] = {}
    for length in range(1, _MAX_LEVELS + 1):
        for line in lines.groups(length, by_symbol=True):
            symbol = line.chain[0]
            below = tops.setdefault(symbol, []) if symbol else []
            if symbol and len(below) < MANY and len(np.unique(line.tops)) == len(line.tops):
                below.append(line)
    for symbol, below in tops.items():
        for first, second in combinations(below, 2):
            comparable = first.chain[-1] == second.chain[-1] or first.kind in lines.roles.shared
            if first.kind == second.kind and comparable:
                pair = _pair(lines.nodes, symbol, first, second)
                if pair is not None and pair.num_both.max(initial=0.0) > 1.0:
                    yield pair


def _pair(nodes: LabelledNodes, symbol: str, first: Line, second: Line) -> Pair | None:
    def joined(ones: Sequence[Pattern], others: Sequence[Pattern]) -> list[Pattern]:
        return [Pattern(symbol, below=(*one.below, *other.below)) for one, other in product(ones, others)]

    def alike() -> list[Pattern]:
        same = zip(first.alternatives, second.alternatives, strict=False)
        return [pattern for ones, others in same for pattern in joined(ones, others)]

    _, one, other = np.intersect1d(first.tops, second.tops, return_indices=True)
    if (first.rows[one] == second.rows[other]).any():
        return None
    num = sum(len(ones) * len(others) for ones, others in zip(first.labels, second.labels, strict=False))

    def both() -> list[Pattern]:
        return joined(first.any, second.any)

    return _pair_of(nodes, num, alike, both, first.rows[one], first.number[one] == second.number[other])


def pairs_beside(lines: Lines) -> list[tuple[Pair, Pair | None]]:
    """Comparable choices of parts at a distance of one and, if there are such, of two siblings."""
    pairs: list[tuple[Pair, Pair | None]] = []
    for length, by_symbol in product(range(_MAX_LEVELS), (True, False)):
        for line in lines.groups(length, by_symbol=by_symbol):
            is_known = line.chain[-1] is not None and not by_symbol
            if is_known or len(pairs) >= MOST_COLUMNS:
                continue
            order = np.argsort(line.tops, kind="stable")
            ordered = replace(line, tops=line.tops[order], number=line.number[order])
            if (np.diff(ordered.tops) > 0).all():
                near, far = (_siblings(lines.nodes, ordered, distance) for distance in (1, 2))
                pairs += [] if near is None else [(near, far)]
    return pairs


def _siblings(nodes: LabelledNodes, line: Line, distance: int) -> Pair | None:
    """The pairs of parts, ascending, at a distance."""
    following = _indices(line.tops, nodes.following[line.tops])
    rows = np.flatnonzero(following >= 0)
    partner = following[rows]
    for _ in range(distance - 1):
        inside = following[partner] >= 0
        rows, partner = rows[inside], following[partner[inside]]
    if not len(rows):
        return None

    def alike() -> list[Pattern]:
        return [run for ones in line.alternatives for run in _runs(ones, line.any, distance)]

    def both() -> list[Pattern]:
        return _runs(line.any, line.any, distance)

    num = sum(min(len(ones) ** 2 * len(line.bare) ** (distance - 1), MANY_COLUMNS + 1) for ones in line.labels)
    return _pair_of(nodes, num, alike, both, line.tops[rows], line.number[rows] == line.number[partner])


def _runs(ends: Sequence[Pattern], between: Sequence[Pattern], distance: int) -> list[Pattern]:
    """Runs of siblings of which the first and the last are some patterns."""
    runs = product(ends, *[between] * (distance - 1), ends)
    return [Pattern(below=(Below(run),)) for run in islice(runs, MANY_COLUMNS + 1)]


def _indices(part: Ints, targets: Ints) -> Ints:
    """Index of each row among ascending rows; -1 for none."""
    index = np.minimum(np.searchsorted(part, targets), len(part) - 1)
    return np.where(part[index] == targets, index, -1)


def _pair_of(
    nodes: LabelledNodes,
    num_patterns: int,
    alike: Callable[[], Sequence[Pattern]],
    both: Callable[[], Sequence[Pattern]],
    rows: Ints,
    same: Flags,
) -> Pair | None:
    """Pairs of some nodes, one of each pair; None if nothing or too much makes a pair alike.

    Args:
        nodes: all nodes.
        num_patterns: number of patterns of pairs that are made alike.
        alike: makes these patterns.
        both: makes the patterns of all pairs.
        rows: [R] a node of each pair.
        same: [R] whether it is made alike.
    """
    if not 0 < num_patterns <= MANY_COLUMNS:
        return None
    model = nodes.model[rows]
    num_alike, num_both = (np.bincount(m, minlength=nodes.num_models).astype(np.float64) for m in (model[same], model))
    return Pair(lambda: total(alike()), num_alike, lambda: total(both()), num_both)
