"""Grids proposed for a facade from labels, positions and sizes, and merged where storeys have the same columns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Ints
from grammarlab.errors import FacadeError
from grammarlab.facade.editing.grids import arranged, is_background, kinds, topmost, types
from grammarlab.facade.grid import Grid
from grammarlab.facade.tree import LEAF, Facade, X

_WELL_FILLED = 0.75
"""Least share of filled places for a grid of nodes of one type, of any sizes."""
_HALF_FILLED = 0.5
"""Least share of filled places for a grid of nodes of one size."""
_LEAST_COMMON_SHARE = 0.4
"""Least common part of all elements of a column, as a fraction of the widest."""


def with_proposals(facade: Facade) -> Facade:
    """A facade with proposed grids, which replace any others.

    On each level, the elements are the topmost nodes with a label that is not one of the background, or without a label
    but repeated and without any background inside. Elements of one label form a grid if they fill most of its places;
    otherwise those of each size form one. The same applies inside each element, down to the leaves.
    """
    grids: list[Grid] = []
    pending, candidates = [0], _Candidates.of_facade(facade)
    while pending:
        nodes = candidates.within(pending.pop(0))
        for group in _groups(facade, nodes, candidates):
            grids.append(arranged(facade, _name(facade, group, grids), group))
        pending += nodes[facade.axis[nodes] != LEAF].tolist()
    return replace(facade, grids=tuple(grids))


def unused(name: str, names: Iterable[str]) -> str:
    """The name itself, or the first of `name 2`, `name 3`, ... that is not in use.

    >>> unused("window", ["window", "window 2"])
    'window 3'
    """
    used = set(names)
    if name not in used:
        return name
    return next(
        candidate for candidate in (f"{name} {number}" for number in range(2, len(used) + 3)) if candidate not in used
    )


def with_joint(facade: Facade) -> Facade:
    """A facade whose largest grid is merged with all grids that continue it.

    A grid continues another if both together have the columns of the one with more, a row for each row of both, fill
    most of their places, and share the middle of each column. So storeys with other windows gain and lose the same
    columns.
    """
    grids = sorted(facade.grids, key=lambda grid: -len(grid.node))
    joint = grids.pop(0) if grids else None
    if joint is None:
        return facade
    merged_names = {joint.name}
    for grid in grids:
        try:
            both = arranged(facade, f"{joint.name} and {grid.name}", np.append(joint.node, grid.node))
        except FacadeError:  # one is inside the other
            continue
        if (
            both.num_columns == max(joint.num_columns, grid.num_columns)
            and both.num_rows == joint.num_rows + grid.num_rows
            and len(both.node) == len(joint.node) + len(grid.node)
            and len(both.node) >= _WELL_FILLED * both.num_rows * both.num_columns
            and _concentric(facade, both)
        ):
            merged_names.add(grid.name)
            joint = both
    return replace(facade, grids=(joint, *(grid for grid in facade.grids if grid.name not in merged_names)))


@dataclass(frozen=True, slots=True)
class _Candidates:
    """Possible elements of grids."""

    facade: Facade
    type: Ints
    """[N] types from `grids.types`."""
    kind: Ints
    """[N] kinds from `grids.kinds`."""
    background: NDArray[np.bool_]
    """[N] whether each node is background."""
    pure: NDArray[np.bool_]
    """[N] whether no leaf inside is background."""

    @classmethod
    def of_facade(cls, facade: Facade) -> _Candidates:
        background = is_background(facade)
        walls = np.append(0, np.cumsum(background & (facade.axis == LEAF)))
        pure = walls[facade.end] == walls[np.arange(len(facade))]
        return cls(facade, types(facade), kinds(facade), background, pure)

    def within(self, scope: int) -> Ints:
        """The topmost elements inside a node, ascending."""
        inside = slice(scope, int(self.facade.end[scope]))
        chosen = ~self.background[inside]
        if not self.pure[scope]:
            _, type_index, counts = np.unique(self.type[inside], return_inverse=True, return_counts=True)
            chosen |= self.pure[inside] & (counts[type_index] > 1)
        mask = np.zeros(len(self.facade), dtype=np.bool_)
        mask[inside] = chosen
        mask[scope] = False
        return topmost(self.facade, mask)


def _groups(facade: Facade, nodes: Ints, candidates: _Candidates) -> Iterator[Ints]:
    """Sets of at least two nodes that form good grids."""
    labels = np.where(facade.label[nodes] >= 0, facade.label[nodes], -1 - candidates.type[nodes])
    for label in np.unique(labels).tolist():
        members = nodes[labels == label]
        if _fill(facade, members) >= _WELL_FILLED:
            yield members
            continue
        member_kind = candidates.kind[members]
        for kind in np.unique(member_kind).tolist():
            if _fill(facade, members[member_kind == kind]) >= _HALF_FILLED:
                yield members[member_kind == kind]


def _fill(facade: Facade, nodes: Ints) -> float:
    if len(nodes) < 2:
        return 0.0
    grid = arranged(facade, "", nodes)
    return len(nodes) / (grid.num_rows * grid.num_columns)


def _name(facade: Facade, group: Ints, grids: list[Grid]) -> str:
    name = facade.name_of(int(group[0])) or "part"
    return unused(name, [grid.name for grid in grids])


def _concentric(facade: Facade, grid: Grid) -> bool:
    """Whether all elements of each column share a good part of the widest one's width."""
    low, size = facade.position[grid.node, X], facade.size[grid.node, X]
    left, right, widest = np.full((3, grid.num_columns), [[-np.inf], [np.inf], [0.0]])
    np.maximum.at(left, grid.column, low)
    np.minimum.at(right, grid.column, low + size)
    np.maximum.at(widest, grid.column, size)
    return bool((right - left >= _LEAST_COMMON_SHARE * widest).all())
