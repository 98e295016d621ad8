"""One grid from several: windows of different kinds in the same columns, storey above storey."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grammarlab.errors import FacadeError
from grammarlab.facade.grid import Grid
from grammarlab.facade.grids.editing import arranged
from grammarlab.facade.grids.proposals import WELL_FILLED
from grammarlab.facade.tree import Facade, X

_SHARED = 0.4
"""Least common part of all elements of a column, as a fraction of the widest."""


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
    gone = {joint.name}
    for grid in grids:
        try:
            both = arranged(facade, f"{joint.name} and {grid.name}", np.append(joint.node, grid.node))
        except FacadeError:  # one is inside the other
            continue
        if (
            both.num_columns == max(joint.num_columns, grid.num_columns)
            and both.num_rows == joint.num_rows + grid.num_rows
            and len(both.node) == len(joint.node) + len(grid.node)
            and len(both.node) >= WELL_FILLED * both.num_rows * both.num_columns
            and _concentric(facade, both)
        ):
            gone.add(grid.name)
            joint = both
    return replace(facade, grids=(joint, *(grid for grid in facade.grids if grid.name not in gone)))


def _concentric(facade: Facade, grid: Grid) -> bool:
    """Whether all elements of each column share a good part of the widest one's width."""
    low, size = facade.position[grid.node, X], facade.size[grid.node, X]
    left, right, widest = np.full((3, grid.num_columns), [[-np.inf], [np.inf], [0.0]])
    np.maximum.at(left, grid.column, low)
    np.minimum.at(right, grid.column, low + size)
    np.maximum.at(widest, grid.column, size)
    return bool((right - left >= _SHARED * widest).all())
