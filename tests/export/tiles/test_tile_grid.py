"""The quadtree of tiles against its definition."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid, morton

PLACES = np.random.default_rng(0).uniform(-30_000, 30_000, (200, 3))


def test_places_lie_in_their_leaves_and_shards():
    grid = TileGrid.around(PLACES)
    leaves = grid.leaves(PLACES)
    for level, cells in ((grid.leaf_level, leaves), (grid.shard_level, grid.shards(leaves))):
        origins = np.array([grid.origin(TileCell(level, x, y)) for x, y in cells.tolist()])
        assert (np.abs(PLACES - origins)[:, [0, 2]] <= grid.size(level) / 2).all()


def test_cells_do_not_depend_on_other_places():
    near, far = TileGrid.around(PLACES[:3]), TileGrid.around(PLACES)
    np.testing.assert_array_equal(near.leaves(PLACES), far.leaves(PLACES))
    assert TileGrid.around(PLACES * 10).num_levels == 15


def test_parents_contain_their_cells():
    grid = TileGrid(10)
    cell = TileCell(9, 301, 77)
    while cell.level:
        apart = np.abs(grid.origin(cell) - grid.origin(cell.parent))[[0, 2]]
        np.testing.assert_array_equal(apart, grid.size(cell.level) / 2)
        cell = cell.parent
    assert cell == TileCell(0, 0, 0)


def test_morton_interleaves_bits():
    cells = np.random.default_rng(0).integers(0, 2**15, (50, 2))
    for (x, y), code in zip(cells.tolist(), morton(cells).tolist(), strict=True):
        pairs = "".join(b + a for a, b in zip(f"{x:015b}", f"{y:015b}", strict=True))
        assert code == int(pairs, 2)


def test_a_city_beyond_the_grid_is_refused():
    with pytest.raises(UsageError, match="within"):
        TileGrid.around(np.array([[5e6, 0.0, 0.0]]))
