"""Pairs of comparable choices that a model may have many times: of one node, and of parts side by side.

Both are sums of patterns, whatever their number: how many pairs there are, and how many are made alike. So "both sides
of all sections alike" and "no two neighbours alike" are said of any number of sections and neighbours.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, islice, product
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.features.patterns.pattern import Below, Formula, Pattern
from grammarlab.tastes.choice_lines import Line, Lines
from grammarlab.tastes.choice_places import summed
from grammarlab.tastes.labelled_nodes import LabelledNodes
from grammarlab.tastes.quantities import Quantities

_MAX_LEVELS = 3
"""Largest number of levels from a node or a part down to its choice."""
_MAX_PAIRS = 400
"""Largest number of kinds of pairs."""
_MAX_LINES = 24
"""Largest number of choices below the nodes of one symbol that are compared."""
_MAX_RUNS = 100
"""Largest number of patterns of a pair that is made alike."""


class _Pair(NamedTuple):
    alike: Formula | Pattern
    num_alike: Floats
    both: Formula | Pattern
    num_both: Floats


class Pairs(NamedTuple):
    """K kinds of pairs of choices."""

    alike: Quantities
    """Number of pairs that are made alike."""
    both: Quantities
    """Number of pairs."""

    @classmethod
    def of(cls, pairs: Sequence[_Pair], num: int) -> Pairs:
        """Pairs of ``num`` models."""
        none = np.zeros((num, 0))
        alike = np.column_stack([none, *(pair.num_alike for pair in pairs)])
        both = np.column_stack([none, *(pair.num_both for pair in pairs)])
        return cls(
            Quantities(tuple(pair.alike for pair in pairs), alike),
            Quantities(tuple(pair.both for pair in pairs), both),
        )


def pairs_below(lines: Lines) -> Pairs:
    """Two choices below one node, where models have several such nodes."""
    return Pairs.of(list(islice(_pairs_below(lines), _MAX_PAIRS)), lines.nodes.num_models)


def pairs_beside(lines: Lines) -> Pairs:
    """The choices of a part and of its next sibling, where both have such a choice."""
    return Pairs.of([near for near, _ in _pairs_beside(lines)], lines.nodes.num_models)


def pairs_of_three(lines: Lines) -> tuple[Pairs, Pairs]:
    """Pairs of parts side by side, and of parts with one of them between."""
    both = [(near, far) for near, far in _pairs_beside(lines) if far is not None]
    near, far = ([pair[index] for pair in both] for index in (0, 1))
    return Pairs.of(near, lines.nodes.num_models), Pairs.of(far, lines.nodes.num_models)


def _pairs_below(lines: Lines) -> Iterator[_Pair]:
    tops: dict[str, list[Line]] = {}
    for length in range(1, _MAX_LEVELS + 1):
        for line in lines.groups(length, by_symbol=True):
            symbol = line.chain[0]
            below = tops.setdefault(symbol, []) if symbol else []
            if symbol and len(below) < _MAX_LINES and len(np.unique(line.tops)) == len(line.tops):
                below.append(line)
    for symbol, below in tops.items():
        for first, second in combinations(below, 2):
            comparable = first.chain[-1] == second.chain[-1] or first.kind in lines.roles.shared
            if first.kind == second.kind and comparable:
                pair = _pair(lines.nodes, symbol, first, second)
                if pair is not None and pair.num_both.max(initial=0.0) > 1.0:
                    yield pair


def _pair(nodes: LabelledNodes, symbol: str, first: Line, second: Line) -> _Pair | None:
    def joined(ones: Sequence[Pattern], others: Sequence[Pattern]) -> list[Pattern]:
        return [Pattern(symbol, below=(*one.below, *other.below)) for one, other in product(ones, others)]

    _, one, other = np.intersect1d(first.tops, second.tops, return_indices=True)
    if (first.rows[one] == second.rows[other]).any():
        return None
    same = zip(first.alternatives, second.alternatives, strict=False)
    alike = [pattern for ones, others in same for pattern in joined(ones, others)]
    both = joined(first.any, second.any)
    return _pair_of(nodes, alike, both, first.rows[one], first.number[one] == second.number[other])


def _pairs_beside(lines: Lines) -> list[tuple[_Pair, _Pair | None]]:
    """Pairs at a distance of one and of two siblings."""
    pairs: list[tuple[_Pair, _Pair | None]] = []
    for length, by_symbol in product(range(_MAX_LEVELS), (True, False)):
        for line in lines.groups(length, by_symbol=by_symbol):
            order = np.argsort(line.tops, kind="stable")
            ordered = line._replace(tops=line.tops[order], number=line.number[order])
            is_known = line.chain[-1] is not None and not by_symbol
            if not is_known and len(pairs) < _MAX_PAIRS and (np.diff(ordered.tops) > 0).all():
                near, far = (_siblings(lines.nodes, ordered, distance) for distance in (1, 2))
                pairs += [] if near is None else [(near, far)]
    return pairs


def _siblings(nodes: LabelledNodes, line: Line, distance: int) -> _Pair | None:
    """The pairs of parts, ascending, at a distance."""
    following = _indices(line.tops, nodes.following[line.tops])
    rows = np.flatnonzero(following >= 0)
    partner = following[rows]
    for _ in range(distance - 1):
        inside = following[partner] >= 0
        rows, partner = rows[inside], following[partner[inside]]
    alike = [run for ones in line.alternatives for run in _runs(ones, line.any, distance)]
    same = line.number[rows] == line.number[partner]
    return _pair_of(nodes, alike, _runs(line.any, line.any, distance), line.tops[rows], same) if len(rows) else None


def _runs(ends: Sequence[Pattern], between: Sequence[Pattern], distance: int) -> list[Pattern]:
    """Runs of siblings of which the first and the last are some patterns."""
    runs = product(ends, *[between] * (distance - 1), ends)
    return [Pattern(below=(Below(run),)) for run in islice(runs, _MAX_RUNS + 1)]


def _indices(part: Ints, targets: Ints) -> Ints:
    """Index of each row among ascending rows; -1 for none."""
    index = np.minimum(np.searchsorted(part, targets), len(part) - 1)
    return np.where(part[index] == targets, index, -1)


def _pair_of(
    nodes: LabelledNodes, alike: Sequence[Pattern], both: Sequence[Pattern], rows: Ints, same: Flags
) -> _Pair | None:
    total, all_pairs, model = summed(alike), summed(both), nodes.model[rows]
    if total is None or all_pairs is None or len(alike) > _MAX_RUNS:
        return None
    num_alike, num_both = (np.bincount(m, minlength=nodes.num_models).astype(np.float64) for m in (model[same], model))
    return _Pair(total, num_alike, all_pairs, num_both)
