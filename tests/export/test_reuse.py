"""Files with shared meshes show the same world as merged files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import KDTree

from grammarlab.export import SaveOptions, save, save_each
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.scene import Scene
from tests.export.gltf import INSTANCING, Glb, Surface, node_matrices, read_glb, world
from tests.scene.buildings import STONE, TILE, house, materials, scene_of, street

WAYS = ("nodes", "instancing")
PLACES = ("model", "material", "position", "size", "frame", "texture_map")


def textured(folder: Path) -> tuple[Scene, Path]:
    """A street whose walls and roofs carry images, and the asset folder."""
    folder.mkdir()
    Image.new("RGB", (8, 8), (200, 100, 50)).save(folder / "wall.png")
    Image.new("RGB", (4, 16), (90, 90, 160)).save(folder / "roof.jpg")
    names = [""] * 6
    names[STONE], names[TILE] = "wall.png", "roof.jpg"
    scene, rng = street(), np.random.default_rng(1)
    return replace(
        scene,
        materials=replace(scene.materials, textures=tuple(names)),
        texture_map=rng.integers(-1, 4, len(scene)).astype(np.int32),
        texture_maps=rng.normal(0, 1, (4, 2, 4)),
    ), folder


def written(scene: Scene, path: Path, **options) -> Glb:
    return read_glb(save(scene, path, options=SaveOptions(**options)))


def rows_of(surface: Surface, material: str) -> np.ndarray:
    """[T, 24] all numbers of each triangle in a material."""
    numbers = np.concatenate([surface.corners, surface.normals, np.nan_to_num(surface.coordinates, nan=-99.0)], axis=2)
    return numbers[surface.materials == material].reshape(-1, 24)


def assert_same(one: Surface, other: Surface) -> None:
    """The same triangles in the same materials, corner by corner, whatever their order."""
    assert sorted(one.materials) == sorted(other.materials)
    for name in np.unique(one.materials):
        distance, nearest = KDTree(rows_of(other, name)).query(rows_of(one, name))
        assert distance.max() < 1e-3
        assert np.unique(nearest).size == len(rows_of(one, name))


@pytest.mark.parametrize("reuse", WAYS)
def test_shared_meshes_show_the_same_triangles_as_merged(tmp_path, reuse):
    merged = world(written(street(), tmp_path / "merged.glb"))
    assert_same(world(written(street(), tmp_path / "shared.glb", reuse=reuse)), merged)


@pytest.mark.parametrize("reuse", WAYS)
def test_textures_lie_the_same_on_shared_meshes_as_on_merged(tmp_path, reuse):
    scene, assets = textured(tmp_path / "assets")
    merged = world(written(scene, tmp_path / "merged.glb", assets=assets))
    assert np.isfinite(merged.coordinates).any()
    assert np.isnan(merged.coordinates).any()
    assert_same(world(written(scene, tmp_path / "shared.glb", reuse=reuse, assets=assets)), merged)


@pytest.mark.parametrize("reuse", ["merged", *WAYS])
def test_no_place_mirrors_its_mesh(tmp_path, reuse):
    glb = written(street(), tmp_path / "model.glb", reuse=reuse)
    places = np.concatenate([node_matrices(glb, node) for node in glb.document["nodes"]])
    assert (np.linalg.det(places[:, :3, :3]) > 0).all()


def test_each_mesh_and_material_is_written_once(tmp_path):
    scene = street()
    glb = written(scene, tmp_path / "model.glb", reuse="nodes")
    pairs = set(zip(scene.mesh.tolist(), scene.material.tolist(), strict=True))
    assert len(glb.document["meshes"]) == len(pairs)
    geometries = {
        primitive["attributes"]["POSITION"] for mesh in glb.document["meshes"] for primitive in mesh["primitives"]
    }
    assert len(geometries) == len(set(scene.mesh.tolist()))
    assert sum("mesh" in node for node in glb.document["nodes"]) == len(scene)


def test_gpu_instancing_is_used_required_and_has_a_place_for_each_shape(tmp_path):
    scene = street()
    glb = written(scene, tmp_path / "model.glb", reuse="instancing")
    assert glb.document["extensionsUsed"] == glb.document["extensionsRequired"] == [INSTANCING]
    nodes = [node for node in glb.document["nodes"] if INSTANCING in node.get("extensions", {})]
    assert sum(len(node_matrices(glb, node)) for node in nodes) == len(scene)


@pytest.mark.parametrize("reuse", ["merged", "nodes"])
def test_files_without_instancing_need_no_extension(tmp_path, reuse):
    document = written(street(), tmp_path / "model.glb", reuse=reuse).document
    assert "extensionsUsed" not in document
    assert "extensionsRequired" not in document


@pytest.mark.parametrize("reuse", ["merged", *WAYS])
def test_a_model_in_its_own_file_is_the_model_saved_alone(tmp_path, reuse):
    options = SaveOptions(reuse=reuse)
    paths = save_each(street(), tmp_path / "each", options=options)
    widths = (house(), house(7.5, 3), house(15.0, 4))
    for path, rows in zip(paths, widths, strict=True):
        alone = save(scene_of([rows]), tmp_path / "alone" / path.name, options=options)
        assert_same(world(read_glb(path)), world(read_glb(alone)))


@pytest.mark.parametrize("reuse", ["merged", *WAYS])
def test_a_mesh_without_faces_takes_no_room(tmp_path, reuse):
    nothing = Meshes.single(np.zeros((0, 3)), [])
    scene = scene_of([house()])
    with_nothing = replace(
        scene,
        meshes=Meshes.concatenate([scene.meshes, nothing]),
        mesh=np.append(scene.mesh, np.int32(len(scene.meshes))),
        **{name: np.append(getattr(scene, name), getattr(scene, name)[:1], axis=0) for name in PLACES},
    )
    expected = world(written(scene, tmp_path / "without.glb", reuse=reuse))
    assert_same(world(written(with_nothing, tmp_path / "with.glb", reuse=reuse)), expected)


@pytest.mark.parametrize("reuse", ["merged", *WAYS])
def test_a_model_of_nothing_is_a_node_without_a_mesh(tmp_path, reuse):
    glb = written(scene_of([[], house()], materials()), tmp_path / "model.glb", reuse=reuse)
    empty = glb.document["nodes"][glb.document["scenes"][0]["nodes"][0]]
    assert "mesh" not in empty
    assert "children" not in empty
