"""Implicit tilesets: a rule for the names of all tiles, and subtrees with a bit for each tile that exists.

The volumes of tiles are exact cells, and buildings stick out; so subtrees have the real boxes as metadata.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.export.model_files import write_whole
from grammarlab.export.tiles.explicit_tileset import json_bytes, tileset
from grammarlab.export.tiles.tile_grid import SUBTREE_LEVELS, TileCell, TileGrid, morton
from grammarlab.export.tiles.tile_tree import LEAF_ERROR, TileNode, box_of

_NUM_TILES = (4**SUBTREE_LEVELS - 1) // 3
_CLASS, _BOX = "tile", "box"
_SCHEMA = {
    "id": "tiles",
    "classes": {
        _CLASS: {
            "properties": {
                _BOX: {
                    "type": "SCALAR",
                    "componentType": "FLOAT64",
                    "array": True,
                    "count": 12,
                    "semantic": "TILE_BOUNDING_BOX",
                }
            }
        }
    },
}


def write_implicit(path: Path, grid: TileGrid, root: TileNode, transform: Floats | None) -> None:
    """Write the tileset of a city and its subtrees.

    Args:
        path: the file, in the folder of the city.
        grid: the quadtree.
        root: the tree, from level 0 to the leaves.
        transform: [4, 4] from the axes of the root to ECEF metres, if the place is known.
    """
    nodes = list(root.walk())
    for top in nodes:
        if top.cell.level % SUBTREE_LEVELS == 0:
            name = f"subtrees/{top.cell.level}/{top.cell.x}/{top.cell.y}.subtree"
            write_whole(path.parent / name, subtree(top))
    half = grid.size(0) / 2.0
    low, high = float(root.low[2]), float(root.high[2])
    tile = {
        "boundingVolume": {
            "box": [0.0, 0.0, (low + high) / 2.0, half, 0.0, 0.0, 0.0, half, 0.0, 0.0, 0.0, (high - low) / 2.0]
        },
        # It halves from level to level.
        "geometricError": LEAF_ERROR * 2**grid.leaf_level,
        "content": {"uri": "t/{level}/{x}/{y}.glb"},
        "implicitTiling": {
            "subdivisionScheme": "QUADTREE",
            "availableLevels": grid.num_levels,
            "subtreeLevels": SUBTREE_LEVELS,
            "subtrees": {"uri": "subtrees/{level}/{x}/{y}.subtree"},
        },
    }
    text = tileset(tile, 2.0 * LEAF_ERROR * 2**grid.leaf_level, transform, schema=_SCHEMA)
    write_whole(path, json_bytes(text))


def subtree(top: TileNode) -> bytes:
    """The file of a subtree of `SUBTREE_LEVELS` levels."""
    nodes, below = [], []
    for node in _walk(top, SUBTREE_LEVELS):
        (nodes if node.cell.level < top.cell.level + SUBTREE_LEVELS else below).append(node)
    bits = bit_indices([node.cell for node in nodes], top.cell)
    order = np.argsort(bits)
    has_content = np.array([node.has_content for node in nodes])
    writer = _Buffer()
    tiles = writer.availability(bits, _NUM_TILES)
    contents = writer.availability(bits[has_content], _NUM_TILES)
    first_below = (4**SUBTREE_LEVELS - 1) // 3
    children = bit_indices([node.cell for node in below], top.cell) - first_below
    child_subtrees = writer.availability(children, 4**SUBTREE_LEVELS)
    boxes = np.array([box_of(nodes[index]) for index in order.tolist()], dtype="<f8")
    table = {"class": _CLASS, "count": len(nodes), "properties": {_BOX: {"values": writer.add(boxes.tobytes())}}}
    head = {
        "buffers": [{"byteLength": len(writer.content)}],
        "bufferViews": writer.views,
        "tileAvailability": tiles,
        "contentAvailability": [contents],
        "childSubtreeAvailability": child_subtrees,
        "propertyTables": [table],
        "tileMetadata": 0,
    }
    text = json_bytes(head)
    text += b" " * (-len(text) % 8)
    return struct.pack("<4sIQQ", b"subt", 1, len(text), len(writer.content)) + text + bytes(writer.content)


def bit_indices(cells: Sequence[TileCell], top: TileCell) -> Ints:
    """[n] numbers of the bits of cells in the subtree of a cell: level by level, in Morton order."""
    if not cells:
        return np.zeros(0, dtype=np.int64)
    level, x, y = np.array(cells, dtype=np.int64).T
    depth = level - top.level
    local = np.column_stack((x - (top.x << depth), y - (top.y << depth)))
    return (4**depth - 1) // 3 + morton(local)


class _Buffer:
    """The binary part of a subtree."""

    def __init__(self) -> None:
        self.content = bytearray()
        self.views: list[dict[str, int]] = []

    def add(self, content: bytes) -> int:
        """Index of the buffer view of further bytes."""
        self.views.append({"buffer": 0, "byteOffset": len(self.content), "byteLength": len(content)})
        self.content += content + b"\0" * (-len(content) % 8)
        return len(self.views) - 1

    def availability(self, indices: Ints, num_bits: int) -> dict[str, Any]:
        """Availability of the tiles at these bits."""
        if len(indices) in (0, num_bits):
            return {"constant": int(len(indices) > 0)}
        flags: Flags = np.zeros(num_bits, dtype=bool)
        flags[indices] = True
        return {"bitstream": self.add(np.packbits(flags, bitorder="little").tobytes()), "availableCount": len(indices)}


def _walk(node: TileNode, levels: int) -> Sequence[TileNode]:
    """A tile and those at most so many levels below it."""
    nodes = [node]
    if levels:
        for child in node.children:
            nodes += _walk(child, levels - 1)
    return nodes
