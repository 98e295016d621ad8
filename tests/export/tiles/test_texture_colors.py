"""Colours of textures from afar, and textures inside scenes."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from grammarlab.errors import AssetError
from grammarlab.export.tiles.simplified_models import simplified
from grammarlab.export.tiles.texture_colors import TextureColors, mean_light, with_pictures
from grammarlab.export.tiles.tile_file import write_tile
from grammarlab.export.tiles.tile_models import TileModels
from grammarlab.scene.joined import joined
from grammarlab.scene.shading import linear_from_srgb
from tests.export.gltf import read_glb
from tests.export.tiles.quarter import houses, properties
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


def test_textures_outside_their_folder_are_refused(tmp_path):
    scene = textured(tmp_path / "red", (200, 30, 30))
    names = tuple("../secret.png" if name else "" for name in scene.materials.textures)
    outside = replace(scene, materials=replace(scene.materials, textures=names))
    with pytest.raises(AssetError, match="outside"):
        with_pictures(outside, tmp_path / "red")
