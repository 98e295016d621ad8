"""Tileset of a city, from its written shards."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.export.tiles.block_file import read_blocks
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.explicit_tileset import shard_folder, write_explicit
from grammarlab.export.tiles.implicit_tileset import write_implicit
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.export.tiles.tile_shard import Branch, TileWriter, read_shard, write_above

TILESET = "tileset.json"
"""Name of the file that viewers open."""


def write_city(
    folder: Path,
    grid: TileGrid,
    placement: EarthPlacement,
    shards: Sequence[TileCell],
    *,
    implicit: bool = False,
    name: str = TILESET,
) -> int:
    """Write the tileset of a city from its written shards, and the tiles above them.

    Args:
        folder: the folder of the city.
        grid: the quadtree.
        placement: the place of the city.
        shards: cells of the shards that have tiles, in any order, at least one.
        implicit: write an implicit tileset with subtrees, instead of tilesets that refer to those of the shards.
        name: name of its file in the folder.

    Returns:
        Number of all tiles with content.

    Raises:
        UsageError: If there are no shards.
        FileNotFoundError: If a shard is not complete.
    """
    if not shards:
        raise UsageError("tiles: expected at least one shard, found none")
    writer = TileWriter(folder, grid, placement, TileCell(0, 0, 0))
    root = _branch(folder, grid, writer, TileCell(0, 0, 0), shards)
    write = write_implicit if implicit else write_explicit
    write(folder / name, grid, root.node, placement.root_transform())
    return sum(node.has_content for node in root.node.walk())


def _branch(folder: Path, grid: TileGrid, writer: TileWriter, cell: TileCell, shards: Sequence[TileCell]) -> Branch:
    """Write the tiles of a cell above shards, with the models of a few shards in memory at a time."""
    if cell.level == grid.shard_level:
        node, summary = read_shard(folder, cell)
        return Branch(node, read_blocks(folder / shard_folder(cell) / "blocks.npz"), summary.num_models)
    depth = grid.shard_level - cell.level - 1
    below: dict[tuple[int, int], list[TileCell]] = {}
    for shard in shards:
        below.setdefault((shard.y >> depth, shard.x >> depth), []).append(shard)
    branches = [
        _branch(folder, grid, writer, TileCell(cell.level + 1, x, y), parts) for (y, x), parts in sorted(below.items())
    ]
    return write_above(writer, grid, cell, branches)
