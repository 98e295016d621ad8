"""Tiles of a quadtree with their boxes: what explicit and implicit tilesets are written from."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.export.tiles.earth_placement import UPWARDS
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid

LEAF_ERROR = 2.0
"""Geometric error of leaves in metres: a viewer of 1080 pixels refines their parents at 234 m."""
_DECIMALS = 3
"""Of boxes in metres, rounded outwards."""


@dataclass(frozen=True, slots=True)
class TileFile:
    """The written file of a tile."""

    num_bytes: int
    draws: int
    """Primitives that a viewer draws one by one."""
    textures: tuple[str, ...] = ()
    """Names of the textures that it shares with other tiles, ascending."""


@dataclass(frozen=True, slots=True, eq=False)
class TileNode:
    """A tile and those below it."""

    cell: TileCell
    low: Floats
    """[3] lowest corner of all content here and below, in the axes of the root: x east, y north, z up, in metres."""
    high: Floats
    """[3] highest corner."""
    file: TileFile | None
    """None for cells of blocks with a single child below them."""
    children: tuple[TileNode, ...] = ()
    """In Morton order."""

    @classmethod
    def above(
        cls,
        cell: TileCell,
        box: tuple[Floats, Floats] | None,
        file: TileFile | None,
        children: Sequence[TileNode] = (),
    ) -> TileNode:
        """A tile whose volume contains its own content in a box, if it has content, and its children."""
        corners = [child.low for child in children] + [child.high for child in children] + [*(box or ())]
        step = 10.0**_DECIMALS
        low, high = np.floor(np.min(corners, axis=0) * step), np.ceil(np.max(corners, axis=0) * step)
        return cls(cell, low / step, high / step, file, tuple(children))

    @property
    def has_content(self) -> bool:
        """Whether there is a file."""
        return self.file is not None

    def files(self) -> Iterable[TileFile]:
        """The files of this tile and of all below it."""
        return (node.file for node in self.walk() if node.file is not None)

    def walk(self) -> Iterable[TileNode]:
        """This tile and all below it."""
        yield self
        for child in self.children:
            yield from child.walk()

    def shown(self) -> TileNode:
        """This tile, or the first below it that has content or several children."""
        return self if self.has_content or len(self.children) != 1 else self.children[0].shown()

    def error(self, grid: TileGrid) -> float:
        """Geometric error of its content in metres: 0 for leaves, so that viewers do not look for children."""
        if self.cell.level == grid.leaf_level:
            return 0.0
        if self.cell.level == grid.leaf_level - 1:
            return 2.0 * LEAF_ERROR
        return 2.0 * max(child.shown().error(grid) for child in self.children)


def box_in_root(low: Floats, high: Floats, matrix: Floats) -> tuple[Floats, Floats]:
    """Corners [3] of the box, in the axes of the root, of a box in a tile.

    Args:
        low: [3] lowest corner in the tile, x east, y up, z south.
        high: [3] highest corner.
        matrix: [4, 4] of the tile (`EarthPlacement.tile_matrices`).
    """
    turned = UPWARDS @ matrix
    middle = turned[:3, :3] @ ((low + high) / 2.0) + turned[:3, 3]
    reach = np.abs(turned[:3, :3]) @ ((high - low) / 2.0)
    return middle - reach, middle + reach


def content_name(cell: TileCell) -> str:
    """Path of the file of a tile below the folder of the city."""
    return f"t/{cell.level}/{cell.x}/{cell.y}.glb"


def content_path(folder: Path, cell: TileCell) -> Path:
    """Path of the file of a tile."""
    return folder / content_name(cell)


def box_of(node: TileNode) -> list[float]:
    """Bounding volume of 3D Tiles: a middle and three half axes, x east, y north, z up."""
    middle, half = (node.low + node.high) / 2.0, (node.high - node.low) / 2.0
    return [*middle.tolist(), half[0], 0.0, 0.0, 0.0, half[1], 0.0, 0.0, 0.0, half[2]]
