"""Shard of a city: its tiles of all levels and their tileset, written from one pass over its models."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.export.tiles.tile_models import TileModels


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
        UsageError: If a leaf is outside the shard or out of order.
    """
    raise NotImplementedError


def write_city(
    folder: Path, grid: TileGrid, placement: EarthPlacement, shards: Sequence[TileCell], *, implicit: bool = False
) -> int:
    """Write ``tileset.json`` of a city from its written shards, and the tiles above them.

    Args:
        folder: the folder of the city.
        grid: the quadtree.
        placement: the place of the city.
        shards: cells of the shards that have tiles, in any order.
        implicit: write an implicit tileset with subtrees, instead of tilesets that refer to those of the shards.

    Returns:
        Number of all tiles with content.
    """
    raise NotImplementedError
