"""Trees of a city as tiles: instances of a few grown trees of each species."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from grammarlab.about import __version__
from grammarlab.arrays import Floats
from grammarlab.errors import AssetError
from grammarlab.export.model_files import write_whole
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.explicit_tileset import json_bytes, tileset
from grammarlab.export.tiles.tile_file import write_tile
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.export.tiles.tile_tree import TileFile, TileNode, box_in_root, box_of
from grammarlab.files import file_below, folder_below, read_bounded, write_text
from grammarlab.runs.city.tree_places import TreePlaces, grown_cards
from grammarlab.scene.joined import of_models

FOLDER = "trees"
TILESET = "trees.json"
RECORD = "record.json"
_MAX_BYTES = 1 << 16
_UP = 2
"""Levels of the tiles of trees above those of buildings: 512 m."""
_NO_TREES = 10.0
"""Geometric error in metres of what has no trees: they appear at some 600 m."""


@dataclass(frozen=True, slots=True)
class TreeTiles:
    """Written tiles of trees."""

    num_tiles: int
    num_trees: int
    low: Floats
    """[3] lowest corner, in the axes of the root of the tileset: x east, y north, z up, in metres."""
    high: Floats
    """[3] highest corner."""


def write_trees(
    folder: Path, trees: Sequence[TreePlaces], grid: TileGrid, placement: EarthPlacement, seed: int
) -> TreeTiles:
    """Write the trees of a city as tiles, and their tileset.

    Args:
        folder: folder of the city.
        trees: at least one tree.
        grid: the quadtree of the tiles of buildings.
        placement: the place of the city.
        seed: seed of the city.
    """
    key = _key(trees, grid, placement, seed)
    earlier = _earlier(folder, key)
    if earlier is not None:
        return earlier
    clear_trees(folder)
    writer = _Writer(folder, grid, placement, seed)
    for cell in _cells(grid, np.concatenate([places.place for places in trees])):
        writer.add(cell, trees)
    written = writer.finish()
    record = {"key": key, **asdict(written), "low": written.low.tolist(), "high": written.high.tolist()}
    write_text(folder / FOLDER / RECORD, json.dumps(record) + "\n")
    return written


def clear_trees(folder: Path) -> None:
    """Remove the trees of an earlier city."""
    home = folder_below(folder, FOLDER)
    if home is not None:
        shutil.rmtree(home)
    (folder / TILESET).unlink(missing_ok=True)


def _key(trees: Sequence[TreePlaces], grid: TileGrid, placement: EarthPlacement, seed: int) -> str:
    """SHA-256 of all that decides about the tiles."""
    digest = sha256(repr((__version__, grid, placement, seed)).encode())
    for places in trees:
        digest.update(places.rules.hash.encode() + places.place.tobytes() + places.grown.tobytes())
    return digest.hexdigest()


def _earlier(folder: Path, key: str) -> TreeTiles | None:
    """The trees that an earlier run has written, if they are the same."""
    path = file_below(folder, f"{FOLDER}/{RECORD}")
    try:
        values = json.loads(read_bounded(path, _MAX_BYTES)) if path else {}
        if values.pop("key", "") != key or not (folder / TILESET).is_file():
            return None
        low, high = (np.array(values.pop(name), np.float64) for name in ("low", "high"))
        return TreeTiles(**values, low=low, high=high)
    except (AssetError, OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None


class _Writer:
    """Tiles of the ground and of trees in the making."""

    def __init__(self, folder: Path, grid: TileGrid, placement: EarthPlacement, seed: int) -> None:
        self._folder, self._grid, self._placement, self._seed = folder, grid, placement, seed
        self._entries: list[dict[str, Any]] = []
        self._nodes: list[TileNode] = []
        self._num_trees = 0

    def add(self, cell: TileCell, trees: Sequence[TreePlaces]) -> None:
        """Write the tiles of a cell, one for each species."""
        for number, models in self._trees(cell, trees):
            self._num_trees += len(models)
            entry = self._entry(cell, models, number)
            volume = entry["boundingVolume"]
            self._entries.append({"boundingVolume": volume, "geometricError": _NO_TREES, "children": [entry]})

    def finish(self) -> TreeTiles:
        """Write the tileset."""
        whole = TileNode.above(TileCell(0, 0, 0), None, None, self._nodes)
        root = {
            "boundingVolume": {"box": box_of(whole)},
            "geometricError": 2 * _NO_TREES,
            "children": self._entries,
        }
        value = tileset(root, 4 * _NO_TREES, self._placement.root_transform())
        write_whole(self._folder / TILESET, json_bytes(value))
        return TreeTiles(len(self._nodes), self._num_trees, whole.low, whole.high)

    def _entry(self, cell: TileCell, models: TileModels, number: int) -> dict[str, Any]:
        uri = f"{FOLDER}/{cell.x}_{cell.y}_{number}.glb"
        (matrix,) = self._placement.tile_matrices(self._grid.origin(cell)[None])
        written = write_tile(self._folder / uri, models, "full", matrix)
        box = box_in_root(written.low, written.high, matrix)
        node = TileNode.above(cell, box, TileFile(written.bytes, written.draws))
        self._nodes.append(node)
        return {"boundingVolume": {"box": box_of(node)}, "geometricError": 0.0, "content": {"uri": uri}}

    def _trees(self, cell: TileCell, trees: Sequence[TreePlaces]) -> Iterator[tuple[int, TileModels]]:
        origin, half = self._grid.origin(cell), self._grid.size(cell.level) / 2
        for number, places in enumerate(trees):
            moved = places.place - origin
            here = np.flatnonzero(((moved[:, [0, 2]] >= -half) & (moved[:, [0, 2]] < half)).all(axis=1))
            if len(here):
                scene = of_models(grown_cards(places.rules, self._seed), places.grown[here])
                yield number, TileModels(scene, moved[here], _properties([places.rules.name] * len(here)))


def _cells(grid: TileGrid, places: Floats) -> list[TileCell]:
    """Cells with places [n, 3], in order."""
    cells = np.unique(grid.leaves(places) >> _UP, axis=0)
    return [TileCell(grid.leaf_level - _UP, *cell) for cell in cells.tolist()]


def _properties(names: Sequence[str]) -> pa.Table:
    return pa.table({"id": pa.array([""] * len(names)), "species": pa.array(list(names))})
