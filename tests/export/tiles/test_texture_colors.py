"""Colours of textures from afar, and textures inside scenes."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import KDTree

from grammarlab.assets.srgb import linear_from_srgb
from grammarlab.derivation.derive import derive
from grammarlab.errors import AssetError
from grammarlab.export.tiles.simplified_models import simplified
from grammarlab.export.tiles.texture_colors import TextureColors, mean_light, with_pictures
from grammarlab.export.tiles.tile_file import write_tile
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.language.grammar import Grammar
from grammarlab.scene import realize
from grammarlab.scene.joined import joined
from tests.export.gltf import read_glb
from tests.export.tiles.quarter import drawn, houses, properties
from tests.scene.buildings import STONE


def png(pixels: np.ndarray) -> bytes:
    stream = BytesIO()
    Image.fromarray(pixels.astype(np.uint8)).save(stream, "PNG")
    return stream.getvalue()


def textured(folder: Path, color: tuple[int, int, int]):
    """A house whose walls have a texture of one colour."""
    folder.mkdir()
    (folder / "wall.png").write_bytes(png(np.full((8, 8, 3), color)))
    scene = houses([1])
    names = [""] * len(scene.materials)
    names[STONE] = "wall.png"
    return replace(scene, materials=replace(scene.materials, textures=tuple(names)))


def test_means_are_those_of_light_and_not_of_numbers():
    pixels = np.zeros((4, 4, 4))
    pixels[:, :2] = 255
    assert mean_light(png(pixels), is_cut_out=False) == pytest.approx([0.5] * 3)
    # Without the holes, which are the other half.
    assert mean_light(png(pixels), is_cut_out=True) == pytest.approx([1.0] * 3)


def test_walls_from_afar_have_the_colour_of_their_texture(tmp_path):
    scene = textured(tmp_path / "red", (200, 30, 30))
    light = TextureColors(tmp_path / "red").light(scene.materials)
    wall = linear_from_srgb(scene.materials.color[STONE]) * linear_from_srgb(np.array([200, 30, 30]) / 255)
    np.testing.assert_allclose(light[STONE], wall)
    (plain,) = simplified(scene, (300,), light)
    largest = np.bincount(plain.material).argmax()
    assert plain.materials.color[largest][0] > 2 * plain.materials.color[largest][1]


def test_scenes_of_two_asset_folders_keep_their_pictures(tmp_path):
    red, blue = textured(tmp_path / "red", (200, 30, 30)), textured(tmp_path / "blue", (30, 30, 200))
    scene = joined([with_pictures(red, tmp_path / "red"), with_pictures(blue, tmp_path / "blue")])
    tile = TileModels(scene, np.array([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0]]), properties([1, 2]))
    write_tile(tmp_path / "tile.glb", tile, "full", np.eye(4))
    glb = read_glb(tmp_path / "tile.glb")
    assert len(glb.document["images"]) == 2
    views = [glb.document["bufferViews"][image["bufferView"]] for image in glb.document["images"]]
    contents = {glb.buffer[view["byteOffset"] :][: view["byteLength"]] for view in views}
    assert contents == {(tmp_path / name / "wall.png").read_bytes() for name in ("red", "blue")}


def test_tiles_share_their_textures(tmp_path):
    scene = with_pictures(textured(tmp_path / "red", (200, 30, 30)), tmp_path / "red")
    tile = TileModels(scene, np.zeros((1, 3)), properties([1]))
    for name in ("1", "2"):
        path = tmp_path / "t" / name / "tile.glb"
        write_tile(path, tile, "full", np.eye(4), textures=tmp_path / "textures")
        (image,) = read_glb(path).document["images"]
        shared = (path.parent / image["uri"]).resolve()
        assert shared.read_bytes() == (tmp_path / "red" / "wall.png").read_bytes()
    assert len(list((tmp_path / "textures").iterdir())) == 1


RULES = """
Lot --> extrude(world.y, 9) comp(f) { side: Facade | top: Roof. }
Facade --> setupProjection(0, scope.xy, 2.5, 3.5, 0.25, 0.5) split(y) { 3: Floor }*
Floor --> split(x) { ~2: Bay }*
Bay --> texture("wall.png") projectUV(0) Wall.
"""


def test_instances_show_the_same_part_of_a_picture_as_merged_shapes(tmp_path):
    (tmp_path / "wall.png").write_bytes(png(np.full((8, 8, 3), 90)))
    scene = realize(derive(Grammar.parse(RULES), 6, seed=1, assets=tmp_path))
    numbers = list(range(6))
    tile = TileModels(scene, np.array([[30.0 * number, 0.0, 0.0] for number in numbers]), properties(numbers))
    summaries = [write_tile(tmp_path / f"{level}.glb", tile, level, np.eye(4), tmp_path) for level in ("full", "plain")]
    assert summaries[0].bytes < summaries[1].bytes / 2
    instanced, merged = (drawn(read_glb(tmp_path / f"{level}.glb")) for level in ("full", "plain"))
    rows, target = (surface.corners.reshape(-1, 9) for surface in (instanced, merged))
    distance, match = KDTree(target).query(rows)
    assert distance.max() < 1e-4
    difference = instanced.coordinates - merged.coordinates[match]
    shown = np.isfinite(merged.coordinates[match]).all(axis=(1, 2))
    np.testing.assert_array_equal(np.isfinite(instanced.coordinates).all(axis=(1, 2)), shown)
    assert shown.sum() > 100
    # By whole repeats of the picture, the same for all corners of a triangle.
    repeats = np.rint(difference[shown])
    np.testing.assert_allclose(difference[shown], repeats, atol=1e-3)
    np.testing.assert_array_equal(repeats, repeats[:, :1].repeat(3, axis=1))


def test_textures_outside_their_folder_are_refused(tmp_path):
    scene = textured(tmp_path / "red", (200, 30, 30))
    names = tuple("../secret.png" if name else "" for name in scene.materials.textures)
    outside = replace(scene, materials=replace(scene.materials, textures=names))
    with pytest.raises(AssetError, match="outside"):
        with_pictures(outside, tmp_path / "red")
