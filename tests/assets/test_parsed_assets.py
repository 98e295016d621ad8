"""A file that has not changed is parsed once, however many derivations use it."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
import pytest

from grammarlab.assets import mesh_files
from grammarlab.assets.mesh_files import Asset, AssetFolder, load_asset
from grammarlab.errors import AssetError

SQUARE = "mtllib paint.mtl\nv 0 0 0\nv 2 0 0\nv 2 0 {depth}\nv 0 0 {depth}\nusemtl paint\nf 1 2 3 4\n"


@pytest.fixture
def reads(monkeypatch, tmp_path) -> list[str]:
    """Names of the files that are read, in a folder whose files count as settled."""
    names: list[str] = []
    read = mesh_files.read_bounded

    def counted(file: Path, most: int) -> bytes:
        names.append(file.name)
        return read(file, most)

    monkeypatch.setattr(mesh_files, "read_bounded", counted)
    monkeypatch.setattr(mesh_files, "_SETTLED", -(10**18))
    (tmp_path / "square.obj").write_text(SQUARE.format(depth=3))
    (tmp_path / "paint.mtl").write_text("newmtl paint\nKd 1 0 0\n")
    return names


def red(asset: Asset) -> float:
    material = asset.materials[0]
    assert material is not None
    return material.color[0]


def test_a_file_is_read_again_only_after_it_or_a_file_that_it_refers_to_has_changed(reads, tmp_path):
    first = AssetFolder(tmp_path).load("square.obj")
    assert AssetFolder(tmp_path).load("square.obj").meshes is first.meshes
    assert reads == ["square.obj", "paint.mtl"]
    (tmp_path / "paint.mtl").write_text("newmtl paint\nKd 0 0 0\n")
    assert red(load_asset("square.obj", tmp_path)) == 0.0
    state = (tmp_path / "square.obj").stat()
    time.sleep(0.02)
    (tmp_path / "square.obj").write_text(SQUARE.format(depth=7))
    os.utime(tmp_path / "square.obj", ns=(state.st_atime_ns, state.st_mtime_ns))
    assert load_asset("square.obj", tmp_path).size.tolist() == [2.0, 0.0, 7.0]
    (tmp_path / "paint.mtl").unlink()
    alone = load_asset("square.obj", tmp_path)
    (tmp_path / "paint.mtl").write_text("newmtl paint\nKd 0.2 0 0\n")
    assert red(load_asset("square.obj", tmp_path)) == 0.2
    assert alone.materials != load_asset("square.obj", tmp_path).materials
    (tmp_path / "square.obj").unlink()
    with pytest.raises(AssetError):
        load_asset("square.obj", tmp_path)


def test_a_file_that_has_just_changed_is_read_each_time(reads, monkeypatch, tmp_path):
    monkeypatch.undo()
    first = load_asset("square.obj", tmp_path)
    second = load_asset("square.obj", tmp_path)
    assert second.meshes is not first.meshes
    assert second.meshes.same_as(first.meshes)


def test_an_image_that_appears_later_is_found(reads, tmp_path):
    (tmp_path / "paint.mtl").write_text("newmtl paint\nmap_Kd BRICK.png\n")
    expected = load_asset("square.obj", tmp_path).materials[0]
    (tmp_path / "brick.png").write_bytes(b"")
    present = load_asset("square.obj", tmp_path).materials[0]
    assert expected is not None
    assert present is not None
    assert (expected.texture, present.texture) == ("BRICK.png", "brick.png")
    assert reads.count("square.obj") == 1


def test_parsed_assets_have_a_bound_and_those_used_last_stay(reads, tmp_path):
    for number in range(4):
        (tmp_path / f"{number}.obj").write_text(SQUARE.format(depth=number + 1))
    (tmp_path / "large.obj").write_text("".join(f"v {i} {i % 2} 0\n" for i in range(200)) + "f 1 2 3\n" * 60)
    one = mesh_files._parse("0.obj", tmp_path).num_bytes
    parsed = mesh_files._ParsedAssets(3 * one)
    for name in ("0", "1", "2", "0", "3"):
        parsed.load(f"{name}.obj", tmp_path)
    reads.clear()
    assert [np.prod(parsed.load(f"{name}.obj", tmp_path).size[[0, 2]]) for name in "023"] == [2.0, 6.0, 8.0]
    assert reads == []
    parsed.load("large.obj", tmp_path)
    parsed.load("2.obj", tmp_path)
    assert reads == ["large.obj", "2.obj", "paint.mtl"]
