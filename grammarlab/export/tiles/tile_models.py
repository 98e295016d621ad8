"""Models of one tile, with their places in it and their properties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.errors import UsageError
from grammarlab.scene.instances import Scene
from grammarlab.scene.joined import joined, of_models

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
    """[B] columns of texts, numbers and flags: ``id``, ``zone``, ``seed``, ``model``, ``height``."""

    def __post_init__(self) -> None:
        if not self.scene.num_models == len(self.offset) == len(self.properties):
            raise UsageError(
                f"a tile: expected an offset and a row of properties for each of {self.scene.num_models} models, "
                f"found {len(self.offset)} and {len(self.properties)}"
            )

    def __len__(self) -> int:
        return len(self.offset)

    def take(self, models: Ints) -> TileModels:
        """These models [K], ascending."""
        return TileModels(of_models(self.scene, models), self.offset[models], self.properties.take(models))

    def moved(self, offset: Floats) -> TileModels:
        """The same models, [3] metres farther from the origin of the tile."""
        return replace(self, offset=self.offset + offset)


def joined_tiles(parts: Sequence[TileModels]) -> TileModels:
    """The models of several tiles with one origin, in order; at least one part.

    Columns of properties that a part lacks are null there.

    Raises:
        UsageError: If a column of properties has different types, or a part has normals of its own.
    """
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    if len(parts) == 1:
        return parts[0]
    try:
        properties = pa.concat_tables([part.properties for part in parts], promote_options="default")
    except (pa.ArrowInvalid, pa.ArrowTypeError) as error:
        raise UsageError(f"a tile: expected properties of equal types, found {error}") from error
    scene = joined([part.scene for part in parts])
    return TileModels(scene, np.concatenate([part.offset for part in parts]), properties)
