"""Random facades with grids, and properties of all of them."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from grammarlab.arrays import Ints
from grammarlab.facade.editing.grids import topmost, with_grid
from grammarlab.facade.grid import Grid
from grammarlab.facade.tree import Facade
from tests.facade.strategies import trees


@st.composite
def gridded(draw: st.DrawFn, max_nodes: int = 40) -> Facade:
    """A random guillotine tree with two grids of random nodes on any level, also of the same or of nested ones."""
    facade = draw(trees(max_nodes))
    randomness = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    for name, part in (("one", 0.6), ("two", 0.3)):
        chosen = topmost(facade, randomness.random(len(facade)) < part * (np.arange(len(facade)) > 0))
        facade = with_grid(facade, name, chosen if chosen.size else [0])
    return facade


def transposed(facade: Facade) -> Facade:
    """The facade with x and y exchanged."""
    turned = Facade(
        parent=facade.parent,
        axis=np.where(facade.axis < 0, facade.axis, 1 - facade.axis).astype(np.int8),
        position=facade.position[:, ::-1].copy(),
        size=facade.size[:, ::-1].copy(),
        label=facade.label,
        labels=facade.labels,
        outline_offsets=facade.outline_offsets,
        outline_points=facade.outline_points,
        pictures=facade.pictures,
        picture=facade.picture,
        window=facade.window[:, [1, 0, 3, 2]],
    )
    # Rows count from the top, columns from the left.
    grids = [Grid(g.name, g.node, g.num_columns - 1 - g.column, g.num_rows - 1 - g.row) for g in facade.grids]
    return replace(turned, grids=tuple(grids))


def same_topology(one: Facade, other: Facade) -> bool:
    return np.array_equal(one.parent, other.parent) and np.array_equal(one.axis, other.axis)


def enclosing(facade: Facade) -> Ints:
    """[G] for each grid, the smallest grid of which it is a subgrid, -1 for none.

    A grid is a subgrid of another if one element of the other contains all of its elements.
    """
    above = np.full(len(facade.grids), -1, dtype=np.int64)
    for inner, grid in enumerate(facade.grids):
        nearest = -1
        for outer, other in enumerate(facade.grids):
            around = other.node[(other.node <= grid.node[0]) & (facade.end[other.node] >= facade.end[grid.node[-1]])]
            # A grid of a single node is not a subgrid of itself.
            if outer != inner and around.size and around[0] > nearest and not np.array_equal(around, grid.node):
                nearest, above[inner] = int(around[0]), outer
    return above
