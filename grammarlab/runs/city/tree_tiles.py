"""Trees of a city as tiles: instances of a few grown trees of each species."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from grammarlab.about import __version__
from grammarlab.arrays import Floats
from grammarlab.export.model_files import write_whole
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.explicit_tileset import json_bytes, tileset
from grammarlab.export.tiles.tile_file import write_tile
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.export.tiles.tile_tree import TileFile, TileNode, box_in_root, box_of
from grammarlab.files import file_below, folder_below
from grammarlab.runs.city.record_file import read_record, write_record
from grammarlab.runs.city.tree_places import TreePlaces, grown_cards
from grammarlab.scene.joined import of_models

FOLDER = "trees"
TILESET = "trees.json"
RECORD = "record.json"
_UP = 2
"""Levels of the tiles of trees above those of buildings: 512 m."""
_NO_TREES = 10.0
"""Geometric error in metres of what has no trees: they appear at some 600 m."""


@dataclass(frozen=True, kw_only=True)
class TreeRecord:
    """Written tiles of trees."""

    key: str
    sizes: dict[str, int]
    """Bytes of the files of tiles, by names below the folder of the city."""
    tileset: dict[str, Any]
    """The tileset as JSON."""


def write_trees(folder: Path, trees: Sequence[TreePlaces], grid: TileGrid, placement: EarthPlacement, seed: int) -> int:
    """Write the trees of a city as tiles, and their tileset; the number of tiles.

    Args:
        folder: folder of the city.
        trees: at least one tree.
        grid: the quadtree of the tiles of buildings.
        placement: the place of the city.
        seed: seed of the city.
    """
    key = _key(trees, grid, placement, seed)
    record = _earlier(folder, key)
    if record is None:
        clear_trees(folder)
        writer = _Writer(folder, grid, placement, seed)
        for cell in _cells(grid, np.concatenate([places.place for places in trees])):
            writer.add(cell, trees)
        record = writer.finish(key)
        write_record(folder, f"{FOLDER}/{RECORD}", record)
    # It is written anew each time: a tileset of trees and buildings changes it (`write_together`).
    write_whole(folder / TILESET, json_bytes(record.tileset))
    return len(record.sizes)


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
        digest.update(repr((places.rules.name, places.rules.hash)).encode("utf-8", "surrogatepass"))
        digest.update(places.place.tobytes() + places.grown.tobytes())
    return digest.hexdigest()


def _earlier(folder: Path, key: str) -> TreeRecord | None:
    """The trees that an earlier run has written, if they are the same and their files are there."""
    record = read_record(folder, f"{FOLDER}/{RECORD}", TreeRecord)
    if record is None or record.key != key:
        return None
    paths = {name: file_below(folder, name) for name in record.sizes}
    is_whole = all(path is not None and path.stat().st_size == record.sizes[name] for name, path in paths.items())
    return record if is_whole else None


class _Writer:
    """Tiles of the ground and of trees in the making."""

    def __init__(self, folder: Path, grid: TileGrid, placement: EarthPlacement, seed: int) -> None:
        self._folder, self._grid, self._placement, self._seed = folder, grid, placement, seed
        self._entries: list[dict[str, Any]] = []
        self._nodes: list[TileNode] = []
        self._sizes: dict[str, int] = {}

    def add(self, cell: TileCell, trees: Sequence[TreePlaces]) -> None:
        """Write the tiles of a cell, one for each species."""
        for number, models in self._trees(cell, trees):
            entry = self._entry(cell, models, number)
            volume = entry["boundingVolume"]
            self._entries.append({"boundingVolume": volume, "geometricError": _NO_TREES, "children": [entry]})

    def finish(self, key: str) -> TreeRecord:
        """The record of all written tiles."""
        whole = TileNode.above(TileCell(0, 0, 0), None, None, self._nodes)
        root = {
            "boundingVolume": {"box": box_of(whole)},
            "geometricError": 2 * _NO_TREES,
            "children": self._entries,
        }
        value = tileset(root, 4 * _NO_TREES, self._placement.root_transform())
        return TreeRecord(key=key, sizes=self._sizes, tileset=value)

    def _entry(self, cell: TileCell, models: TileModels, number: int) -> dict[str, Any]:
        uri = f"{FOLDER}/{cell.x}_{cell.y}_{number}.glb"
        (matrix,) = self._placement.tile_matrices(self._grid.origin(cell)[None])
        written = write_tile(self._folder / uri, models, "full", matrix)
        self._sizes[uri] = written.bytes
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
