"""A small quarter of houses for tests, and its files read back."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from grammarlab.export.tiles.earth_placement import UPWARDS, EarthPlacement
from grammarlab.export.tiles.tile_branch import TileWriter
from grammarlab.export.tiles.tile_grid import TileCell, TileGrid, morton
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.export.tiles.tile_shard import shard_keys, write_quad, write_shard
from grammarlab.export.tiles.tile_tree import TileNode
from grammarlab.scene.instances import Scene
from tests.export.gltf import Glb, node_matrices
from tests.scene.buildings import house, scene_of

KEY = "a key"
WIDTHS = (10.0, 7.5, 15.0, 12.5)


def houses(numbers: list[int]) -> Scene:
    """Houses of different widths and floors, each by its number."""
    return scene_of([house(WIDTHS[number % 4], 1 + number % 5) for number in numbers])


def properties(numbers: list[int]) -> pa.Table:
    return pa.table(
        {
            "id": [f"parcel {number} ü" for number in numbers],
            "model": [str(2**64 - 1 - number) for number in numbers],
            "height": [3.0 * (1 + number % 5) for number in numbers],
        }
    )


def tile_of(numbers: list[int]) -> TileModels:
    offset = np.array([[20.0 * (number % 5) - 50.0, 1.0, 25.0 * (number // 5) - 60.0] for number in numbers])
    return TileModels(houses(numbers), offset, properties(numbers))


@dataclass(frozen=True)
class Quarter:
    """Houses at random places of several shards, in the frame."""

    places: np.ndarray

    @property
    def grid(self) -> TileGrid:
        return TileGrid.around(self.places)

    @property
    def shards(self) -> list[TileCell]:
        grid = self.grid
        cells = np.unique(grid.shards(grid.leaves(self.places)), axis=0).tolist()
        return [TileCell(grid.shard_level, x, y) for x, y in cells]

    def leaves(self, shard: TileCell) -> Iterator[tuple[TileCell, TileModels]]:
        grid = self.grid
        leaf = grid.leaves(self.places)
        inside = np.flatnonzero((grid.shards(leaf) == (shard.x, shard.y)).all(axis=1))
        for code in np.unique(morton(leaf[inside])):
            rows = inside[morton(leaf[inside]) == code]
            cell = TileCell(grid.leaf_level, *leaf[rows[0]].tolist())
            numbers = rows.tolist()
            yield cell, TileModels(houses(numbers), self.places[rows] - grid.origin(cell), properties(numbers))

    def write(self, folder: Path, placement: EarthPlacement) -> list[TileNode]:
        """Write all shards."""
        return [self.write_shard(TileWriter(folder, self.grid, placement, shard), shard) for shard in self.shards]

    def write_shard(self, writer: TileWriter, shard: TileCell) -> TileNode:
        for quad, leaves in groupby(self.leaves(shard), lambda leaf: leaf[0].parent):
            write_quad(writer, quad, KEY, list(leaves))
        return write_shard(writer, shard, self.quads(shard))

    def quads(self, shard: TileCell) -> dict[TileCell, str]:
        """Keys of the quads of a shard."""
        return {cell.parent: KEY for cell, _ in self.leaves(shard)}

    def keys(self) -> dict[TileCell, str]:
        """Keys of the shards."""
        return {shard: shard_keys(self.grid, shard, self.quads(shard))[shard] for shard in self.shards}


def quarter(num: int = 40, extent: float = 700.0) -> Quarter:
    places = np.random.default_rng(1).uniform(-extent, extent, (num, 3)).round()
    places[:, 1] = np.abs(places[:, 1]) / 100
    return Quarter(places)


@dataclass(frozen=True)
class ExplicitTile:
    """A tile of a tileset with its volume and those above it."""

    tile: dict[str, Any]
    content: Path
    boxes: tuple[np.ndarray, ...]
    """[2, 3] corners in the axes of the root, its own last."""
    errors: tuple[float, ...]
    """Errors from that of the tileset down to its own."""


def explicit_tiles(path: Path) -> Iterator[ExplicitTile]:
    """All tiles with files of models, through tilesets that refer to others."""
    document = json.loads(path.read_bytes())
    assert document["asset"]["version"] == "1.1"
    assert document["root"]["refine"] == "REPLACE"
    yield from _below(document["root"], path, (), (document["geometricError"],))


def _below(
    tile: dict[str, Any], path: Path, boxes: tuple[np.ndarray, ...], errors: tuple[float, ...]
) -> Iterator[ExplicitTile]:
    numbers = np.array(tile["boundingVolume"]["box"])
    reach = numbers[[3, 7, 11]]
    assert np.count_nonzero(numbers[3:]) == 3
    boxes = (*boxes, np.array([numbers[:3] - reach, numbers[:3] + reach]))
    content = (path.parent / tile["content"]["uri"]).resolve()
    if content.suffix == ".json":
        assert "children" not in tile
        inner = json.loads(content.read_bytes())
        yield from _below(inner["root"], content, boxes, (*errors, tile["geometricError"], inner["geometricError"]))
        return
    yield ExplicitTile(tile, content, boxes, (*errors, tile["geometricError"]))
    for child in tile.get("children", []):
        yield from _below(child, path, boxes, (*errors, tile["geometricError"]))


@dataclass(frozen=True)
class Drawn:
    """T triangles of a tile in the axes of the root, x east, y up, z south, with their features."""

    corners: np.ndarray
    """[T, 3, 3]."""
    feature: np.ndarray
    """[T]."""
    color: np.ndarray
    """[T, 3] linear."""
    draws: int
    coordinates: np.ndarray
    """[T, 3, 2] of textures; NaN where there are none."""


def drawn(glb: Glb) -> Drawn:
    """Everything that a viewer draws, with instances."""
    document = glb.document
    corners, feature, color, coordinates = [], [], [], []

    def visit(index: int, parent: np.ndarray) -> None:
        node = document["nodes"][index]
        matrices = parent @ node_matrices(glb, replace_features(node))
        for primitive in document["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            attributes = primitive["attributes"]
            rows = glb.values(primitive["indices"]).ravel()
            points = glb.values(attributes["POSITION"]).astype(float)[rows]
            base = np.array(glb.material(primitive)["pbrMetallicRoughness"]["baseColorFactor"][:3])
            tint = np.ones((len(rows), 3))
            if "COLOR_0" in attributes:
                tint = glb.values(attributes["COLOR_0"])[rows][:, :3] / 65535
            picture = np.full((len(rows), 2), np.nan)
            if "TEXCOORD_0" in attributes:
                picture = glb.values(attributes["TEXCOORD_0"]).astype(float)[rows]
            instances = node.get("extensions", {}).get("EXT_instance_features")
            if instances is not None:
                column = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["_FEATURE_ID_0"]
                of_instance = glb.values(column).ravel()
                ids = np.repeat(of_instance, len(rows) // 3)
                assert len(np.unique(of_instance)) == instances["featureIds"][0]["featureCount"]
            else:
                (entry,) = primitive["extensions"]["EXT_mesh_features"]["featureIds"]
                values = glb.values(attributes["_FEATURE_ID_0"]).ravel()
                assert len(np.unique(values)) == entry["featureCount"]
                ids = values[rows].reshape(-1, 3)[:, 0]
            for place in matrices:
                corners.append((points @ place[:3, :3].T + place[:3, 3]).reshape(-1, 3, 3))
                color.append((base * tint).reshape(-1, 3, 3)[:, 0])
                coordinates.append(picture.reshape(-1, 3, 2))
            feature.append(ids)
        for child in node.get("children", []):
            visit(child, matrices[0])

    for root in document["scenes"][0].get("nodes", []):
        visit(root, np.eye(4))
    draws = sum(
        len(document["meshes"][node["mesh"]]["primitives"]) for node in document.get("nodes", []) if "mesh" in node
    )
    columns = (np.concatenate(parts) for parts in (corners, feature, color, coordinates))
    surface, features, colors, pictures = columns
    return Drawn(surface, features.astype(int), colors, draws, pictures)


def replace_features(node: dict[str, Any]) -> dict[str, Any]:
    """A node whose instances have places only, as the reader of nodes expects."""
    extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
    if extension is None:
        return node
    places = {key: value for key, value in extension["attributes"].items() if not key.startswith("_")}
    return {**node, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": places}}}


def texts(glb: Glb, name: str) -> list[str]:
    """A column of texts of the table of properties."""
    (table,) = glb.document["extensions"]["EXT_structural_metadata"]["propertyTables"]
    views = [glb.document["bufferViews"][table["properties"][name][key]] for key in ("values", "stringOffsets")]
    assert all(view["byteOffset"] % 8 == 0 for view in views)
    content, offsets = (glb.buffer[view["byteOffset"] :][: view["byteLength"]] for view in views)
    ends = np.frombuffer(offsets, "<u4").tolist()
    assert len(ends) == table["count"] + 1
    return [content[start:end].decode() for start, end in pairwise(ends)]


def numbers(glb: Glb, name: str) -> list[float]:
    """A column of numbers of the table of properties."""
    (table,) = glb.document["extensions"]["EXT_structural_metadata"]["propertyTables"]
    view = glb.document["bufferViews"][table["properties"][name]["values"]]
    return np.frombuffer(glb.buffer[view["byteOffset"] :][: view["byteLength"]], "<f8").tolist()


def upwards(corners: np.ndarray) -> np.ndarray:
    """Points [..., 3] in the axes of 3D Tiles: x east, y north, z up."""
    return corners @ UPWARDS[:3, :3].T


@dataclass(frozen=True)
class Subtree:
    """A binary subtree, read by the text of the specification."""

    tiles: list[bool]
    contents: list[bool]
    children: list[bool]
    boxes: np.ndarray
    """[n, 12] of the available tiles in the order of their bits."""


def read_subtree(path: Path, levels: int = 5) -> Subtree:
    data = path.read_bytes()
    magic, version, num_text, num_binary = struct.unpack_from("<4sIQQ", data)
    assert (magic, version, num_text % 8, num_binary % 8) == (b"subt", 1, 0, 0)
    assert len(data) == 24 + num_text + num_binary
    head, binary = json.loads(data[24 : 24 + num_text]), data[24 + num_text :]

    def view(index: int) -> bytes:
        entry = head["bufferViews"][index]
        assert entry["byteOffset"] % 8 == 0
        return binary[entry["byteOffset"] :][: entry["byteLength"]]

    def bits(availability: dict[str, int], count: int) -> list[bool]:
        if "constant" in availability:
            return [bool(availability["constant"])] * count
        content = view(availability["bitstream"])
        assert len(content) == (count + 7) // 8
        flags = [bool(content[index // 8] >> index % 8 & 1) for index in range(count)]
        assert sum(flags) == availability["availableCount"]
        return flags

    num = (4**levels - 1) // 3
    (table,) = head["propertyTables"]
    (column,) = table["properties"].values()
    boxes = np.frombuffer(view(column["values"]), "<f8").reshape(table["count"], 12)
    (contents,) = head["contentAvailability"]
    return Subtree(
        bits(head["tileAvailability"], num),
        bits(contents, num),
        bits(head["childSubtreeAvailability"], 4**levels),
        boxes,
    )
