"""Files of tiles hold the models of the scene, with their ids, in any way of writing them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from grammarlab.assets.srgb import linear_from_srgb
from grammarlab.errors import UsageError
from grammarlab.export.tiles import tile_instances
from grammarlab.export.tiles.tile_file import write_tile
from grammarlab.export.tiles.tile_models import TileModels, joined_tiles
from grammarlab.scene import triangles
from tests.export.gltf import read_glb
from tests.export.tiles.quarter import drawn, houses, numbers, properties, texts, tile_of

NUMBERS = list(range(12))


def expected(tile: TileModels) -> np.ndarray:
    """[T, 13] triangles of a tile: corners, colour, feature."""
    batch = triangles(tile.scene)
    model = np.repeat(batch.group_model, np.diff(batch.group_triangles))
    corners = batch.vertices[batch.triangles] + tile.offset[model][:, None]
    color = linear_from_srgb(batch.materials.color)[batch.material_of_triangle()]
    return np.column_stack((corners.reshape(-1, 9), color, model))


def written(path: Path) -> np.ndarray:
    surface = drawn(read_glb(path))
    return np.column_stack((surface.corners.reshape(-1, 9), surface.color, surface.feature))


@pytest.mark.parametrize("level", ["full", "plain"])
def test_instances_and_merged_shapes_are_the_triangles_of_the_scene(tmp_path, level):
    tile = tile_of(NUMBERS)
    summary = write_tile(tmp_path / "tile.glb", tile, level, np.eye(4))
    rows, target = written(tmp_path / "tile.glb"), expected(tile)
    assert len(rows) == len(target) == summary.triangles
    distance, match = KDTree(target).query(rows)
    assert distance.max() < 1e-3
    assert len(np.unique(match)) == len(target)
    assert summary.bytes == (tmp_path / "tile.glb").stat().st_size
    assert summary.draws == drawn(read_glb(tmp_path / "tile.glb")).draws


def test_boxes_contain_all_corners_and_are_tight(tmp_path):
    tile = tile_of(NUMBERS)
    summary = write_tile(tmp_path / "tile.glb", tile, "full", np.eye(4))
    corners = drawn(read_glb(tmp_path / "tile.glb")).corners.reshape(-1, 3)
    assert (corners >= summary.low).all()
    assert (corners <= summary.high).all()
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)], [summary.low, summary.high], atol=0.01)


def test_properties_survive(tmp_path):
    write_tile(tmp_path / "tile.glb", tile_of(NUMBERS), "full", np.eye(4))
    glb, table = read_glb(tmp_path / "tile.glb"), properties(NUMBERS)
    assert texts(glb, "id") == table["id"].to_pylist()
    assert texts(glb, "model") == table["model"].to_pylist()
    assert numbers(glb, "height") == table["height"].to_pylist()
    assert "EXT_structural_metadata" not in glb.document["extensionsRequired"]


def test_instances_are_shared_by_all_buildings(tmp_path):
    small = write_tile(tmp_path / "small.glb", tile_of(NUMBERS[:6]), "full", np.eye(4))
    large = write_tile(tmp_path / "large.glb", tile_of([*NUMBERS, *range(12, 24)]), "full", np.eye(4))
    assert large.draws <= small.draws + 3
    assert large.bytes < 4 * small.bytes
    # 44 bytes of an instance and 4 of its id, instead of the vertices.
    assert large.bytes < write_tile(tmp_path / "merged.glb", tile_of(NUMBERS), "plain", np.eye(4)).bytes


def test_draws_are_limited(tmp_path, monkeypatch):
    """Also if every shape has another roughness."""
    tile = tile_of(NUMBERS)
    few = write_tile(tmp_path / "few.glb", tile, "full", np.eye(4))
    monkeypatch.setattr(tile_instances, "MAX_DRAWS", 6)
    summary = write_tile(tmp_path / "tile.glb", tile, "full", np.eye(4))
    assert summary.draws <= 6 < few.draws
    assert summary.triangles == few.triangles == len(written(tmp_path / "tile.glb")) == len(expected(tile))
    monkeypatch.undo()
    num, table = len(tile.scene), tile.scene.materials
    channels = table.channels[tile.scene.material]
    channels[:, 3:6] = np.random.default_rng(0).uniform(0.1, 1.0, (num, 3))
    scene = replace(
        tile.scene, materials=replace(table, channels=channels, textures=("",) * num), material=np.arange(num)
    )
    assert write_tile(tmp_path / "rough.glb", replace(tile, scene=scene), "full", np.eye(4)).draws <= 150


def test_missing_textures_leave_the_colour(tmp_path):
    tile = tile_of(NUMBERS)
    names = tuple("missing.png" for _ in tile.scene.materials.textures)
    named = replace(tile, scene=replace(tile.scene, materials=replace(tile.scene.materials, textures=names)))
    write_tile(tmp_path / "one.glb", tile, "full", np.eye(4))
    write_tile(tmp_path / "two.glb", named, "full", np.eye(4), tmp_path)
    assert (tmp_path / "one.glb").read_bytes() == (tmp_path / "two.glb").read_bytes()


def test_tables_of_the_scene_do_not_matter(tmp_path):
    """The same models from several scenes, whose meshes and materials are numbered differently."""
    write_tile(tmp_path / "one.glb", tile_of(NUMBERS), "full", np.eye(4))
    parts = joined_tiles([tile_of(NUMBERS[:5]), tile_of(NUMBERS[5:])])
    write_tile(tmp_path / "two.glb", parts, "full", np.eye(4))
    assert (tmp_path / "one.glb").read_bytes() == (tmp_path / "two.glb").read_bytes()


@pytest.mark.parametrize("shear", [0.0, 0.002])
def test_a_tile_is_put_into_its_place_by_any_matrix(tmp_path, shear):
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", [0.01, 0.04, -0.02]).as_matrix() @ np.diag([1.0004, 1.0, 0.9998])
    matrix[:3, :3] @= np.array([[1.0, 0.0, shear], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    matrix[:3, 3] = 5000.123456789, -7.5, 12345.678901234
    tile = tile_of(NUMBERS[:3])
    write_tile(tmp_path / "here.glb", tile, "plain", np.eye(4))
    write_tile(tmp_path / "there.glb", tile, "plain", matrix)
    here, there = (drawn(read_glb(tmp_path / f"{name}.glb")).corners for name in ("here", "there"))
    target = here @ matrix[:3, :3].T + matrix[:3, 3]
    np.testing.assert_allclose(there, target, atol=1e-3)
    assert all("matrix" not in node for node in read_glb(tmp_path / "there.glb").document["nodes"])


def test_a_tile_without_models_is_refused(tmp_path):
    empty = TileModels(houses([]), np.zeros((0, 3)), properties([]))
    with pytest.raises(UsageError, match="at least one model"):
        write_tile(tmp_path / "tile.glb", empty, "full", np.eye(4))
    with pytest.raises(UsageError, match="expected an offset"):
        TileModels(houses([1]), np.zeros((2, 3)), properties([1]))
