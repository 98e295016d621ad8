"""Squares of the tiles of a city: a quadtree around the origin of its frame, whose cells do not depend on the city."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import UsageError

LEAF_SIZE = 128
"""Side of the smallest cells in metres: about 20 buildings in full detail."""
SUBTREE_LEVELS = 5
"""Levels of a shard, and of a subtree of implicit tilesets."""
_MOST_SUBTREES = 3
"""Largest number of subtrees above each other: 2,097 km."""


class TileCell(NamedTuple):
    """A square of the quadtree, as implicit tilings count them."""

    level: int
    """0 for the root."""
    x: int
    """0 <= x < 2**level, to the east."""
    y: int
    """0 <= y < 2**level, to the north."""

    @property
    def parent(self) -> TileCell:
        """The cell that contains this one; only below the root."""
        return TileCell(self.level - 1, self.x >> 1, self.y >> 1)

    @property
    def children(self) -> tuple[TileCell, ...]:
        """The four cells in this one, in Morton order."""
        return tuple(TileCell(self.level + 1, 2 * self.x + x, 2 * self.y + y) for y in (0, 1) for x in (0, 1))


@dataclass(frozen=True, slots=True)
class TileGrid:
    """A quadtree centred on the origin of a frame; its leaves are squares of `LEAF_SIZE`.

    A *shard* is a cell of 16 x 16 leaves: the unit that one process writes. A *quad* is one of 2 x 2 leaves: the unit
    that is written again after a change.

    >>> grid = TileGrid.around(np.array([[10.0, 0.0, -200.0]]))
    >>> grid.leaves(np.array([[10.0, 0.0, -200.0]])).tolist(), grid.size(grid.leaf_level)
    ([[256, 257]], 128.0)
    """

    num_levels: int
    """10 (65 km), or 15 if models are farther away: a multiple of `SUBTREE_LEVELS`."""

    @classmethod
    def around(cls, places: Floats) -> TileGrid:
        """The smallest grid that holds places [n, 3] in metres of the frame: x east, y up, z south.

        Raises:
            UsageError: If a place is beyond the largest grid.
        """
        farthest = float(np.abs(places[:, [0, 2]]).max(initial=0.0))
        grids = [cls(subtrees * SUBTREE_LEVELS) for subtrees in range(2, _MOST_SUBTREES + 1)]
        reach = grids[-1].size(0) / 2
        if not farthest < reach:
            raise UsageError(f"tiles: expected places within {reach:g} m of the origin, found {farthest:g} m")
        return next(grid for grid in grids if farthest < grid.size(0) / 2)

    @property
    def leaf_level(self) -> int:
        """Level of the leaves."""
        return self.num_levels - 1

    @property
    def quad_level(self) -> int:
        """Level of the quads."""
        return self.num_levels - 2

    @property
    def shard_level(self) -> int:
        """Level of the shards."""
        return self.num_levels - SUBTREE_LEVELS

    def size(self, level: int) -> float:
        """Side of the cells of a level in metres."""
        return float(LEAF_SIZE << (self.leaf_level - level))

    def leaves(self, places: Floats) -> Ints:
        """[n, 2] x and y of the leaves of places [n, 3] in metres of the frame: x east, y up, z south."""
        east_north = places[:, [0, 2]] * (1.0, -1.0)
        return np.floor(east_north / LEAF_SIZE).astype(np.int64) + (1 << self.leaf_level) // 2

    def shards(self, leaves: Ints) -> Ints:
        """[n, 2] x and y of the shards of leaves [n, 2]."""
        return leaves >> (SUBTREE_LEVELS - 1)

    def origin(self, cell: TileCell) -> Floats:
        """[3] origin of a tile: the middle of its cell at height 0, in metres of the frame (x east, y up, z south)."""
        size = self.size(cell.level)
        east, north = (size * (index + 0.5) - self.size(0) / 2 for index in (cell.x, cell.y))
        return np.array([east, 0.0, -north])


def morton(cells: Ints) -> Ints:
    """[n] place of cells [n, 2] of one level in Morton order: bits of x and y in turns, x lowest.

    >>> morton(np.array([[0, 0], [1, 0], [0, 1], [1, 1], [2, 0]])).tolist()
    [0, 1, 2, 3, 4]
    """
    code = np.zeros(len(cells), dtype=np.int64)
    for bit in range(31):
        for axis in range(2):
            code |= (cells[:, axis] >> bit & 1) << (2 * bit + axis)
    return code
