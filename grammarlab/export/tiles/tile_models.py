"""Models of one tile, with their places in it and their properties."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.scene.instances import Scene

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True, slots=True, eq=False)
class TileModels:
    """B models of one tile; model b is feature b of the file."""

    scene: Scene
    """B models; its `origins` are not used."""
    offset: Floats
    """[B, 3] origin of each model in metres from the origin of the tile: x east, y up, z south."""
    properties: pa.Table
    """[B] columns of texts, numbers and flags without nulls: ``id``, ``zone``, ``seed`` and ``model`` as texts (numbers
    of 64 bits do not fit JavaScript), ``height``."""

    def __post_init__(self) -> None:
        if not self.scene.num_models == len(self.offset) == len(self.properties):
            raise UsageError(
                f"a tile: expected an offset and a row of properties for each of {self.scene.num_models} models, "
                f"found {len(self.offset)} and {len(self.properties)}"
            )

    def __len__(self) -> int:
        return len(self.offset)
