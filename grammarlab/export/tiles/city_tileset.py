"""Tileset of a city, from its written shards."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.export.tiles.branch_file import Branch, read_branch
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.explicit_tileset import write_explicit
from grammarlab.export.tiles.implicit_tileset import write_implicit
from grammarlab.export.tiles.tile_branch import TileWriter, write_above
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.export.tiles.tile_shard import branch_path

TILESET = "tileset.json"
"""Name of the file that viewers open."""


def write_city(
    folder: Path,
    grid: TileGrid,
    placement: EarthPlacement,
    shards: Mapping[TileCell, str],
    *,
    implicit: bool = False,
    name: str = TILESET,
) -> int:
    """Write the tileset of a city from its written shards, and the tiles above them.

    Args:
        folder: the folder of the city.
        grid: the quadtree.
        placement: the place of the city.
        shards: keys of the shards that have tiles (`shard_keys`), in any order, at least one.
        implicit: write an implicit tileset with subtrees, instead of tilesets that refer to those of the shards.
        name: name of its file in the folder.

    Returns:
        Number of all tiles with content.

    Raises:
        UsageError: If there are no shards, or one is not written.
    """
    if not shards:
        raise UsageError("tiles: expected at least one shard, found none")
    writer = TileWriter(folder, grid, placement, TileCell(0, 0, 0))
    root = _branch(writer, TileCell(0, 0, 0), shards)
    write = write_implicit if implicit else write_explicit
    write(folder / name, grid, root.node, placement.root_transform())
    return sum(1 for _ in root.node.files())


def _branch(writer: TileWriter, cell: TileCell, shards: Mapping[TileCell, str]) -> Branch:
    """Write the tiles of a cell above shards, with the models of a few shards in memory at a time."""
    grid = writer.grid
    if cell.level == grid.shard_level:
        branch = read_branch(branch_path(writer.folder, grid, cell), shards[cell])
        if branch is None:
            raise UsageError(f"tiles: expected the written shard {tuple(cell)}, found none")
        return branch
    depth = grid.shard_level - cell.level - 1
    below = {TileCell(cell.level + 1, shard.x >> depth, shard.y >> depth) for shard in shards}
    branches = [
        _branch(writer, child, {shard: key for shard, key in shards.items() if _is_below(shard, child)})
        for child in cell.children
        if child in below
    ]
    return write_above(writer, cell, branches)


def _is_below(cell: TileCell, above: TileCell) -> bool:
    depth = cell.level - above.level
    return (cell.x >> depth, cell.y >> depth) == (above.x, above.y)
