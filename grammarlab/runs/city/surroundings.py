"""What is around the buildings of a city, as tiles: the ground, and trees as instances of a few grown ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import shapely

from grammarlab.arrays import Floats
from grammarlab.export.model_files import write_whole
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.explicit_tileset import json_bytes, tileset
from grammarlab.export.tiles.tile_file import write_tile
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.export.tiles.tile_tree import TileNode, box_in_root, box_of
from grammarlab.runs.city.ground import ground_pieces, ground_scene, kinds_of_parcels, square
from grammarlab.runs.city.survey import Survey
from grammarlab.runs.city.tree_places import TreePlaces, grown_cards, tree_places
from grammarlab.runs.city.zone_rules import ZoneRules
from grammarlab.scene.joined import of_models

FOLDER = "surroundings"
TILESET = "surroundings.json"
_UP = 2
"""Levels of the tiles of the ground above those of buildings: 512 m."""
_TREES_ERROR = 10.0
"""Geometric error in metres of what has no trees: they appear at some 600 m."""
_GROUND_ERROR = 4096.0
"""The same of what has no ground, which is seen from everywhere."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The written tiles."""

    num_tiles: int
    num_trees: int
    low: Floats
    """[3] lowest corner, in the axes of the root of the tileset: x east, y north, z up, in metres."""
    high: Floats
    """[3] highest corner."""


def write_surroundings(
    folder: Path,
    survey: Survey,
    zones: tuple[ZoneRules, ...],
    street_trees: ZoneRules | None,
    grid: TileGrid,
    placement: EarthPlacement,
) -> Surroundings:
    """Write the ground and the trees of a city as tiles, and their tileset.

    Args:
        folder: folder of the city.
        survey: the survey.
        zones: rules of the zones; those of species are parks.
        street_trees: the species along the streets.
        grid: the quadtree of the tiles of buildings.
        placement: the place of the city.
    """
    writer = _Writer(folder, grid, placement, survey.plan.seed)
    outlines, points = survey.parcels.outline, shapely.get_coordinates(shapely.point_on_surface(survey.parcels.outline))
    kinds = kinds_of_parcels(survey, [rules.is_species for rules in zones])
    tree = shapely.STRtree(outlines)
    trees = tree_places(survey, zones, street_trees)
    cells = _cells(grid, np.concatenate([points * (1.0, -1.0), *(places.place[:, [0, 2]] for places in trees)]))
    for cell in cells:
        east, _, south = grid.origin(cell)
        whole = square(east, -south, grid.size(cell.level))
        near = np.sort(tree.query(shapely.buffer(whole, 50.0)))
        pieces = ground_pieces(outlines[near], kinds[near], whole)
        ground = ground_scene(pieces, grid.origin(cell), survey.heights) if len(pieces.outline) else None
        writer.add(
            cell, None if ground is None else TileModels(ground, np.zeros((1, 3)), _properties(["ground"])), trees
        )
    return writer.finish()


class _Writer:
    """Tiles of the ground and of trees in the making."""

    def __init__(self, folder: Path, grid: TileGrid, placement: EarthPlacement, seed: int) -> None:
        self._folder, self._grid, self._placement, self._seed = folder, grid, placement, seed
        self._entries: list[dict[str, Any]] = []
        self._nodes: list[TileNode] = []
        self._num_trees = 0

    def add(self, cell: TileCell, ground: TileModels | None, trees: Sequence[TreePlaces]) -> None:
        """Write the tiles of a cell."""
        if ground is not None:
            self._entries.append(self._entry(cell, ground, "ground"))
        for number, models in self._trees(cell, trees):
            self._num_trees += len(models)
            entry = self._entry(cell, models, f"trees{number}")
            self._entries.append(
                {"boundingVolume": entry["boundingVolume"], "geometricError": _TREES_ERROR, "children": [entry]}
            )

    def finish(self) -> Surroundings:
        """Write the tileset."""
        whole = TileNode.above(TileCell(0, 0, 0), None, self._nodes)
        root = {
            "boundingVolume": {"box": box_of(whole)},
            "geometricError": _GROUND_ERROR,
            "children": self._entries,
        }
        value = tileset(root, 2 * _GROUND_ERROR, self._placement.root_transform())
        write_whole(self._folder / TILESET, json_bytes(value))
        return Surroundings(len(self._nodes), self._num_trees, whole.low, whole.high)

    def _entry(self, cell: TileCell, models: TileModels, name: str) -> dict[str, Any]:
        uri = f"{FOLDER}/{cell.x}_{cell.y}_{name}.glb"
        (matrix,) = self._placement.tile_matrices(self._grid.origin(cell)[None])
        written = write_tile(self._folder / uri, models, "full", matrix)
        node = TileNode.above(cell, box_in_root(written.low, written.high, matrix))
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


def _cells(grid: TileGrid, ground: Floats) -> list[TileCell]:
    """Cells with points [n, 2] of the frame, x and z, in order."""
    places = np.column_stack([ground[:, 0], np.zeros(len(ground)), ground[:, 1]])
    cells = np.unique(grid.leaves(places) >> _UP, axis=0)
    return [TileCell(grid.leaf_level - _UP, *cell) for cell in cells.tolist()]


def _properties(names: Sequence[str]) -> pa.Table:
    return pa.table({"id": pa.array([""] * len(names)), "kind": pa.array(list(names))})
