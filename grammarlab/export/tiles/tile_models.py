"""Models of one tile, with their places in it and their properties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.derivation.materials import Materials
from grammarlab.errors import UsageError
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.instances import PointSurface, Scene, chosen

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
        number = np.full(len(self), -1, dtype=np.int32)
        number[models] = np.arange(len(models), dtype=np.int32)
        scene = chosen(self.scene, number[self.scene.model] >= 0)
        scene = replace(scene, num_models=len(models), model=number[scene.model], origins=scene.origins[models])
        return TileModels(scene, self.offset[models], self.properties.take(models))

    def moved(self, offset: Floats) -> TileModels:
        """The same models, [3] metres farther from the origin of the tile."""
        return replace(self, offset=self.offset + offset)


def joined(parts: Sequence[TileModels]) -> TileModels:
    """The models of several tiles with one origin, in order; at least one part.

    Columns of properties that a part lacks are null there.

    Raises:
        UsageError: If a column of properties has different types, or only some parts have a surface.
    """
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    if len(parts) == 1:
        return parts[0]
    try:
        properties = pa.concat_tables([part.properties for part in parts], promote_options="default")
    except (pa.ArrowInvalid, pa.ArrowTypeError) as error:
        raise UsageError(f"a tile: expected properties of equal types, found {error}") from error
    scene = joined_scenes([part.scene for part in parts])
    return TileModels(scene, np.concatenate([part.offset for part in parts]), properties)


def joined_scenes(scenes: Sequence[Scene]) -> Scene:
    """All models of several scenes, in order; at least one scene.

    Raises:
        UsageError: If only some scenes have a surface.
    """
    if len({scene.surface is None for scene in scenes}) > 1:
        raise UsageError("scenes: expected a surface for all of them or for none")
    surfaces = [scene.surface for scene in scenes if scene.surface is not None]
    return Scene(
        num_models=sum(scene.num_models for scene in scenes),
        meshes=Meshes.concatenate([scene.meshes for scene in scenes]),
        materials=_joined_materials([scene.materials for scene in scenes]),
        model=_shifted([scene.model for scene in scenes], [scene.num_models for scene in scenes]),
        mesh=_shifted([scene.mesh for scene in scenes], [len(scene.meshes) for scene in scenes]),
        material=_shifted([scene.material for scene in scenes], [len(scene.materials) for scene in scenes]),
        position=np.concatenate([scene.position for scene in scenes]),
        size=np.concatenate([scene.size for scene in scenes]),
        frame=_shifted([scene.frame for scene in scenes], [len(scene.frames) for scene in scenes]),
        frames=np.concatenate([scene.frames for scene in scenes]),
        texture_map=_shifted([scene.texture_map for scene in scenes], [len(scene.texture_maps) for scene in scenes]),
        texture_maps=np.concatenate([scene.texture_maps.reshape(-1, 2, 4) for scene in scenes]),
        origins=np.concatenate([scene.origins for scene in scenes]),
        surface=PointSurface(
            np.concatenate([surface.normals for surface in surfaces]),
            np.concatenate([surface.coordinates for surface in surfaces]),
        )
        if surfaces
        else None,
    )


def _joined_materials(tables: Sequence[Materials]) -> Materials:
    starts = np.cumsum([0, *map(len, tables)]).tolist()
    return Materials(
        np.concatenate([table.channels for table in tables]),
        tuple(texture for table in tables for texture in table.textures),
        {name: content for table in tables for name, content in table.pictures.items()},
        frozenset().union(*(table.cut_out for table in tables)),
        frozenset(start + row for start, table in zip(starts, tables, strict=False) for row in table.thin),
    )


def _shifted(columns: Sequence[NDArray[np.int32]], counts: Sequence[int]) -> NDArray[np.int32]:
    """Indices into several tables of these lengths as indices into the joined table; -1 stays."""
    starts = np.cumsum([0, *counts]).tolist()
    parts = [np.where(column < 0, -1, column + start) for column, start in zip(columns, starts, strict=False)]
    return np.concatenate(parts).astype(np.int32)
