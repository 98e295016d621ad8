"""Branches of the tree of tiles: the files of a leaf, and of a cell above written ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.asset_roots import AssetRoot
from grammarlab.export.tiles.branch_file import Branch
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.simplified_models import simplified
from grammarlab.export.tiles.texture_colors import TextureColors
from grammarlab.export.tiles.tile_file import Level, write_tile
from grammarlab.export.tiles.tile_grid import SUBTREE_LEVELS, TileCell, TileGrid
from grammarlab.export.tiles.tile_models import TileModels, joined_tiles
from grammarlab.export.tiles.tile_tree import TileFile, TileNode, box_in_root, content_path
from grammarlab.scene.instance_bounds import scene_bounds
from grammarlab.scene.triangles import count_triangles
from grammarlab.scene.used_tables import with_used_tables

TEXTURES = "textures"
"""Folder of the textures of all tiles below the folder of the city."""
MOST_BLOCK_TRIANGLES = 20_000
"""Most triangles of a tile of blocks: about a megabyte. The largest models are kept."""


class TileWriter:
    """Writes the files of tiles of one city.

    Args:
        folder: the folder of the city.
        grid: the quadtree.
        placement: the place of the city.
        top: the cell that contains all tiles.
        assets: folder of the textures; None leaves them out.
    """

    def __init__(
        self, folder: Path, grid: TileGrid, placement: EarthPlacement, top: TileCell, assets: AssetRoot | None = None
    ) -> None:
        self.folder = folder
        self.grid = grid
        self.colors = TextureColors(assets)
        self._assets = assets
        self._top = top
        self._placement = placement
        self._matrices: dict[TileCell, Floats] = {}

    def write(self, cell: TileCell, tile: TileModels, level: Level) -> tuple[tuple[Floats, Floats], TileFile]:
        """Write the file of a tile; the corners of its box in the axes of the root, and the file."""
        matrix = self._matrix(cell)
        path = content_path(self.folder, cell)
        written = write_tile(path, tile, level, matrix, self._assets, self.folder / TEXTURES)
        box = box_in_root(written.low, written.high, matrix)
        return box, TileFile(written.bytes, written.draws, written.textures)

    def _matrix(self, cell: TileCell) -> Floats:
        """[4, 4] of a tile; those of all cells of a level below the top are computed at once."""
        if cell not in self._matrices:
            depth = cell.level - self._top.level
            side = range(1 << depth) if depth < SUBTREE_LEVELS else range(0)
            first = self._top.x << depth, self._top.y << depth
            cells = [TileCell(cell.level, first[0] + x, first[1] + y) for y in side for x in side] or [cell]
            origins = np.array([self.grid.origin(each) for each in cells])
            self._matrices.update(zip(cells, self._placement.tile_matrices(origins), strict=True))
        return self._matrices[cell]


def write_leaf(writer: TileWriter, cell: TileCell, models: TileModels) -> Branch:
    """Write the tile of a leaf."""
    models = replace(models, scene=with_used_tables(models.scene))
    return Branch(TileNode.above(cell, *writer.write(cell, models, "full")), models)


def write_above(writer: TileWriter, cell: TileCell, branches: Sequence[Branch]) -> Branch:
    """Write the tile of a cell above written ones, at least one in Morton order."""
    grid = writer.grid
    models = _together(grid, cell, branches)
    box, file = None, None
    if cell.level == grid.quad_level:
        plain, block = simplified(models.scene, light=writer.colors.light(models.scene.materials))
        box, file = writer.write(cell, replace(models, scene=plain), "plain")
        models = replace(models, scene=block)
    else:
        models = largest(models, MOST_BLOCK_TRIANGLES)
        if len(branches) > 1 or cell.level == grid.quad_level - 1:
            box, file = writer.write(cell, models, "block")
    return Branch(TileNode.above(cell, box, file, [branch.node for branch in branches]), models)


def largest(tile: TileModels, most_triangles: int) -> TileModels:
    """The models of the largest boxes that have at most so many triangles in all; at least one model."""
    counts = count_triangles(tile.scene)
    if counts.sum() <= most_triangles:
        return tile
    low, high = scene_bounds(tile.scene)
    order = np.argsort(-np.prod(high - low, axis=1), kind="stable")
    num = max(1, int(np.searchsorted(np.cumsum(counts[order]), most_triangles, side="right")))
    rest = tile.take(np.sort(order[:num]))
    # Meshes of the others would add up from level to level.
    return replace(rest, scene=with_used_tables(rest.scene))


def _together(grid: TileGrid, cell: TileCell, branches: Sequence[Branch]) -> TileModels:
    """The models of branches, from the origin of the cell."""
    origin = grid.origin(cell)
    return joined_tiles([branch.models.moved(grid.origin(branch.node.cell) - origin) for branch in branches])
