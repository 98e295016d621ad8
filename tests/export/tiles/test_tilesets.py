"""Explicit and implicit tilesets of a quarter, walked as viewers do."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from grammarlab.errors import UsageError
from grammarlab.export.tiles.city_tileset import write_city
from grammarlab.export.tiles.earth_placement import EarthPlacement
from grammarlab.export.tiles.tile_branch import TileWriter
from grammarlab.export.tiles.tile_grid import TileCell
from grammarlab.export.tiles.tile_shard import write_quad, write_shard
from grammarlab.geometry.footprints.frame import Frame
from tests.export.gltf import read_glb
from tests.export.tiles.quarter import drawn, explicit_tiles, quarter, read_subtree, texts, upwards

PLACEMENT = EarthPlacement(Frame("EPSG:32631", (448e3, 5412e3)), 44.0)
QUARTER = quarter()
ROUNDING = 1e-9


@pytest.fixture(scope="module")
def city(tmp_path_factory) -> Path:
    """A city with its explicit tileset."""
    folder = tmp_path_factory.mktemp("city")
    QUARTER.write(folder, PLACEMENT)
    write_city(folder, QUARTER.grid, PLACEMENT, QUARTER.keys())
    return folder


@pytest.fixture(scope="module")
def implicit_city(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("implicit")
    QUARTER.write(folder, PLACEMENT)
    write_city(folder, QUARTER.grid, PLACEMENT, dict(reversed(QUARTER.keys().items())), implicit=True)
    return folder


def test_corners_lie_in_the_boxes_of_their_tile_and_of_all_above_it(city):
    for tile in explicit_tiles(city / "tileset.json"):
        corners = upwards(drawn(read_glb(tile.content)).corners).reshape(-1, 3)
        for low, high in tile.boxes:
            assert (corners >= low).all()
            assert (corners <= high).all()
        for (low, high), (inner_low, inner_high) in zip(tile.boxes[:-1], tile.boxes[1:], strict=True):
            assert (inner_low >= low - ROUNDING).all()
            assert (inner_high <= high + ROUNDING).all()


def test_errors_fall_to_0(city):
    errors = {4.0, 8.0}
    for tile in explicit_tiles(city / "tileset.json"):
        assert list(tile.errors) == sorted(tile.errors, reverse=True)
        has_children = "children" in tile.tile
        assert (tile.tile["geometricError"] > 0) == has_children
        errors.discard(tile.tile["geometricError"])
    assert not errors


def test_every_building_is_in_one_leaf(city):
    leaves = [tile for tile in explicit_tiles(city / "tileset.json") if "children" not in tile.tile]
    ids = [name for leaf in leaves for name in texts(read_glb(leaf.content), "id")]
    assert sorted(ids) == sorted(f"parcel {number} ü" for number in range(len(QUARTER.places)))


def test_levels_above_hold_the_same_buildings_with_fewer_triangles(city):
    for tile in explicit_tiles(city / "tileset.json"):
        glb = read_glb(tile.content)
        most = {0.0: 10_000, 4.0: 300}.get(tile.tile["geometricError"], 30)
        assert np.bincount(drawn(glb).feature).max() <= most
        if tile.tile["geometricError"] == 4.0:
            below = [texts(read_glb(city / child["content"]["uri"][6:]), "id") for child in tile.tile["children"]]
            assert sorted(texts(glb, "id")) == sorted(name for names in below for name in names)


def test_implicit_tiles_are_the_explicit_ones(city, implicit_city):
    document = json.loads((implicit_city / "tileset.json").read_bytes())
    tiling = document["root"]["implicitTiling"]
    assert (tiling["availableLevels"], tiling["subtreeLevels"]) == (10, 5)
    boxes: dict[str, np.ndarray] = {}

    def walk(level: int, x: int, y: int) -> None:
        uri = tiling["subtrees"]["uri"].format(level=level, x=x, y=y)
        subtree = read_subtree(implicit_city / uri)
        rows = iter(subtree.boxes)
        for depth in range(5):
            for code in range(4**depth):
                bit = (4**depth - 1) // 3 + code
                across, up = (int(f"{code:010b}"[start::2], 2) for start in (1, 0))
                cell = level + depth, (x << depth) + across, (y << depth) + up
                if subtree.tiles[bit]:
                    box = next(rows)
                    if depth:
                        assert subtree.tiles[(4 ** (depth - 1) - 1) // 3 + (code >> 2)]
                    if subtree.contents[bit]:
                        name = document["root"]["content"]["uri"].format(level=cell[0], x=cell[1], y=cell[2])
                        boxes[name] = box
                else:
                    assert not subtree.contents[bit]
        assert next(rows, None) is None
        for code in range(4**5):
            across, up = (int(f"{code:010b}"[start::2], 2) for start in (1, 0))
            if subtree.children[code]:
                walk(level + 5, (x << 5) + across, (y << 5) + up)

    walk(0, 0, 0)
    explicit = {str(tile.content.relative_to(city.resolve())): tile for tile in explicit_tiles(city / "tileset.json")}
    assert boxes.keys() == explicit.keys()
    for name, tile in explicit.items():
        np.testing.assert_allclose(boxes[name], tile.tile["boundingVolume"]["box"], atol=1e-9)
        assert (implicit_city / name).read_bytes() == tile.content.read_bytes()
    files = {str(path.relative_to(implicit_city)) for path in implicit_city.glob("t/**/*.glb")}
    assert files == set(boxes)


def test_implicit_cells_contain_the_places_of_their_buildings(implicit_city):
    document = json.loads((implicit_city / "tileset.json").read_bytes())
    grid = QUARTER.grid
    size = 2 * document["root"]["boundingVolume"]["box"][3]
    for x, y in grid.leaves(QUARTER.places).tolist():
        ids = texts(read_glb(implicit_city / f"t/9/{x}/{y}.glb"), "id")
        rows = [int(name.split()[1]) for name in ids]
        east, north = QUARTER.places[rows, 0], -QUARTER.places[rows, 2]
        np.testing.assert_array_equal(np.floor((east + size / 2) / (size / 512)), x)
        np.testing.assert_array_equal(np.floor((north + size / 2) / (size / 512)), y)


def test_files_depend_on_nothing_but_the_buildings(city, tmp_path):
    """Another house far away leaves all tiles but those above it."""
    more = quarter()
    places = np.vstack((more.places, [[5000.0, 0.0, 5000.0]]))
    grown = type(more)(places)
    grown.write(tmp_path, PLACEMENT)
    write_city(tmp_path, grown.grid, PLACEMENT, grown.keys())
    for path in city.glob("t/*/*/*.glb"):
        if int(path.parts[-3]) >= QUARTER.grid.shard_level:
            assert path.read_bytes() == (tmp_path / path.relative_to(city)).read_bytes()


def test_a_place_without_coordinates_has_no_transform(tmp_path, city):
    local = EarthPlacement(Frame("", (0.0, 0.0)))
    few = quarter(5, 100.0)
    nodes = few.write(tmp_path, local)
    num_bytes = sum(path.stat().st_size for path in tmp_path.glob("t/**/*.glb"))
    assert sum(file.num_bytes for node in nodes for file in node.files()) == num_bytes
    assert write_city(tmp_path, few.grid, local, few.keys()) == len(list(tmp_path.glob("t/**/*.glb")))
    assert "transform" not in json.loads((tmp_path / "tileset.json").read_bytes())["root"]
    transform = json.loads((city / "tileset.json").read_bytes())["root"]["transform"]
    root = PLACEMENT.root_transform()
    assert root is not None
    np.testing.assert_allclose(np.array(transform).reshape(4, 4).T, root)


def test_leaves_out_of_order_or_outside_are_refused(tmp_path):
    writer = TileWriter(tmp_path, QUARTER.grid, PLACEMENT, QUARTER.shards[0])
    leaves = list(QUARTER.leaves(QUARTER.shards[0]))
    quads = [[leaf for leaf in leaves if leaf[0].parent == quad] for quad in QUARTER.quads(QUARTER.shards[0])]
    several = next(quad for quad in quads if len(quad) > 1)
    for wrong in (several[::-1], [], [*several, several[0]], [*several, (TileCell(9, 0, 0), leaves[0][1])]):
        with pytest.raises(UsageError, match="Morton order"):
            write_quad(writer, several[0][0].parent, "a key", wrong)


def test_quads_that_are_not_written_are_named(tmp_path):
    writer = TileWriter(tmp_path, QUARTER.grid, PLACEMENT, QUARTER.shards[0])
    with pytest.raises(UsageError, match="expected the written quad"):
        write_shard(writer, QUARTER.shards[0], QUARTER.quads(QUARTER.shards[0]))
