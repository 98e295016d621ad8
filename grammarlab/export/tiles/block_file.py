"""File of the blocks of a shard, from which the tiles above it are made."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np

from grammarlab.derivation.materials import CHANNELS, Materials
from grammarlab.export.model_files import write_whole
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene.instances import Scene


def polygon_scene(meshes: Meshes, model: np.ndarray, color: np.ndarray, num_models: int) -> Scene:
    """A scene of polygons.

    Args:
        meshes: N meshes of one face each.
        model: [N] model of each polygon, ascending.
        color: [N, 3] sRGB in 0..1.
        num_models: number of models.
    """
    different, material = np.unique(color, axis=0, return_inverse=True)
    channels = np.tile(list(CHANNELS.values()), (len(different), 1))
    channels[:, :3] = different
    num = len(meshes)
    return Scene(
        num_models=num_models,
        meshes=meshes,
        materials=Materials(channels, ("",) * len(different)),
        model=model.astype(np.int32),
        mesh=np.arange(num, dtype=np.int32),
        material=material.ravel().astype(np.int32),
        position=np.zeros((num, 3)),
        size=np.ones((num, 3)),
        frame=np.zeros(num, dtype=np.int32),
        frames=np.eye(3)[None],
        texture_map=np.full(num, -1, dtype=np.int32),
        texture_maps=np.zeros((0, 2, 4)),
        origins=np.zeros((num_models, 3)),
    )


def write_blocks(path: Path, tile: TileModels) -> None:
    """Write models that consist of polygons (`polygon_scene`)."""
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    scene = tile.scene
    meshes = scene.meshes.take(scene.mesh)
    properties = pa.BufferOutputStream()
    with pa.ipc.new_file(properties, tile.properties.schema) as writer:
        writer.write_table(tile.properties.combine_chunks())
    stream = BytesIO()
    np.savez(
        stream,
        points=meshes.points,
        counts=np.diff(meshes.face_offsets),
        model=scene.model,
        color=scene.materials.color[scene.material],
        offset=tile.offset,
        properties=np.frombuffer(properties.getvalue(), dtype=np.uint8),
    )
    write_whole(path, stream.getvalue())


def read_blocks(path: Path) -> TileModels:
    """Models from a file of `write_blocks`."""
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    with np.load(path, allow_pickle=False) as columns:
        meshes = Meshes.from_polygons(columns["points"], columns["counts"])
        offset = columns["offset"]
        scene = polygon_scene(meshes, columns["model"], columns["color"], len(offset))
        properties = pa.ipc.open_file(pa.py_buffer(columns["properties"].tobytes())).read_all()
    return TileModels(scene, offset, properties)
