"""GLB file of one tile."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.asset_roots import AssetRoot
from grammarlab.assets.texture_files import Texture, image_file
from grammarlab.errors import UsageError
from grammarlab.export.gltf_document import GltfDocument
from grammarlab.export.gltf_materials import GltfMaterials
from grammarlab.export.model_files import GENERATOR, whole_file, write_whole
from grammarlab.export.tiles.tile_instances import add_instances
from grammarlab.export.tiles.tile_mesh import add_mesh
from grammarlab.export.tiles.tile_metadata import add_properties
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.export.tiles.tile_part import TilePart
from grammarlab.scene.instance_bounds import scene_bounds
from grammarlab.scene.instances import Scene, chosen, require_finite, require_proper
from grammarlab.scene.triangles import triangles
from grammarlab.scene.used_tables import with_used_tables

Level = Literal["full", "plain", "block"]
"""Levels of detail: whole models; walls and roofs of at most 300 triangles; at most 30 triangles."""
_ORTHOGONAL = 1e-5
"""Largest cosine between the axes of a tile that counts as a right angle: .6 mm in a tile of 128 m."""
_ROUNDING = 1e-3
"""Metres around a box for the rounding of 32-bit coordinates."""


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
    textures: tuple[str, ...]
    """Names of the textures in the folder of those that tiles share, ascending."""


def write_tile(
    path: Path,
    tile: TileModels,
    level: Level,
    root_matrix: Floats,
    assets: AssetRoot | None = None,
    textures: Path | None = None,
) -> TileSummary:
    """Write the GLB of one tile.

    Args:
        path: the file.
        tile: the models at the level of detail, at least one (`grammarlab.export.tiles.simplified_models`).
        level: ``full`` shares meshes between all models by instancing; the others are one mesh with colours.
        root_matrix: [4, 4] from the tile's axes (x east, y up, z south) to those of the tileset, also y up.
        assets: folder of the textures; None leaves out those that no material contains.
        textures: folder for the textures that several tiles share; by default they are embedded.

    Raises:
        AssetError: If a texture is unusable.
        DerivationError: If a coordinate is not finite.
        UsageError: If the path cannot be written to, or there are no models.
    """
    if not len(tile):
        raise UsageError("a tile: expected at least one model, found none")
    require_finite(tile.scene)
    require_proper(tile.scene)
    tile = replace(tile, scene=_prepared(tile.scene, assets))
    low, high = tile_bounds(tile)
    # Coordinates count from the middle of the models: terrain may be high, and 32 bits are few. Viewers that look at
    # shared meshes without their instances find them inside the box as well.
    middle = np.round((low + high) / 2.0)
    moved = tile.moved(-middle)
    matrix = root_matrix.copy()
    matrix[:3, 3] += root_matrix[:3, :3] @ middle
    with whole_file(path) as output:
        document = GltfDocument(output)
        add_properties(document, tile.properties)
        share = None if textures is None else _TextureStore(textures, path.parent)
        materials = GltfMaterials(document, assets, share)
        parts, rest = [], tile.scene
        if level == "full":
            part, is_left = add_instances(document, materials, moved)
            parts, rest = [part], chosen(tile.scene, is_left)
        parts.append(add_mesh(document, materials, triangles(rest), moved.offset))
        total = TilePart.total(parts)
        document.pack(_placed(document, total.nodes, matrix), GENERATOR)
        num_bytes = output.stream.tell()
    return TileSummary(
        bytes=num_bytes,
        triangles=total.triangles,
        draws=total.draws,
        low=low,
        high=high,
        textures=tuple(sorted(share.names)) if share else (),
    )


def _prepared(scene: Scene, assets: AssetRoot | None) -> Scene:
    """A scene with the materials that it uses, without names of missing textures."""
    scene = with_used_tables(scene)
    table = scene.materials
    textures = tuple(
        name if name in table.pictures or (name and assets and image_file(name, assets)) else ""
        for name in table.textures
    )
    return replace(scene, materials=replace(table, textures=textures))


class _TextureStore:
    """A folder of textures by their content, which tiles refer to.

    Args:
        folder: the folder.
        base: folder of the tile.
    """

    def __init__(self, folder: Path, base: Path) -> None:
        self._folder, self._base = folder, base
        self.names: set[str] = set()
        """Names of the textures that the tile refers to."""

    def __call__(self, texture: Texture) -> str:
        """URI of a stored texture, relative to the tile."""
        path = self._folder / f"{sha256(texture.content).hexdigest()[:32]}{texture.suffix}"
        self.names.add(path.name)
        if not path.exists():
            write_whole(path, texture.content)
        return Path(os.path.relpath(path, self._base)).as_posix()


def tile_bounds(tile: TileModels) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates [3] of a tile from its origin, in metres."""
    low, high = scene_bounds(tile.scene)
    return (low + tile.offset).min(axis=0) - _ROUNDING, (high + tile.offset).max(axis=0) + _ROUNDING


def _placed(document: GltfDocument, nodes: Sequence[int], matrix: Floats) -> list[int]:
    """Root nodes of these nodes under a matrix: one; or two where a projection does not keep right angles."""
    # Imported here, since it takes long.
    from scipy.spatial.transform import Rotation  # noqa: PLC0415

    if not nodes:
        return []
    axes = matrix[:3, :3]
    scale = np.linalg.norm(axes, axis=0)
    turned = axes / scale
    if np.abs(turned.T @ turned - np.eye(3)).max() > _ORTHOGONAL:
        # Any matrix is a rotation, a scale along the axes, and another rotation.
        outer, scale, inner = np.linalg.svd(axes)
        sign = np.sign(np.linalg.det(outer))
        nodes = [_add_turned(document, nodes, Rotation.from_matrix(inner * sign))]
        turned = outer * sign
    properties = {"translation": matrix[:3, 3].tolist(), "scale": scale.tolist()}
    return [_add_turned(document, nodes, Rotation.from_matrix(turned), **properties)]


def _add_turned(document: GltfDocument, children: Sequence[int], rotation: Any, **properties: list[float]) -> int:
    quaternion = (rotation.as_quat(canonical=True) + 0.0).tolist()
    return document.add("nodes", {**properties, "rotation": quaternion, "children": list(children)})
