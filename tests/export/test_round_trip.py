"""What is written is what is read back, by another library and by the readers of assets, examples and scans."""

from __future__ import annotations

import json
import struct
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import trimesh

from grammarlab.assets.mesh_files import AssetFolder, load_asset, read_parts
from grammarlab.derivation import derive
from grammarlab.errors import GrammarlabError
from grammarlab.export import REUSES, SaveOptions, save, save_each, save_together
from grammarlab.geometry.meshes.triangulate import triangulate
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.scene import realize, triangles
from grammarlab.scene.layout import grid, model_bounds
from tests.export.gltf import MESH_FORMATS

GRAMMARS = Path(__file__).parents[2] / "grammars"
ASSETS = AssetFolder(GRAMMARS / "assets")


FORMS = [(suffix, reuse) for suffix in MESH_FORMATS for reuse in (REUSES if suffix == "glb" else ("merged",))]
"""Every form of a file: the format, and how GLB shares meshes."""


@cache
def scene_of(name: str, num_models: int = 1):
    return realize(derive(load(GRAMMARS / f"{name}.cga"), num_models, 5, assets=ASSETS))


def triangles_of(path: Path) -> np.ndarray:
    """[T, 3, 3] corners of a file, as the readers of examples and scans see them."""
    parts = read_parts(path.read_bytes(), path.suffix, lambda name: (path.parent / name).read_bytes(), 10**6)
    return np.concatenate([part.points[part.triangles] for part in parts])


def area_of(corners: np.ndarray) -> float:
    a, b, c = corners.astype(float).transpose(1, 0, 2)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def assert_same_shape(found: np.ndarray, expected: np.ndarray) -> None:
    """Compare the number, the area and the bounding box of triangles [T, 3, 3]."""
    assert len(found) == len(expected)
    assert area_of(found) == pytest.approx(area_of(expected), rel=1e-4)
    for end in (np.min, np.max):
        assert end(found, axis=(0, 1)) == pytest.approx(end(expected, axis=(0, 1)), abs=1e-4)


def read(path: Path) -> trimesh.Trimesh:
    return trimesh.load_scene(path, process=False).to_mesh()


def chunk(path: Path) -> dict:
    content = path.read_bytes()
    (length,) = struct.unpack_from("<I", content, 12)
    return json.loads(content[20 : 20 + length])


@pytest.mark.parametrize("suffix", ["glb", "obj", "ply"])
@pytest.mark.parametrize("name", ["furniture", "building"])
def test_a_file_holds_the_triangles_of_the_scene(tmp_path, suffix, name):
    scene = scene_of(name)
    batch = triangles(scene)
    path = tmp_path / f"model.{suffix}"
    save(scene, path)
    mesh = read(path)
    a, b, c = (batch.vertices[batch.triangles[:, i]].astype(float) for i in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert len(mesh.faces) == len(batch.triangles)
    assert mesh.area == pytest.approx(area, rel=1e-4)
    assert np.allclose(mesh.bounds, [batch.vertices.min(axis=0), batch.vertices.max(axis=0)], atol=1e-4)


@pytest.mark.parametrize(("suffix", "reuse"), FORMS)
@pytest.mark.parametrize("name", ["furniture", "building"])
def test_every_form_of_a_file_is_read_back_to_the_same_shape(tmp_path, name, suffix, reuse):
    scene, options = scene_of(name, 2), SaveOptions(reuse=reuse)
    batch = triangles(scene)
    owner = np.repeat(np.arange(2), batch.triangles_per_model())
    corners = batch.vertices[batch.triangles]
    for model, path in enumerate(save_each(scene, tmp_path, suffix, options)):
        assert_same_shape(triangles_of(path), corners[owner == model])
    shifted = corners + grid(*model_bounds(batch), batch.origins).offsets[owner][:, None, :]
    assert_same_shape(triangles_of(save(scene, tmp_path / f"all.{suffix}", options=options)), shifted)
    assert_same_shape(triangles_of(save_together([scene], tmp_path / f"together.{suffix}", suffix, options)), shifted)


@pytest.mark.parametrize(("suffix", "reuse"), [form for form in FORMS if form[0] != "ply"])
def test_every_form_of_a_file_is_an_asset_of_the_same_size(tmp_path, suffix, reuse):
    scene = scene_of("furniture")
    save(scene, tmp_path / f"model.{suffix}", options=SaveOptions(reuse=reuse))
    asset = load_asset(f"model.{suffix}", tmp_path)
    mesh = asset.meshes.with_points(asset.meshes.points * asset.size + asset.low)
    corners = mesh.points[triangulate(mesh)[0]]
    if suffix == "obj":
        assert mesh.num_faces == scene.meshes.take(scene.mesh).num_faces
    batch = triangles(scene)
    assert_same_shape(corners, batch.vertices[batch.triangles])


@pytest.mark.parametrize("suffix", ["glb", "obj"])
def test_the_colors_of_a_file_are_read_back(tmp_path, suffix):
    scene = realize(derive(Grammar.parse('Lot --> color("#bc8040") set(material.opacity, 0.4) extrude(3)'), 1, 1))
    path = save(scene, tmp_path / f"model.{suffix}")
    (part,) = read_parts(path.read_bytes(), path.suffix, lambda name: (tmp_path / name).read_bytes(), 10**6)
    srgb = np.array([0xBC, 0x80, 0x40]) / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    assert part.color == pytest.approx([*(linear if suffix == "glb" else srgb), 0.4], abs=1 / 255)


def test_shared_meshes_make_the_same_surface(tmp_path):
    scene = scene_of("furniture")
    save(scene, tmp_path / "merged.glb")
    save(scene, tmp_path / "nodes.glb", options=SaveOptions(reuse="nodes"))
    merged, nodes = read(tmp_path / "merged.glb"), read(tmp_path / "nodes.glb")
    assert nodes.area == pytest.approx(merged.area, rel=1e-4)
    assert np.allclose(nodes.bounds, merged.bounds, atol=1e-4)


def test_gpu_instancing_is_declared(tmp_path):
    save(scene_of("building"), tmp_path / "model.glb", options=SaveOptions(reuse="instancing"))
    document = chunk(tmp_path / "model.glb")
    assert "EXT_mesh_gpu_instancing" in document["extensionsUsed"]
    assert "EXT_mesh_gpu_instancing" in document["extensionsRequired"]


def test_colours_are_written_linear(tmp_path):
    scene = realize(derive(Grammar.parse('Lot --> color("#bc8040") set(material.opacity, 0.5) extrude(3)'), 1, 1))
    save(scene, tmp_path / "model.glb")
    (material,) = chunk(tmp_path / "model.glb")["materials"]
    srgb = np.array([0xBC, 0x80, 0x40]) / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    assert np.allclose(material["pbrMetallicRoughness"]["baseColorFactor"], [*linear, 0.5], atol=1e-4)
    assert material["alphaMode"] == "BLEND"


def test_a_place_that_cannot_be_written_to_is_named(tmp_path):
    (tmp_path / "file").write_text("in the way")
    scene = realize(derive(Grammar.parse("Lot --> extrude(3)"), 1, 1))
    with pytest.raises(GrammarlabError, match=r"model\.glb"):
        save(scene, tmp_path / "file" / "model.glb")
