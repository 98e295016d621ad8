"""Files of branches: what a later build needs of a written part of the tree if nothing has changed in it.

A file is the SHA-256 of its rest, an archive of numpy compressed by zstd: a record of the tree as JSON, and the
columns of the models as polygons.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import GrammarlabError
from grammarlab.export.model_files import write_whole
from grammarlab.export.tiles.polygon_scene import polygon_scene
from grammarlab.export.tiles.tile_grid import TileCell
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.export.tiles.tile_tree import TileFile, TileNode
from grammarlab.files import read_bounded
from grammarlab.geometry.meshes.mesh import Meshes

_CODEC = "zstd"
_MAX_BYTES = 1 << 28
"""Largest size of the archive, a bound for damaged files: a thousand buildings have a megabyte."""
_DAMAGE = (GrammarlabError, OSError, EOFError, BadZipFile, LookupError, ValueError, TypeError, RecursionError)


@dataclass(frozen=True, slots=True)
class Branch:
    """A written part of the tree, and its models for the tiles above it."""

    node: TileNode
    models: TileModels
    """From the origin of the cell: the whole models of a leaf; above, the largest ones as polygons."""


def write_branch(path: Path, key: str, branch: Branch) -> None:
    """Write a branch whose models consist of polygons (`polygon_scene`).

    Args:
        path: the file.
        key: hash of all that the branch depends on.
        branch: the branch.
    """
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    tile = branch.models
    scene = tile.scene
    meshes = scene.meshes.take(scene.mesh)
    properties = pa.BufferOutputStream()
    with pa.ipc.new_file(properties, tile.properties.schema) as writer:
        writer.write_table(tile.properties.combine_chunks())
    archive = BytesIO()
    np.savez(
        archive,
        record=_bytes(json.dumps({"key": key, "tree": _record(branch.node)}).encode()),
        points=meshes.points,
        counts=np.diff(meshes.face_offsets),
        model=scene.model,
        color=scene.materials.color[scene.material],
        offset=tile.offset,
        properties=_bytes(properties.getvalue()),
    )
    content = pa.compress(archive.getvalue(), _CODEC, asbytes=True)
    write_whole(path, sha256(content).digest() + content)


def read_branch(path: Path, key: str) -> Branch | None:
    """The branch of a file of `write_branch`; None if it is missing, damaged, or has another key."""
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    try:
        columns = _columns(path)
        node = _tree(columns, key)
        if node is None:
            return None
        meshes = Meshes.from_polygons(columns["points"], columns["counts"])
        offset = columns["offset"]
        scene = polygon_scene(meshes, columns["model"], columns["color"], len(offset))
        properties = pa.ipc.open_file(pa.py_buffer(columns["properties"].tobytes())).read_all()
        return Branch(node, TileModels(scene, offset, properties))
    except _DAMAGE:
        return None


def read_tree(path: Path, key: str) -> TileNode | None:
    """The tree of a branch alone; None if the file is missing, damaged, or has another key."""
    try:
        return _tree(_columns(path), key)
    except _DAMAGE:
        return None


def _columns(path: Path) -> Mapping[str, NDArray[Any]]:
    """Columns of a file, each read when it is used."""
    import pyarrow as pa  # noqa: PLC0415  # takes long to import

    content = memoryview(read_bounded(path, _MAX_BYTES))
    digest, rest = content[:32], content[32:]
    if sha256(rest).digest() != digest:
        raise ValueError(f"{path}: damaged")
    with pa.CompressedInputStream(pa.BufferReader(rest), _CODEC) as stream:
        archive = stream.read(_MAX_BYTES)
    return np.load(BytesIO(archive), allow_pickle=False)


def _tree(columns: Mapping[str, NDArray[Any]], key: str) -> TileNode | None:
    record = json.loads(columns["record"].tobytes())
    return _node(record["tree"]) if record["key"] == key else None


def _record(node: TileNode) -> list[object]:
    file = None if node.file is None else [node.file.num_bytes, node.file.draws, node.file.textures]
    return [*node.cell, node.low.tolist(), node.high.tolist(), file, [_record(child) for child in node.children]]


def _node(record: list) -> TileNode:
    level, x, y, low, high, entry, children = record
    file = None if entry is None else TileFile(entry[0], entry[1], tuple(entry[2]))
    return TileNode(
        TileCell(level, x, y), np.array(low), np.array(high), file, tuple(_node(child) for child in children)
    )


def _bytes(content: bytes) -> NDArray[np.uint8]:
    return np.frombuffer(content, dtype=np.uint8)
