"""What is written is what is read back, by another library."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from grammarlab.assets.meshes import AssetFolder
from grammarlab.derivation import derive
from grammarlab.errors import GrammarlabError
from grammarlab.export import SaveOptions, save
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from grammarlab.scene import realize, triangles

GRAMMARS = Path(__file__).parents[2] / "grammars"
ASSETS = AssetFolder(GRAMMARS / "assets")


def scene_of(name: str):
    return realize(derive(load(GRAMMARS / f"{name}.cga"), 1, 5, assets=ASSETS))


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
