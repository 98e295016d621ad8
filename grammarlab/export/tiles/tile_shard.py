"""Shards of a city: the tiles of their quads, and those above them with their tileset.

A quad is written from its models, and kept with what the tiles above it need. So after a change, only the changed
quads and what is above them is written again; the key of a cell is the hash of the keys in it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path

from grammarlab.errors import UsageError
from grammarlab.export.tiles.branch_file import Branch, read_branch, write_branch
from grammarlab.export.tiles.explicit_tileset import shard_folder, write_shard_tileset
from grammarlab.export.tiles.tile_branch import TEXTURES, TileWriter, write_above, write_leaf
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.export.tiles.tile_tree import TileNode, content_path

BRANCHES = "branches"
"""Folder of the branches below the folder of a shard."""


def write_quad(writer: TileWriter, quad: TileCell, key: str, leaves: Sequence[tuple[TileCell, TileModels]]) -> TileNode:
    """Write the tiles of a quad and of its leaves; its branch comes last.

    Args:
        writer: writer of the tiles.
        quad: the cell.
        key: hash of all that decides about its tiles.
        leaves: leaf cells with models in Morton order (`morton`), each once; models count from ``grid.origin(cell)``.

    Raises:
        UsageError: If a leaf is outside the quad or out of order, or there are none.
    """
    cells = [cell for cell, _ in leaves]
    if not cells or cells != [cell for cell in quad.children if cell in set(cells)]:
        found = ", ".join(str(tuple(cell)) for cell in cells) or "none"
        raise UsageError(f"tiles: expected leaves of the quad {tuple(quad)} in Morton order, found {found}")
    branch = write_above(writer, quad, [write_leaf(writer, cell, models) for cell, models in leaves])
    write_branch(branch_path(writer.folder, writer.grid, quad), key, branch)
    return branch.node


def write_shard(writer: TileWriter, shard: TileCell, quads: Mapping[TileCell, str]) -> TileNode:
    """Write the tiles of a shard above its quads, and its tileset; those that are there already are kept.

    Args:
        writer: writer of the tiles.
        shard: the cell of the shard, at ``grid.shard_level``.
        quads: keys of its written quads, at least one.

    Raises:
        UsageError: If a quad is not written.
    """
    branch = _branch(writer, shard, shard_keys(writer.grid, shard, quads))
    write_shard_tileset(writer.folder, writer.grid, branch.node)
    return branch.node


def shard_keys(grid: TileGrid, shard: TileCell, quads: Mapping[TileCell, str]) -> dict[TileCell, str]:
    """Keys of the cells from the quads up to a shard: the hash of the keys in a cell.

    Args:
        grid: the quadtree.
        shard: the cell of the shard.
        quads: keys of its quads.
    """
    keys = dict(quads)
    for level in range(grid.quad_level - 1, shard.level - 1, -1):
        for cell in {cell.parent for cell in keys if cell.level == level + 1}:
            parts = [(tuple(child), keys[child]) for child in cell.children if child in keys]
            keys[cell] = sha256(repr(parts).encode()).hexdigest()
    return keys


def branch_path(folder: Path, grid: TileGrid, cell: TileCell) -> Path:
    """File of the branch of a cell, in the folder of its shard.

    Args:
        folder: folder of the city.
        grid: the quadtree.
        cell: a quad, a shard, or a cell between.
    """
    depth = cell.level - grid.shard_level
    shard = TileCell(grid.shard_level, cell.x >> depth, cell.y >> depth)
    return folder / shard_folder(shard) / BRANCHES / f"{cell.level}_{cell.x}_{cell.y}.branch"


def has_files(folder: Path, node: TileNode) -> bool:
    """Whether the files of a tile and of all below it are there, in their sizes, with their textures."""
    sizes = all(_has_size(content_path(folder, each.cell), each.file.num_bytes) for each in node.walk() if each.file)
    return sizes and all((folder / TEXTURES / name).is_file() for name in textures_of(node))


def textures_of(node: TileNode) -> set[str]:
    """Names of the textures of a tile and of all below it."""
    return {name for file in node.files() for name in file.textures}


def _branch(writer: TileWriter, cell: TileCell, keys: Mapping[TileCell, str]) -> Branch:
    """The branch of a cell, which is kept if it has the key, and else written above those in it."""
    path = branch_path(writer.folder, writer.grid, cell)
    kept = read_branch(path, keys[cell])
    if kept is not None and has_files(writer.folder, kept.node):
        return kept
    if cell.level == writer.grid.quad_level:
        raise UsageError(f"tiles: expected the written quad {tuple(cell)}, found none")
    branch = write_above(writer, cell, [_branch(writer, child, keys) for child in cell.children if child in keys])
    write_branch(path, keys[cell], branch)
    return branch


def _has_size(path: Path, num_bytes: int) -> bool:
    try:
        return path.lstat().st_size == num_bytes
    except OSError:
        return False
