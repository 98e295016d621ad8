"""GLB file of one tile."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from grammarlab.arrays import Floats
from grammarlab.export.tiles.tile_models import TileModels

Level = Literal["full", "plain", "block"]
"""Levels of detail: whole models; walls and roofs of at most 300 triangles; at most 30 triangles."""


@dataclass(frozen=True, slots=True)
class TileSummary:
    """What a file of a tile holds."""

    bytes: int
    triangles: int
    """With all instances."""
    draws: int
    """Primitives that a viewer draws one by one."""
    low: Floats
    """[3] smallest coordinates from the origin of the tile, in metres: x east, y up, z south."""
    high: Floats
    """[3] largest coordinates."""


def write_tile(
    path: Path, tile: TileModels, level: Level, root_matrix: Floats, assets: Path | None = None
) -> TileSummary:
    """Write the GLB of one tile.

    Args:
        path: the file.
        tile: the models, at the level of detail (`grammarlab.export.tiles.simplified`).
        level: ``full`` shares meshes between all models by instancing; the others are one mesh with colours.
        root_matrix: [4, 4] from the tile's axes (x east, y up, z south) to those of the tileset, also y up.
        assets: folder of the textures; None leaves them out.

    Raises:
        AssetError: If a texture is unusable.
        DerivationError: If a coordinate is not finite.
        UsageError: If the path cannot be written to.
    """
    raise NotImplementedError
