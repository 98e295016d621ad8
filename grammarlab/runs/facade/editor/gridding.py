"""Manual editing of grids: the nodes of a click and a lasso, and names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from grammarlab.errors import FacadeError
from grammarlab.facade.grids.editing import grid_of, lasso, toggled, with_grid
from grammarlab.facade.grids.proposals import unused
from grammarlab.facade.tree import Facade, Ints


def pressed(facade: Facade, grid: str, node: int) -> int:
    """The node selected by a press on a leaf, for a grid.

    It is the element of the grid that contains the leaf; otherwise the topmost node around it that has the label of an
    element and contains none of the others; otherwise the leaf.

    Raises:
        FacadeError: If the facade has no such node.
    """
    if not 0 <= node < len(facade):
        raise FacadeError(f"Node {node}: expected 0 to {len(facade) - 1}.")
    elements = grid_of(facade, grid).node
    around = _around(facade, node)
    holding = np.intersect1d(around, elements)
    if holding.size:
        return int(holding[0])
    called = set(facade.label[elements].tolist()) - {-1}
    free = [
        each
        for each in around.tolist()
        if facade.label[each] in called and not ((elements > each) & (elements < facade.end[each])).any()
    ]
    return free[0] if free else node


def with_pressed(facade: Facade, grid: str, node: int) -> Facade:
    """A facade after a press on a leaf: the selected node is added to the grid, or removed from it."""
    return toggled(facade, grid, [pressed(facade, grid, node)])


def with_lasso(facade: Facade, low: ArrayLike, high: ArrayLike) -> tuple[Facade, str]:
    """A facade with a new grid of the elements in a rectangle, and the name of the grid.

    Raises:
        FacadeError: If only background is entirely inside it.
    """
    nodes = lasso(facade, low, high)
    if not nodes.size:
        raise FacadeError("No element is inside this rectangle: draw it around windows, doors or other elements.")
    names = {facade.name_of(node) for node in nodes.tolist()}
    name = unused(names.pop() if len(names) == 1 else "grid", [grid.name for grid in facade.grids])
    return with_grid(facade, name, nodes), name


def renamed(facade: Facade, name: str, to: str) -> Facade:
    """A facade with a renamed grid.

    Raises:
        FacadeError: If the name is empty, or another grid has it.
    """
    grid, to = grid_of(facade, name), to.strip()
    if not to or to in {other.name for other in facade.grids if other is not grid}:
        raise FacadeError(f"{to!r}: expected a name that no other grid has.")
    return replace(facade, grids=tuple(replace(each, name=to) if each is grid else each for each in facade.grids))


def _around(facade: Facade, node: int) -> Ints:
    """The ancestors of a node, and itself, the topmost first."""
    found = [node]
    while facade.parent[found[-1]] >= 0:
        found.append(int(facade.parent[found[-1]]))
    return np.array(found[::-1])
