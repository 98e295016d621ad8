"""Removing what an earlier city has left in a folder, and nothing else."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path

from grammarlab.export.tiles.tile_grid import TileCell
from grammarlab.export.tiles.tile_shard import read_shard
from grammarlab.export.tiles.tile_tree import content_name
from grammarlab.files import folder_below
from grammarlab.runs.city.parcel_listing import TILES
from grammarlab.runs.city.shard import FOLDER, RECORD


def clear_city(folder: Path, shards: Sequence[TileCell], tilesets: Iterable[str]) -> None:
    """Remove tiles and shards that a city no longer has, and what is written anew: tilesets and tiles above shards.

    Args:
        folder: folder of the city.
        shards: cells of its written shards.
        tilesets: names of the tilesets.
    """
    names = {f"{cell.x}_{cell.y}" for cell in shards}
    home = folder_below(folder, FOLDER)
    for entry in sorted(home.iterdir()) if home else []:
        if entry.name not in names and (entry / RECORD).is_file() and not entry.is_symlink():
            shutil.rmtree(entry)
    for name in tilesets:
        (folder / name).unlink(missing_ok=True)
    kept = _tiles_of(folder, shards)
    tiles = folder_below(folder, TILES)
    for tile in sorted(tiles.glob("*/*/*.glb")) if tiles else []:
        if tile.relative_to(folder).as_posix() not in kept:
            tile.unlink()


def _tiles_of(folder: Path, shards: Sequence[TileCell]) -> set[str]:
    """Names of the tiles of shards."""
    nodes = (node for shard in shards for node in read_shard(folder, shard)[0].walk())
    return {content_name(node.cell) for node in nodes if node.has_content}
