"""Checks of the sizes that a glTF file declares, before it is read.

A few hundred bytes can require terabytes: accessors without data mean zeros, and many nodes may draw one mesh.
"""

from __future__ import annotations

import json
import struct
from collections import Counter
from typing import Any

from grammarlab.errors import AssetError

_GLB_MAGIC, _JSON_CHUNK = b"glTF", 0x4E4F534A
_UNREADABLE = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}


def check_gltf(content: bytes, name: str, most_values: int) -> None:
    """Refuse a glTF or GLB file that declares too much data.

    Args:
        content: the whole file.
        name: name of the file, for messages.
        most_values: most vertices and most indices of the whole scene, and most rows of all accessors.

    Raises:
        AssetError: If the file is broken, too large when expanded, compressed, or its nodes are not a tree.
    """
    try:
        document = json.loads(_json_part(content))
        largest = _unfolded(document)
        compressed = sorted(_UNREADABLE.intersection(document.get("extensionsRequired", [])))
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError, struct.error) as error:
        raise AssetError(f'the asset "{name}" is not a valid glTF file: {error or type(error).__name__}') from error
    if compressed:
        raise AssetError(f'the asset "{name}" needs {compressed[0]}; save it without compression')
    if largest > most_values:
        raise AssetError(f'the asset "{name}" expands to {largest} values, more than the {most_values} that are read')


def _json_part(content: bytes) -> bytes:
    """The JSON of a glTF or GLB file."""
    if content[:4] != _GLB_MAGIC:
        return content
    length, kind = struct.unpack_from("<II", content, 12)
    if kind != _JSON_CHUNK:
        raise ValueError("its first chunk is not JSON")
    return content[20 : 20 + length]


def _unfolded(document: dict[str, Any]) -> int:
    """The largest of: rows of all accessors, vertices of all nodes, indices of all nodes."""
    counts = [_count(accessor["count"]) for accessor in document.get("accessors", [])]
    nodes = document.get("nodes", [])
    parents = Counter(child for node in nodes for child in node.get("children", []))
    if parents and max(parents.values()) > 1:
        raise ValueError("a node has two parents")
    _require_tree(nodes)
    vertices, indices = 0, 0
    for node in nodes:
        if "mesh" in node:
            for primitive in document["meshes"][node["mesh"]]["primitives"]:
                vertices += counts[primitive["attributes"]["POSITION"]]
                indices += counts[primitive["indices"]] if "indices" in primitive else 0
    return max(sum(counts), vertices, indices)


def _count(value: object) -> int:
    if not isinstance(value, int) or value < 0:
        raise ValueError(f"an accessor counts {value!r} rows")
    return value


def _require_tree(nodes: list[dict[str, Any]]) -> None:
    """Refuse cycles: if every node has at most one parent, the nodes of a cycle are those that no root reaches."""
    children = [node.get("children", []) for node in nodes]
    with_parent = {child for group in children for child in group}
    reached = [index for index in range(len(nodes)) if index not in with_parent]
    for index in reached:
        reached.extend(children[index])
    if len(reached) != len(nodes):
        raise ValueError("its nodes form a cycle")
