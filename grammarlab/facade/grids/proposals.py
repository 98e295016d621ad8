"""Grids proposed for a facade from labels, positions and sizes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.facade.grid import Grid
from grammarlab.facade.grids.editing import arranged, topmost
from grammarlab.facade.grids.kinds import is_background, kinds, types
from grammarlab.facade.tree import LEAF, Facade

Ints = NDArray[np.int64]

WELL_FILLED = 0.75
"""Least share of filled places for a grid of nodes of one type, of any sizes."""
HALF_FILLED = 0.5
"""Least share of filled places for a grid of nodes of one size."""


def with_proposals(facade: Facade) -> Facade:
    """A facade with proposed grids, which replace any others.

    On each level, the elements are the topmost nodes with a label that is not one of the background, or without a label
    but repeated and without any background inside. Elements of one label form a grid if they fill most of its places;
    otherwise those of each size form one. The same applies inside each element, down to the leaves.
    """
    grids: list[Grid] = []
    pending, candidates = [0], _Candidates.of(facade)
    while pending:
        nodes = candidates.within(pending.pop(0))
        for group in _groups(facade, nodes, candidates):
            grids.append(arranged(facade, _name(facade, group, grids), group))
        pending += nodes[facade.axis[nodes] != LEAF].tolist()
    return replace(facade, grids=tuple(grids))


@dataclass(frozen=True, slots=True)
class _Candidates:
    """Possible elements of grids."""

    facade: Facade
    type: Ints
    """[N] types from `kinds.types`."""
    kind: Ints
    """[N] kinds from `kinds.kinds`."""
    background: NDArray[np.bool_]
    """[N] whether each node is background."""
    pure: NDArray[np.bool_]
    """[N] whether no leaf inside is background."""

    @classmethod
    def of(cls, facade: Facade) -> _Candidates:
        background = is_background(facade)
        walls = np.append(0, np.cumsum(background & (facade.axis == LEAF)))
        pure = walls[facade.end] == walls[np.arange(len(facade))]
        return cls(facade, types(facade), kinds(facade), background, pure)

    def within(self, scope: int) -> Ints:
        """The topmost elements inside a node, ascending."""
        inside = slice(scope, int(self.facade.end[scope]))
        chosen = ~self.background[inside]
        if not self.pure[scope]:
            _, place, counts = np.unique(self.type[inside], return_inverse=True, return_counts=True)
            chosen |= self.pure[inside] & (counts[place] > 1)
        everywhere = np.zeros(len(self.facade), dtype=np.bool_)
        everywhere[inside] = chosen
        everywhere[scope] = False
        return topmost(self.facade, everywhere)


def _groups(facade: Facade, nodes: Ints, candidates: _Candidates) -> Iterator[Ints]:
    """Sets of at least two nodes that form good grids."""
    called = np.where(facade.label[nodes] >= 0, facade.label[nodes], -1 - candidates.type[nodes])
    for label in np.unique(called).tolist():
        alike = nodes[called == label]
        if _fill(facade, alike) >= WELL_FILLED:
            yield alike
            continue
        kind = candidates.kind[alike]
        for each in np.unique(kind).tolist():
            if _fill(facade, alike[kind == each]) >= HALF_FILLED:
                yield alike[kind == each]


def _fill(facade: Facade, nodes: Ints) -> float:
    if len(nodes) < 2:
        return 0.0
    grid = arranged(facade, "", nodes)
    return len(nodes) / (grid.num_rows * grid.num_columns)


def _name(facade: Facade, group: Ints, grids: list[Grid]) -> str:
    name = facade.name_of(int(group[0])) or "part"
    return unused(name, [grid.name for grid in grids])


def unused(name: str, names: Iterable[str]) -> str:
    """The name itself, or the first of `name 2`, `name 3`, ... that is not in use.

    >>> unused("window", ["window", "window 2"])
    'window 3'
    """
    taken = set(names)
    if name not in taken:
        return name
    return next(each for each in (f"{name} {number}" for number in range(2, len(taken) + 3)) if each not in taken)
