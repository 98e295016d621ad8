"""Removing what an earlier city has left in a folder, and nothing else."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path

from grammarlab.export.tiles.branch_file import read_tree
from grammarlab.export.tiles.tile_branch import TEXTURES
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.export.tiles.tile_shard import branch_path
from grammarlab.export.tiles.tile_tree import TileNode, content_name
from grammarlab.files import folder_below, remove_parts
from grammarlab.runs.city.parcel_listing import TILES
from grammarlab.runs.city.shard import FOLDER, RECORD

_TEXTURE = re.compile(r"[0-9a-f]{32}\.\w+")
"""Names of textures, which are hashes of their content."""


def clear_city(folder: Path, grid: TileGrid, shards: Mapping[TileCell, str], tilesets: Iterable[str]) -> None:
    """Remove what a city no longer has, and what is written anew: tilesets, subtrees and tiles above shards.

    Args:
        folder: folder of the city.
        grid: its quadtree.
        shards: keys of the trees of its shards; empty for one without tiles.
        tilesets: names of files that are written anew.
    """
    names = {f"{cell.x}_{cell.y}" for cell in shards}
    for entry in _entries(folder, FOLDER, "*"):
        if entry.name not in names and (entry / RECORD).is_file() and not entry.is_symlink():
            shutil.rmtree(entry)
    for name in tilesets:
        (folder / name).unlink(missing_ok=True)
    for path in _entries(folder, "subtrees", "*/*/*.subtree"):
        path.unlink()
    trees = [read_tree(branch_path(folder, grid, cell), key) for cell, key in shards.items() if key]
    nodes = [node for tree in trees if tree is not None for node in tree.walk()]
    tiles = {content_name(node.cell) for node in nodes if node.has_content}
    for path in _entries(folder, TILES, "*/*/*.glb"):
        if path.relative_to(folder).as_posix() not in tiles:
            path.unlink()
    _clear_textures(folder, nodes)


def _clear_textures(folder: Path, nodes: Iterable[TileNode]) -> None:
    used = {name for node in nodes if node.file for name in node.file.textures}
    for path in _entries(folder, TEXTURES, "*"):
        if _TEXTURE.fullmatch(path.name) and path.name not in used:
            path.unlink()
    remove_parts(folder / TEXTURES)


def _entries(folder: Path, name: str, pattern: str) -> list[Path]:
    """What matches a pattern in a folder of the city; nothing if it is missing or a link."""
    home = folder_below(folder, name)
    return sorted(home.glob(pattern)) if home else []
