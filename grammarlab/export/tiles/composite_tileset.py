"""Tileset that shows several other ones together."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from grammarlab.export.model_files import write_whole
from grammarlab.export.tiles.explicit_tileset import json_bytes, tileset


def write_together(path: Path, names: Sequence[str]) -> None:
    """Write a tileset that shows other ones, all of which have the same transform and boxes along its axes.

    Args:
        path: the file.
        names: names of explicit tilesets in its folder, one or more.
    """
    parts = [json.loads((path.parent / name).read_bytes()) for name in names]
    boxes = np.array([part["root"]["boundingVolume"]["box"] for part in parts])
    middle, half = boxes[:, :3], boxes[:, [3, 7, 11]]
    low, high = (middle - half).min(axis=0), (middle + half).max(axis=0)
    centre, reach = ((low + high) / 2).tolist(), ((high - low) / 2).tolist()
    error = max(part["geometricError"] for part in parts)
    transform = parts[0]["root"].get("transform")
    root = {
        "boundingVolume": {"box": [*centre, reach[0], 0.0, 0.0, 0.0, reach[1], 0.0, 0.0, 0.0, reach[2]]},
        "geometricError": error,
        "children": [_child(name, part) for name, part in zip(names, parts, strict=True)],
    }
    matrix = None if transform is None else np.array(transform).reshape(4, 4).T
    for name, part in zip(names, parts, strict=True):
        # The transform of the root applies to what it refers to.
        part["root"].pop("transform", None)
        write_whole(path.parent / name, json_bytes(part))
    write_whole(path, json_bytes(tileset(root, 2 * error, matrix)))


def _child(name: str, part: dict) -> dict:
    root = part["root"]
    return {
        "boundingVolume": root["boundingVolume"],
        "geometricError": root["geometricError"],
        "content": {"uri": name},
    }
