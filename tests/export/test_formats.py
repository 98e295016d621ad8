"""GLB, OBJ and PLY files read back with trimesh."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual import ColorVisuals
from trimesh.visual.material import SimpleMaterial

from grammarlab.assets.srgb import linear_from_srgb, srgb_from_linear
from grammarlab.export import SaveOptions, save, save_each
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.triangulate import triangulate
from grammarlab.scene import Scene, triangles
from grammarlab.scene.layout import grid, model_bounds
from tests.export.gltf import MESH_FORMATS, read_glb, world
from tests.scene import brute_force
from tests.scene.buildings import GLASS, LAMP, STEEL, house, materials, scene_of, street


def read(path: Path) -> trimesh.Trimesh:
    return trimesh.load_scene(path, process=False).to_mesh()


def text_of(path: Path, keyword: str) -> np.ndarray:
    """The numbers behind a keyword of an OBJ."""
    lines = [line.split()[1:] for line in path.read_text().splitlines() if line.split()[:1] == [keyword]]
    return np.array(lines, dtype=float)


def material_of(scene: Scene, name: str) -> int:
    """The material of a scene whose sRGB colour a name ends with; it is the only one of that colour."""
    colors = np.rint(scene.materials.color * 255).astype(int)
    (row,) = np.flatnonzero((colors == [int(name[-6:][k : k + 2], 16) for k in (0, 2, 4)]).all(axis=1))
    return int(row)


@pytest.mark.parametrize("suffix", MESH_FORMATS)
def test_a_file_has_the_area_the_bounds_and_the_volume_of_its_scene(tmp_path, suffix):
    scene = scene_of([house()])
    mesh = read(save(scene, tmp_path / f"house.{suffix}"))
    assert len(mesh.faces) == len(triangles(scene).triangles)
    assert mesh.area == pytest.approx(sum(brute_force.areas(scene).values()), rel=1e-5)
    assert np.allclose(mesh.bounds, brute_force.bounds(scene, 0), atol=1e-4)


@pytest.mark.parametrize("suffix", MESH_FORMATS)
def test_every_file_holds_the_same_triangles_in_the_same_order(tmp_path, suffix):
    scene = street()
    batch = triangles(scene)
    owner = np.repeat(np.arange(3), batch.triangles_per_model())
    corners = batch.vertices[batch.triangles] + grid(*model_bounds(batch), batch.origins).offsets[owner][:, None, :]
    path = save(scene, tmp_path / f"street.{suffix}")
    if suffix == "glb":
        found = world(read_glb(path)).corners
    elif suffix == "obj":
        faces = [line.split()[1:] for line in path.read_text().splitlines() if line.startswith("f ")]
        polygons = text_of(path, "v")[[int(word.split("/")[0]) - 1 for face in faces for word in face]]
        assert max(map(len, faces)) > 3
        found = polygons[triangulate(Meshes.from_polygons(polygons, np.array(list(map(len, faces)))))[0]]
    else:
        found = read(path).triangles
    assert np.allclose(found, corners, atol=1e-4)


@pytest.mark.parametrize("suffix", MESH_FORMATS)
def test_normals_are_on_the_side_that_triangles_face(tmp_path, suffix):
    mesh = read(save(scene_of([house()]), tmp_path / f"house.{suffix}"))
    corner_normals = mesh.vertex_normals[mesh.faces]
    assert (np.einsum("tcj,tj->tc", corner_normals, mesh.face_normals) > 0.8).all()


@pytest.mark.parametrize("suffix", MESH_FORMATS)
def test_models_in_one_file_do_not_touch(tmp_path, suffix):
    batch = triangles(street())
    low, high = model_bounds(batch)
    shift = grid(low, high, batch.origins).offsets
    low, high = low + shift, high + shift
    for one, other in ((0, 1), (0, 2), (1, 2)):
        apart = (low[one] > high[other]) | (low[other] > high[one])
        assert apart[[0, 2]].any()
    mesh = read(save(street(), tmp_path / f"street.{suffix}"))
    assert np.allclose(mesh.bounds, [low.min(axis=0), high.max(axis=0)], atol=1e-4)


def test_columns_set_how_many_models_stand_side_by_side(tmp_path):
    save(street(), tmp_path / "row.glb", options=SaveOptions(columns=3))
    save(street(), tmp_path / "file.glb", options=SaveOptions(columns=1))
    row, file = read(tmp_path / "row.glb").extents, read(tmp_path / "file.glb").extents
    assert row[0] > file[0]
    assert row[2] < file[2]


def test_glb_materials_are_those_of_the_scene_in_linear_light(tmp_path):
    scene = street()
    document = read_glb(save(scene, tmp_path / "street.glb")).document
    found = {material_of(scene, entry["name"]): entry for entry in document["materials"]}
    assert sorted(found) == sorted(set(scene.material.tolist()))
    table = scene.materials
    for index, entry in found.items():
        surface = entry["pbrMetallicRoughness"]
        color = [1.055 * c ** (1 / 2.4) - 0.055 if c > 0.0031308 else 12.92 * c for c in surface["baseColorFactor"][:3]]
        assert color == pytest.approx(table.color[index].tolist(), abs=1e-9)
        assert surface["baseColorFactor"][3] == table.opacity[index]
        assert surface["metallicFactor"] == table.metallic[index]
        assert surface["roughnessFactor"] == table.roughness[index]
    assert found[GLASS]["alphaMode"] == "BLEND"
    assert [index for index, entry in found.items() if "alphaMode" in entry] == [GLASS]
    assert [index for index, entry in found.items() if "emissiveFactor" in entry] == [LAMP]
    assert found[STEEL]["pbrMetallicRoughness"]["metallicFactor"] == 1.0


def test_each_triangle_of_a_glb_has_the_material_of_its_shape(tmp_path):
    scene = street()
    surface = world(read_glb(save(scene, tmp_path / "street.glb")))
    edges = surface.corners[:, 1:] - surface.corners[:, :1]
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    expected = np.zeros(len(scene.materials))
    for (_, material), area in brute_force.areas(scene).items():
        expected[material] += area
    index = np.array([material_of(scene, name) for name in surface.materials])
    assert np.allclose(np.bincount(index, areas), expected, rtol=1e-4)


def test_obj_materials_are_read_back(tmp_path):
    scene = scene_of([house()])
    loaded = trimesh.load_scene(save(scene, tmp_path / "house.obj"), process=False, group_material=True)
    areas = brute_force.areas(scene)
    assert len(loaded.geometry) == len(areas)
    for mesh in loaded.geometry.values():
        material = mesh.visual.material
        assert isinstance(material, SimpleMaterial)
        index = material_of(scene, material.name)
        assert np.allclose(material.diffuse[:3] / 255, scene.materials.color[index], atol=1 / 255)
        assert float(material.kwargs["d"][0]) == pytest.approx(scene.materials.opacity[index])
        assert mesh.area == pytest.approx(areas[0, index], rel=1e-5)


def test_ply_colours_are_those_of_the_shapes(tmp_path):
    scene = scene_of([house()])
    mesh = read(save(scene, tmp_path / "house.ply"))
    assert isinstance(mesh.visual, ColorVisuals)
    colors = mesh.visual.vertex_colors[mesh.faces[:, 0]]
    table = np.rint(scene.materials.channels[:, :4] * 255).astype(np.uint8)
    assert np.array_equal(colors, table[triangles(scene).material_of_triangle()])


def test_positions_in_an_obj_are_exact(tmp_path):
    scene = scene_of([house()])
    path = save(scene, tmp_path / "house.obj")
    assert np.array_equal(text_of(path, "v").astype(np.float32), triangles(scene).vertices)
    assert np.array_equal(text_of(path, "vn").astype(np.float32), triangles(scene).normals)


@pytest.mark.parametrize("suffix", MESH_FORMATS)
def test_names_with_spaces_and_accents_are_kept(tmp_path, suffix):
    scene = scene_of([house()])
    paths = save_each(scene, tmp_path / "Häuser am See", suffix, name="Haus Nº {}".format, first_model=7)
    assert [path.name for path in paths] == [f"Haus Nº 7.{suffix}"]
    assert read(paths[0]).area == pytest.approx(sum(brute_force.areas(scene).values()), rel=1e-5)


def textured(folder: Path) -> tuple[Scene, SaveOptions]:
    folder.mkdir()
    Image.new("RGB", (8, 4), (200, 100, 50)).save(folder / "wall.png")
    table = materials()
    scene = scene_of([house()], replace(table, textures=("wall.png", *table.textures[1:])))
    return scene, SaveOptions(assets=folder)


@pytest.mark.parametrize("suffix", ["glb", "obj"])
def test_a_texture_travels_with_its_file(tmp_path, suffix):
    scene, options = textured(tmp_path / "assets")
    path = save(scene, tmp_path / "out" / f"house.{suffix}", options=options)
    (tmp_path / "assets").rename(tmp_path / "gone")
    loaded = trimesh.load_scene(path, process=False, group_material=True)
    images = []
    for mesh in loaded.geometry.values():
        material = mesh.visual.material
        image = material.image if isinstance(material, SimpleMaterial) else material.baseColorTexture
        if image is not None and material.name == "wall":
            images.append(image)
    assert [image.size for image in images] == [(8, 4)]
    assert images[0].convert("RGB").getpixel((3, 2)) == (200, 100, 50)


def test_texture_coordinates_are_metres_and_never_mirrored(tmp_path):
    scene, options = textured(tmp_path / "assets")
    surface = world(read_glb(save(scene, tmp_path / "house.glb", options=options)))
    with_texture = np.isfinite(surface.coordinates[:, 0, 0])
    assert with_texture.any()
    corners, coordinates = surface.corners[with_texture], surface.coordinates[with_texture]
    edges = corners[:, 1:] - corners[:, :1]
    spans = coordinates[:, 1:] - coordinates[:, :1]
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    # v points down in glTF: counter-clockwise triangles turn clockwise in (u, v).
    turn = -(spans[:, 0, 0] * spans[:, 1, 1] - spans[:, 0, 1] * spans[:, 1, 0])
    assert turn == pytest.approx(area, rel=1e-3)


def test_light_and_srgb_are_each_others_inverse():
    values = np.linspace(0, 1, 1001)
    assert np.allclose(srgb_from_linear(linear_from_srgb(values)), values, atol=1e-6)
    assert (np.diff(linear_from_srgb(values)) > 0).all()
