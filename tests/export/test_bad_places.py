"""Places that cannot be written to, interrupted writing, and textures from elsewhere."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from grammarlab.assets import texture_files
from grammarlab.assets.texture_files import find_texture
from grammarlab.errors import AssetError, DerivationError, UsageError
from grammarlab.export import SaveOptions, gltf_document, model_files, save, save_each
from grammarlab.export.model_files import whole_file
from grammarlab.scene import Scene
from tests.scene.buildings import BOX, STONE, house, materials, scene_of, street

FORMATS = ("glb", "obj", "ply")


def with_texture(name: str) -> Scene:
    table = materials()
    return scene_of([house()], replace(table, textures=(name, *table.textures[1:])))


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_file_in_the_way_of_a_folder_is_named(tmp_path, suffix):
    (tmp_path / "taken").write_text("in the way")
    with pytest.raises(UsageError, match=r"cannot write .*taken/model\..*choose a folder"):
        save(street(), tmp_path / "taken" / f"model.{suffix}")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_folder_in_the_place_of_the_file_is_kept(tmp_path, suffix):
    place = tmp_path / f"model.{suffix}"
    place.mkdir()
    with pytest.raises(UsageError, match="cannot write"):
        save(street(), place)
    assert place.is_dir()
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("name", ["a\0b.glb", "x" * 300 + ".glb"])
def test_names_that_no_file_can_have_are_refused(tmp_path, name):
    with pytest.raises(UsageError, match="cannot write"):
        save(street(), tmp_path / name)


def test_an_empty_path_is_refused():
    with pytest.raises(UsageError, match="cannot write"):
        save(street(), "", "glb")


def test_an_unknown_format_lists_the_choices(tmp_path):
    with pytest.raises(UsageError, match="'fbx'; choose one of glb, obj, ply"):
        save(street(), tmp_path / "model.fbx")


@pytest.mark.parametrize(("options", "message"), [({"reuse": "all"}, "merged, nodes"), ({"columns": 0}, "at least 1")])
def test_options_that_do_not_fit_are_refused(options, message):
    with pytest.raises(UsageError, match=message):
        SaveOptions(**options)


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("fault", [KeyboardInterrupt, OSError(28, "No space left on device")])
def test_what_is_interrupted_leaves_the_earlier_file_and_nothing_else(tmp_path, monkeypatch, suffix, fault):
    path = save(scene_of([house()]), tmp_path / f"model.{suffix}")
    before = {entry.name: entry.read_bytes() for entry in tmp_path.iterdir()}

    def interrupted(self: Path, target: Path) -> Path:
        assert self.stat().st_size > 0
        raise fault

    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises((KeyboardInterrupt, OSError)) as caught:
        save(scene_of([house(20.0)]), path)
    if isinstance(caught.value, OSError):  # a full disk is reported with the name of the file
        assert "/model." in str(caught.value.filename)
    assert {entry.name: entry.read_bytes() for entry in tmp_path.iterdir()} == before


@pytest.mark.parametrize("suffix", FORMATS)
def test_an_interrupted_series_keeps_the_models_that_are_finished(tmp_path, suffix):
    def stop(model: int) -> None:
        if model == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        save_each(street(), tmp_path / "cut", suffix, on_saved=stop)
    save_each(street(), tmp_path / "whole", suffix)
    finished = sorted(path.name for path in (tmp_path / "cut").iterdir())
    assert [name for name in finished if name.endswith(suffix)] == [f"model_{index:05d}.{suffix}" for index in (0, 1)]
    for name in finished:
        assert (tmp_path / "cut" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_an_obj_is_written_after_everything_that_it_refers_to(tmp_path, monkeypatch):
    Image.new("RGB", (4, 4)).save(tmp_path / "wall.png")
    order: list[str] = []
    whole = Path.replace
    monkeypatch.setattr(Path, "replace", lambda self, target: (order.append(target.suffix), whole(self, target))[1])
    save(with_texture("wall.png"), tmp_path / "model.obj", options=SaveOptions(assets=tmp_path))
    assert order == [".png", ".mtl", ".obj"]


def test_the_folder_on_the_way_is_made(tmp_path):
    model_files.write_whole(tmp_path / "a" / "b" / "c.bin", b"content")
    assert (tmp_path / "a" / "b" / "c.bin").read_bytes() == b"content"


@pytest.mark.parametrize("reuse", ["merged", "nodes", "instancing"])
def test_a_file_longer_than_a_glb_can_be_is_refused(tmp_path, monkeypatch, reuse):
    monkeypatch.setattr(gltf_document, "MOST_BYTES", 10_000)
    with pytest.raises(UsageError, match="holds at most 10000; write fewer models"):
        save(street(), tmp_path / "model.glb", options=SaveOptions(reuse=reuse))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("reuse", ["merged", "nodes", "instancing"])
@pytest.mark.parametrize(("column", "name"), [("position", "position"), ("size", "size"), ("frames", "rotation")])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_metres_never_reach_a_file(tmp_path, suffix, reuse, column, name, value):
    scene = street()
    values = getattr(scene, column).copy()
    values[5].flat[0] = value
    with pytest.raises(DerivationError, match=name):
        save(replace(scene, **{column: values}), tmp_path / f"model.{suffix}", options=SaveOptions(reuse=reuse))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("save_scene", [save, save_each])
def test_mirrored_shapes_never_reach_a_file(tmp_path, save_scene):
    mirrored = scene_of([[(BOX, STONE, (0, 0, 0), (1, 1, 1), np.diag([-1.0, 1.0, 1.0]))]])
    with pytest.raises(DerivationError, match="right-handed"):
        save_scene(mirrored, tmp_path / "model.glb")
    assert not list(tmp_path.iterdir())


@pytest.fixture
def assets(tmp_path) -> Path:
    """An asset folder beside an image that is not part of it."""
    folder = tmp_path / "assets"
    (folder / "walls").mkdir(parents=True)
    Image.new("RGB", (4, 4)).save(tmp_path / "secret.png")
    Image.new("RGB", (4, 4)).save(folder / "walls" / "brick.png")
    (folder / "link.png").symlink_to(tmp_path / "secret.png")
    (folder / "folder_link").symlink_to(tmp_path)
    return folder


OUTSIDE = ["../secret.png", "walls/../../secret.png", "link.png", "folder_link/secret.png"]


@pytest.mark.parametrize("name", OUTSIDE)
@pytest.mark.parametrize("suffix", ["glb", "obj"])
@pytest.mark.parametrize("reuse", ["merged", "nodes", "instancing"])
def test_textures_outside_the_asset_folder_are_refused(assets, tmp_path, name, suffix, reuse):
    target = tmp_path / "out" / f"model.{suffix}"
    with pytest.raises(AssetError, match="outside the asset folder"):
        save(with_texture(name), target, options=SaveOptions(reuse=reuse, assets=assets))
    assert not list(target.parent.iterdir())


def test_a_folder_that_is_a_link_to_itself_is_refused(tmp_path):
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(AssetError, match="not a usable path"):
        find_texture("a.png", tmp_path / "loop")


@pytest.mark.parametrize("name", ["a\0b.png", "x" * 300, "x/" * 5000])
def test_names_of_textures_that_no_file_can_have_are_refused(assets, name):
    with pytest.raises(AssetError):
        find_texture(name, assets)


@pytest.mark.parametrize(
    "name", ["walls/brick.png", "./walls/../walls/brick.png", "assets/walls/brick.png", "/City/assets/walls/brick.png"]
)
def test_textures_inside_the_folder_are_found(assets, name):
    texture = find_texture(name, assets)
    assert texture is not None
    assert texture.content == (assets / "walls" / "brick.png").read_bytes()
    assert (texture.mime, texture.suffix) == ("image/png", ".png")


@pytest.mark.parametrize(
    ("name", "folder"),
    [("", True), ("missing.png", True), ("walls", True), ("walls/brick.png", False), ("/etc/hostname", True)],
)
def test_textures_that_are_not_there_are_left_out(assets, name, folder):
    assert find_texture(name, assets if folder else None) is None


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "L", "P", "1"])
@pytest.mark.parametrize("suffix", [".tif", ".bmp"])
def test_images_of_older_kinds_become_png_of_the_same_pixels(assets, mode, suffix):
    image = Image.effect_noise((6, 5), 90).convert(mode)
    image.save(assets / f"old{suffix}")
    found = find_texture(f"old{suffix}", assets)
    assert found is not None
    assert (found.mime, found.suffix) == ("image/png", ".png")
    with Image.open(assets / f"old{suffix}") as saved, Image.open(BytesIO(found.content)) as made:
        assert made.format == "PNG"
        assert made.convert("RGBA").tobytes() == saved.convert("RGBA").tobytes()


def test_broken_images_of_older_kinds_are_refused(assets):
    Image.effect_noise((64, 64), 50).save(assets / "whole.tif")
    for length in (4, 100, 2000):
        (assets / "cut.tif").write_bytes((assets / "whole.tif").read_bytes()[:length])
        with pytest.raises(AssetError, match="broken image"):
            find_texture("cut.tif", assets)


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_broken_images_are_refused(assets, suffix):
    whole = assets / f"whole{suffix}"
    Image.effect_noise((64, 64), 50).save(whole)
    (assets / f"cut{suffix}").write_bytes(whole.read_bytes()[: 12 if suffix == ".jpg" else 400])
    assert find_texture(whole.name, assets) is not None
    with pytest.raises(AssetError, match="broken image"):
        find_texture(f"cut{suffix}", assets)


def test_files_that_are_no_images_are_refused(assets):
    (assets / "text.png").write_text("no image")
    with pytest.raises(AssetError, match="neither a PNG nor a JPEG"):
        find_texture("text.png", assets)


@pytest.mark.parametrize(("limit", "message"), [("MOST_BYTES", "MiB"), ("MOST_PIXELS", "4 x 4 pixels")])
def test_images_that_are_too_large_are_refused(assets, monkeypatch, limit, message):
    monkeypatch.setattr(texture_files, limit, 10)
    with pytest.raises(AssetError, match=message):
        find_texture("walls/brick.png", assets)


def test_ctrl_c_at_any_line_leaves_nothing_that_complains_when_it_is_destroyed(tmp_path, monkeypatch):
    complaints = []
    monkeypatch.setattr(sys, "unraisablehook", complaints.append)
    line = 0
    while is_interrupted(line, lambda: write_parts(tmp_path / "model.glb")):
        line += 1
    gc.collect()
    assert line > 50
    # The interruption itself may come in a destructor; and only who asks for it hears that one has closed a file.
    harmless = (KeyboardInterrupt, ResourceWarning)
    assert [each.exc_value for each in complaints if not isinstance(each.exc_value, harmless)] == []


def write_parts(path: Path) -> None:
    with whole_file(path) as output:
        output.part().write(b"part")


def is_interrupted(line: int, run: Callable[[], None]) -> bool:
    """Interrupt a function in a line, counted in the order in which they run; whether it has so many."""
    passed = count()

    def trace(_frame: object, event: str, _argument: object) -> Any:
        if event == "line" and next(passed) == line:
            raise KeyboardInterrupt
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        run()
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(before)
    return False
