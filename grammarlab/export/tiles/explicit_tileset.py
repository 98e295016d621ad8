"""Explicit tilesets: JSON with a tree of tiles, each with its box and its error."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from grammarlab.arrays import Floats
from grammarlab.export.model_files import GENERATOR, write_whole
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.export.tiles.tile_tree import TileNode, box_of, content_name

SHARD_TILESET = "tileset.json"
"""Name of the tileset of a shard in its folder."""


def shard_folder(cell: TileCell) -> str:
    """Path of the folder of a shard below the folder of the city."""
    return f"shards/{cell.x}_{cell.y}"


def write_shard_tileset(folder: Path, grid: TileGrid, shard: TileNode) -> None:
    """Write the tileset of a shard, which that of the city refers to."""
    root = _tile(shard, grid, "../../")
    path = folder / shard_folder(shard.cell) / SHARD_TILESET
    write_whole(path, json_bytes(tileset(root, shard.shown().error(grid), None)))


def write_explicit(path: Path, grid: TileGrid, root: TileNode, transform: Floats | None) -> None:
    """Write the tileset of a city, which refers to those of its shards.

    Args:
        path: the file, in the folder of the city.
        grid: the quadtree.
        root: the tree.
        transform: [4, 4] from the axes of the root to ECEF metres, if the place is known.
    """
    error = 2.0 * root.shown().error(grid)
    write_whole(path, json_bytes(tileset(_tile_above_shards(root, grid), error, transform)))


def tileset(root: dict[str, Any], error: float, transform: Floats | None, **properties: Any) -> dict[str, Any]:
    """A tileset of a root tile.

    Args:
        root: the tile.
        error: metres of the geometric error if nothing is drawn.
        transform: [4, 4] from the axes of the root to those of its parent.
        properties: further properties of the tileset.
    """
    tile = {**root, "refine": "REPLACE"}
    if transform is not None:
        tile["transform"] = transform.T.ravel().tolist()
    asset = {"version": "1.1", "generator": GENERATOR}
    return {"asset": asset, **properties, "geometricError": error, "root": tile}


def json_bytes(value: dict[str, Any]) -> bytes:
    """JSON without spaces."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()


def _tile(node: TileNode, grid: TileGrid, base: str) -> dict[str, Any]:
    """The tile of a node and those below it, with names of files relative to a base."""
    node = node.shown()
    tile = _entry(node, grid, base + content_name(node.cell))
    if node.children:
        tile["children"] = [_tile(child, grid, base) for child in node.children]
    return tile


def _tile_above_shards(node: TileNode, grid: TileGrid) -> dict[str, Any]:
    """The tile of a node that is above shards, or a reference to the tileset of a shard."""
    if node.cell.level == grid.shard_level:
        return _entry(node, grid, f"{shard_folder(node.cell)}/{SHARD_TILESET}")
    if not node.has_content and len(node.children) == 1:
        return _tile_above_shards(node.children[0], grid)
    children = [_tile_above_shards(child, grid) for child in node.children]
    return {**_entry(node, grid, content_name(node.cell)), "children": children}


def _entry(node: TileNode, grid: TileGrid, uri: str) -> dict[str, Any]:
    volume = {"box": box_of(node)}
    return {"boundingVolume": volume, "geometricError": node.shown().error(grid), "content": {"uri": uri}}
