"""Many models in one file, that comes out the same however they come in batches."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from grammarlab.derivation import derive
from grammarlab.errors import UsageError
from grammarlab.export import REUSES, SaveOptions, gltf_document, model_files, save, save_together
from grammarlab.language.grammar import Grammar
from grammarlab.scene import Scene, realize
from tests.export.gltf import DTYPES, MESH_FORMATS, WIDTHS, Glb, read_glb, world

VILLAGE = """
attr width = rand(4, 9)
attr kind = rand(3)
Lot --> s(width, '1, 5) extrude(3) comp(f) { front : Wall | top : Roof | side : Plain }
Wall --> color(1, kind / 4, 0) texture("wall.png") setupProjection(0, scope.xy, 2, 1.5) projectUV(0)
         split(x) { ~1 : Tile | ~2 : t(0, 0, 1) r(0, 20, 0) Tile }
Roof --> 50%: roofGable(30) Tiles else: color(0, 0, kind / 3) primitiveCylinder(9, 1, 2) Tiles
Plain --> split(y) { 0.5 : color("#333333") Tile | ~1 : Tile }*
"""
WAYS: list[tuple[Any, Any]] = [(suffix, "merged") for suffix in MESH_FORMATS] + [("glb", reuse) for reuse in REUSES[1:]]
CUTS = [(0, 7), (0, 1, 2, 3, 4, 5, 6, 7), (0, 3, 7), (0, 0, 6, 7, 7)]


@pytest.fixture
def assets(tmp_path) -> Path:
    folder = tmp_path / "assets"
    folder.mkdir()
    Image.new("RGB", (8, 8), (200, 100, 50)).save(folder / "wall.png")
    return folder


def village(first: int, end: int, **options) -> Scene:
    return realize(derive(Grammar.parse(VILLAGE), end - first, 3, first_model=first, **options))


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize(("suffix", "reuse"), WAYS)
def test_one_file_does_not_depend_on_batches(tmp_path, assets, suffix, reuse):
    options = SaveOptions(reuse=reuse, assets=assets)
    save(village(0, 7), tmp_path / "whole" / f"village.{suffix}", options=options)
    whole = content(tmp_path / "whole")
    assert {Path(name).suffix for name in whole} == {"obj": {".obj", ".mtl", ".png"}}.get(suffix, {f".{suffix}"})
    for number, cut in enumerate(CUTS):
        folder = tmp_path / str(number)
        scenes = [village(first, end) for first, end in pairwise(cut)]
        save_together(scenes, folder / f"village.{suffix}", suffix, options)
        assert content(folder) == whole


@pytest.mark.parametrize(("suffix", "reuse"), WAYS)
def test_parts_outside_memory_make_the_same_file(tmp_path, assets, suffix, reuse, monkeypatch):
    options = SaveOptions(reuse=reuse, assets=assets)
    save(village(0, 5), tmp_path / "memory" / f"village.{suffix}", options=options)
    monkeypatch.setattr(model_files, "IN_MEMORY", 1)
    save(village(0, 5), tmp_path / "disk" / f"village.{suffix}", options=options)
    assert content(tmp_path / "disk") == content(tmp_path / "memory")


@pytest.mark.parametrize(("suffix", "reuse"), WAYS)
def test_a_failure_on_the_way_leaves_the_earlier_file(tmp_path, assets, suffix, reuse):
    class Broken:
        rounds = 0

        def __iter__(self) -> Iterator[Scene]:
            yield village(0, 2)
            self.rounds += 1
            if self.rounds == 2:
                raise KeyboardInterrupt
            yield village(2, 3)

    (tmp_path / "out").mkdir()
    target = tmp_path / "out" / f"village.{suffix}"
    target.write_text("earlier")
    with pytest.raises(KeyboardInterrupt):
        save_together(Broken(), target, suffix, SaveOptions(reuse=reuse, assets=assets))
    assert content(target.parent) == {target.name: b"earlier"}


def test_a_file_too_large_is_refused_before_it_is_whole(tmp_path, monkeypatch):
    monkeypatch.setattr(gltf_document, "MOST_BYTES", 20_000)
    with pytest.raises(UsageError, match="a GLB holds at most 20000"):
        save_together([village(0, 7), village(7, 14)], tmp_path / "out" / "village.glb", "glb")
    assert content(tmp_path / "out") == {}


@pytest.mark.parametrize("reuse", REUSES)
def test_every_accessor_of_a_file_lies_where_the_specification_wants_it(tmp_path, assets, reuse):
    path = save_together(
        [village(0, 3), village(3, 7)], tmp_path / "village.glb", "glb", SaveOptions(reuse=reuse, assets=assets)
    )
    glb = read_glb(path)
    check_structure(glb)
    if reuse != "instancing":
        loaded = trimesh.load_scene(path)
        corners = world(glb).corners.reshape(-1, 3)
        np.testing.assert_allclose(loaded.bounds, [corners.min(axis=0), corners.max(axis=0)], atol=1e-4)


def check_structure(glb: Glb) -> None:
    """Views that follow each other without overlap, accessors within them, aligned, with true bounds."""
    document = glb.document
    end = 0
    for view in document["bufferViews"]:
        assert view["byteOffset"] == end
        assert view["byteOffset"] % 4 == 0
        assert view["byteLength"] > 0
        end = view["byteOffset"] + view["byteLength"] + -view["byteLength"] % 4
    assert end == len(glb.buffer)
    for index, accessor in enumerate(document["accessors"]):
        view = document["bufferViews"][accessor["bufferView"]]
        size = np.dtype(DTYPES[accessor["componentType"]]).itemsize
        assert accessor.get("byteOffset", 0) % size == 0
        assert view.get("byteStride", 4) % 4 == 0
        assert view.get("byteStride", 4) in (4, size * WIDTHS[accessor["type"]])
        values = glb.values(index)  # asserts that it lies within its view
        if "min" in accessor:
            assert accessor["min"] == values.min(axis=0).tolist()
            assert accessor["max"] == values.max(axis=0).tolist()
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            attributes = primitive["attributes"]
            assert "min" in document["accessors"][attributes["POSITION"]]
            (count,) = {document["accessors"][attribute]["count"] for attribute in attributes.values()}
            if "indices" in primitive:
                assert glb.values(primitive["indices"]).max() < count
    numbers = range(len(document["nodes"]))
    shown = document["scenes"][0]["nodes"] + [child for node in document["nodes"] for child in node.get("children", [])]
    assert sorted(shown) == list(numbers)
    names = [node["name"] for node in document["nodes"] if node.get("name", "").startswith("model_")]
    assert len(names) == len(set(names))


def city(step: float) -> list[Scene]:
    """Parcels in the world, 40 km from the first to the last."""
    lot = np.array([[0.0, 0, 12], [20, 0, 12], [20, 0, 0], [0, 0, 0]])
    places = [[2683000.13 + k * step, 0.0, -1247000.37 - k * step / 2] for k in range(5)]
    return [village(k, k + 1, footprint=lot + place) for k, place in enumerate(places)]


@pytest.mark.parametrize(("suffix", "reuse"), WAYS)
@pytest.mark.parametrize("step", [30.0, 10_000.0])
def test_parcels_of_a_city_stand_in_their_places(tmp_path, suffix, reuse, step):
    """Each corner of the file, with the origin of the file added in 64 bits, is that of the parcel's own model."""
    scenes = city(step)
    options = SaveOptions(reuse=reuse, in_place=True)
    origin, found = points_of(save_together(scenes, tmp_path / f"city.{suffix}", suffix, options))
    # Only PLY has numbers of 32 bits here: those below 256 m have steps of 15 micrometres.
    tolerance = 1e-5 if suffix == "ply" and step < 1000 else 1e-6
    first = 0
    for scene in scenes:
        at_home = replace(scene, origins=np.zeros((1, 3)))
        _, own = points_of(save(at_home, tmp_path / f"own.{suffix}", options=options))
        there = found[first : first + len(own)] + (origin - scene.origins[0])
        assert np.abs(there - own).max() < tolerance
        first += len(own)
    assert first == len(found)


def points_of(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """[3] the origin of a file, and [P, 3] points of its models from there."""
    if path.suffix == ".glb":
        glb = read_glb(path)
        (root,) = [node for node in glb.document["nodes"] if node.get("name") == "origin"] or [{}]
        origin = np.array(root.pop("translation", [0.0, 0.0, 0.0]))
        return origin, world(glb).corners.reshape(-1, 3)
    head, _, _ = path.read_bytes().partition(b"end_header" if path.suffix == ".ply" else b"\nv ")
    lines = [line.split("origin ")[1].split()[:3] for line in head.decode().splitlines() if "origin " in line]
    origin = np.array(lines[0] if lines else [0, 0, 0], dtype=float)
    if path.suffix == ".obj":
        rows = [line.split()[1:] for line in path.read_text().splitlines() if line.startswith("v ")]
        return origin, np.array(rows, dtype=float)
    mesh = trimesh.load(path, process=False)
    assert isinstance(mesh, trimesh.Trimesh)
    return origin, np.asarray(mesh.vertices, dtype=float)
