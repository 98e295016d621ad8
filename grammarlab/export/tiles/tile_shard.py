"""Shard of a city: its tiles of all levels and their tileset, written from one pass over its models."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.export.model_files import write_whole
from grammarlab.export.tiles.block_file import write_blocks
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.explicit_tileset import json_bytes, shard_folder, write_shard_tileset
from grammarlab.export.tiles.simplified_models import simplified
from grammarlab.export.tiles.texture_colors import TextureColors
from grammarlab.export.tiles.tile_file import Level, TileSummary, write_tile
from grammarlab.export.tiles.tile_grid import SUBTREE_LEVELS, TileCell, TileGrid
from grammarlab.export.tiles.tile_models import TileModels, joined_tiles
from grammarlab.export.tiles.tile_tree import TileNode, box_in_root, content_path
from grammarlab.files import read_bounded
from grammarlab.scene.instance_bounds import scene_bounds
from grammarlab.scene.triangles import count_triangles
from grammarlab.scene.used_tables import with_used_tables

_MAX_RECORD = 1 << 22
"""Largest size of the record of a shard in bytes: 341 tiles have about 100 kB."""
TEXTURES = "textures"
"""Folder of the textures of all tiles below the folder of the city."""
MOST_BLOCK_TRIANGLES = 20_000
"""Most triangles of a tile of blocks: about a megabyte. The largest models are kept."""


@dataclass(frozen=True, slots=True)
class ShardSummary:
    """What was written for one shard; the rest is in its folder, so a shard is complete when this returns."""

    cell: TileCell
    num_models: int
    num_tiles: int
    num_bytes: int
    """Sum of all GLB files."""
    most_draws: int
    """Largest number of draws of a tile."""


def write_shard(
    folder: Path,
    grid: TileGrid,
    placement: EarthPlacement,
    shard: TileCell,
    leaves: Iterable[tuple[TileCell, TileModels]],
    assets: Path | None = None,
) -> ShardSummary:
    """Write the tiles of a shard, one leaf in memory at a time: ``t/LEVEL/X/Y.glb`` and ``shards/X_Y/``.

    Args:
        folder: the folder of the city.
        grid: the quadtree.
        placement: the place of the city.
        shard: the cell of the shard, at ``grid.shard_level``.
        leaves: leaf cells with models in Morton order (`morton`), each once; models count from ``grid.origin(cell)``.
        assets: folder of the textures; None leaves them out.

    Raises:
        UsageError: If a leaf is outside the shard or out of order, or there are none.
    """
    writer = TileWriter(folder, grid, placement, shard, assets)
    rest = _Leaves(leaves)
    branch = _write_branch(writer, grid, shard, rest)
    if branch is None or rest.cell is not None:
        found = "none" if rest.cell is None else f"{tuple(rest.cell)} after the last of them"
        raise UsageError(f"tiles: expected leaves of the shard {tuple(shard)} in Morton order, found {found}")
    target = folder / shard_folder(shard)
    write_shard_tileset(folder, grid, branch.node)
    write_blocks(target / "blocks.npz", branch.models)
    summary = writer.summary(branch.num_models)
    # Last: with it, the shard is complete.
    record = {"tree": _record(branch.node), "summary": [summary.num_models, *summary_numbers(summary)]}
    write_whole(target / "shard.json", json_bytes(record))
    return summary


def read_shard(folder: Path, shard: TileCell) -> tuple[TileNode, ShardSummary]:
    """The tree of a written shard and its summary.

    Raises:
        FileNotFoundError: If the shard is not complete.
    """
    record = json.loads(read_bounded(folder / shard_folder(shard) / "shard.json", _MAX_RECORD))
    return _node(record["tree"]), ShardSummary(shard, *record["summary"])


class TileWriter:
    """Files of tiles in the making, with their sums.

    Args:
        folder: the folder of the city.
        grid: the quadtree.
        placement: the place of the city.
        top: the cell that contains all tiles.
        assets: folder of the textures.
    """

    def __init__(
        self, folder: Path, grid: TileGrid, placement: EarthPlacement, top: TileCell, assets: Path | None = None
    ) -> None:
        self._folder = folder
        self._grid = grid
        self._assets = assets
        self.colors = TextureColors(assets)
        self._cell = top
        self._placement = placement
        self._matrices: dict[TileCell, Floats] = {}
        self._tiles: list[TileSummary] = []

    def write(self, cell: TileCell, tile: TileModels, level: Level) -> tuple[Floats, Floats]:
        """Write the file of a tile; the corners of its box in the axes of the root."""
        matrix = self._matrix(cell)
        written = write_tile(
            content_path(self._folder, cell), tile, level, matrix, self._assets, self._folder / TEXTURES
        )
        self._tiles.append(written)
        return box_in_root(written.low, written.high, matrix)

    def summary(self, num_models: int) -> ShardSummary:
        """Sums of all written tiles."""
        tiles = self._tiles
        num_bytes, most_draws = sum(tile.bytes for tile in tiles), max((tile.draws for tile in tiles), default=0)
        return ShardSummary(self._cell, num_models, len(tiles), num_bytes, most_draws)

    def _matrix(self, cell: TileCell) -> Floats:
        """[4, 4] of a tile; those of all cells of a level below the top are computed at once."""
        if cell not in self._matrices:
            depth = cell.level - self._cell.level
            side = range(1 << depth) if depth < SUBTREE_LEVELS else range(0)
            first = self._cell.x << depth, self._cell.y << depth
            cells = [TileCell(cell.level, first[0] + x, first[1] + y) for y in side for x in side] or [cell]
            origins = np.array([self._grid.origin(each) for each in cells])
            self._matrices.update(zip(cells, self._placement.tile_matrices(origins), strict=True))
        return self._matrices[cell]


@dataclass(frozen=True, slots=True)
class Branch:
    """A written part of the tree, and its models for the tiles above it."""

    node: TileNode
    models: TileModels
    """From the origin of the cell: the whole models of a leaf; above, the largest ones as blocks."""
    num_models: int


class _Leaves:
    """Leaves with their models, of which the next one can be looked at."""

    def __init__(self, leaves: Iterable[tuple[TileCell, TileModels]]) -> None:
        self._leaves = iter(leaves)
        self._next = next(self._leaves, None)

    @property
    def cell(self) -> TileCell | None:
        """The cell of the next leaf; None after the last one."""
        return None if self._next is None else self._next[0]

    def pop(self) -> TileModels:
        """The models of the next leaf, if there is one."""
        if self._next is None:
            raise StopIteration
        models = self._next[1]
        self._next = next(self._leaves, None)
        return models


def _write_branch(writer: TileWriter, grid: TileGrid, cell: TileCell, leaves: _Leaves) -> Branch | None:
    """Write a cell and all below it; None if the next leaf is outside."""
    if leaves.cell is None or not _is_below(leaves.cell, cell):
        return None
    if cell.level == grid.leaf_level:
        models = leaves.pop()
        models = replace(models, scene=with_used_tables(models.scene))
        return Branch(TileNode.above(cell, writer.write(cell, models, "full")), models, len(models))
    cells = [TileCell(cell.level + 1, 2 * cell.x + x, 2 * cell.y + y) for y in (0, 1) for x in (0, 1)]
    branches = [branch for child in cells if (branch := _write_branch(writer, grid, child, leaves)) is not None]
    return write_above(writer, grid, cell, branches)


def write_above(writer: TileWriter, grid: TileGrid, cell: TileCell, branches: Sequence[Branch]) -> Branch:
    """Write the tile of a cell above written ones, at least one."""
    models = _together(grid, cell, branches)
    box = None
    if cell.level == grid.leaf_level - 1:
        plain, block = simplified(models.scene, light=writer.colors.light(models.scene.materials))
        box = writer.write(cell, replace(models, scene=plain), "plain")
        models = replace(models, scene=block)
    else:
        models = largest(models, MOST_BLOCK_TRIANGLES)
        if len(branches) > 1 or cell.level == grid.leaf_level - 2:
            box = writer.write(cell, models, "block")
    node = TileNode.above(cell, box, [branch.node for branch in branches])
    return Branch(node, models, sum(branch.num_models for branch in branches))


def largest(tile: TileModels, most_triangles: int) -> TileModels:
    """The models of the largest boxes that have at most so many triangles in all; at least one model."""
    counts = count_triangles(tile.scene)
    if counts.sum() <= most_triangles:
        return tile
    low, high = scene_bounds(tile.scene)
    order = np.argsort(-np.prod(high - low, axis=1), kind="stable")
    num = max(1, int(np.searchsorted(np.cumsum(counts[order]), most_triangles, side="right")))
    return tile.take(np.sort(order[:num]))


def summary_numbers(summary: ShardSummary) -> tuple[int, int, int]:
    """Numbers of tiles, bytes and draws of a summary."""
    return summary.num_tiles, summary.num_bytes, summary.most_draws


def _together(grid: TileGrid, cell: TileCell, branches: Sequence[Branch]) -> TileModels:
    """The models of branches, from the origin of the cell."""
    origin = grid.origin(cell)
    return joined_tiles([branch.models.moved(grid.origin(branch.node.cell) - origin) for branch in branches])


def _is_below(cell: TileCell, above: TileCell) -> bool:
    depth = cell.level - above.level
    return depth >= 0 and (cell.x >> depth, cell.y >> depth) == (above.x, above.y)


def _record(node: TileNode) -> list[object]:
    return [*node.cell, node.low.tolist(), node.high.tolist(), node.has_content, [_record(c) for c in node.children]]


def _node(record: list) -> TileNode:
    level, x, y, low, high, has_content, children = record
    cell = TileCell(level, x, y)
    return TileNode(cell, np.array(low), np.array(high), has_content, tuple(_node(child) for child in children))
