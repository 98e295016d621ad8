"""Texture coordinates and materials of assets on derived shapes, in files and after every operation."""

import json
import struct

import numpy as np
import pytest
from PIL import Image

from grammarlab.derivation import derive
from grammarlab.derivation.selection import join_forests
from grammarlab.export import SaveOptions, save
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.contact_sheet import render
from grammarlab.runs.sample.derivations import load_forest, save_forest
from grammarlab.scene import realize, triangles
from grammarlab.scene.scene_pictures import with_pictures
from grammarlab.scene.triangles import texture_coordinates

WALL = """mtllib wall.mtl
v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 4 0 0.5\nv 4 1 0.5
vt 0.2 0.1\nvt 0.6 0.1\nvt 0.6 0.9\nvt 0.2 0.9\nvt 1 0.1\nvt 1 0.9
vn 0 0 1\nvn 0.6 0 0.8
usemtl brick
f 1/1/1 2/2/1 3/3/1 4/4/1
usemtl glass
f 2/2/1 5/5/2 6/6/2 3/3/1
"""
"""Two rectangles, 2 m wide and 1 m high; u is (x + 1) / 5, v is (8 y + 1) / 10; two normals are not those of a face."""
LIBRARY = r"""newmtl brick
Kd 1 1 1
map_Kd -s 1 1 1 C:\old place\Brick.PNG
newmtl glass
Kd 0 0 1
d 0.4
"""


@pytest.fixture
def assets(tmp_path):
    folder = tmp_path / "assets" / "parts"
    folder.mkdir(parents=True)
    (folder / "wall.obj").write_text(WALL)
    (folder / "wall.mtl").write_text(LIBRARY)
    Image.new("RGB", (4, 4), (200, 100, 50)).save(folder / "brick.png")
    return tmp_path / "assets"


def scene_of(rules, assets):
    grammar = Grammar.parse(f'Lot --> s(4, 1, 0) i("parts/wall.obj") {rules}')
    return realize(derive(grammar, 1, 1, assets=assets))


def corners_of(scene, texture="parts/brick.png"):
    """Places and coordinates (v upwards) of the corners of all triangles with a texture."""
    batch = triangles(scene)
    chosen = np.array(scene.materials.textures)[batch.material_of_triangle()] == texture
    coordinates = texture_coordinates(batch, slice(0, len(batch.triangles)))[chosen] * (1.0, -1.0) + (0.0, 1.0)
    return batch.vertices[batch.triangles[chosen]].reshape(-1, 3), coordinates.reshape(-1, 2)


def uv_area(coordinates):
    """Area of triangles in texture space."""
    corners = coordinates.reshape(-1, 3, 2)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum() / 2.0


def test_each_material_of_an_asset_is_a_leaf_with_its_own_coordinates(assets):
    scene = scene_of("A", assets)
    shown = [(scene.materials.textures[m], *scene.materials.channels[m, :4].tolist()) for m in scene.material]
    assert sorted(shown) == [("", 0.0, 0.0, 1.0, 0.4), ("parts/brick.png", 1.0, 1.0, 1.0, 1.0)]
    places, coordinates = corners_of(scene)
    np.testing.assert_allclose(coordinates, np.stack([u_of(places[:, 0]), 0.8 * places[:, 1] + 0.1], axis=1), atol=1e-6)
    batch = triangles(scene)
    normals = np.unique(np.round(batch.normals, 5), axis=0)
    np.testing.assert_allclose(normals, [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]], atol=1e-5)


def u_of(x):
    return 0.2 * x + 0.2


@pytest.mark.parametrize(
    ("rules", "u", "v"),
    [
        ("split(x) { 1.5 : A | ~1 : A }", u_of, lambda y: 0.8 * y + 0.1),
        ("comp(f) { all : A }", u_of, lambda y: 0.8 * y + 0.1),
        ("comp(f) { all : split(x) { ~1 : A | ~1 : t(0, 0, 2) A } }", u_of, lambda y: 0.8 * y + 0.1),
        ("comp(f) { all = s('1, '2, '1) A }", u_of, lambda y: 0.4 * y + 0.1),
        ("mirror(true, false, false)", lambda x: u_of(4.0 - x), lambda y: 0.8 * y + 0.1),
        ("translateUV(0, 0.5, 0) scaleUV(0, 2, 1) A", lambda x: 2 * u_of(x) + 1.0, lambda y: 0.8 * y + 0.1),
        ("tileUV(0, '0.5, '0.25) A", lambda x: 0.5 * x, lambda y: 4.0 * y),
        ("normalizeUV(0, uv, collectiveAllFaces) A", lambda x: 0.25 * x, lambda y: y),
        ("split(x) { ~1 : rotateUV(0, 0) A | ~1 : A }", u_of, lambda y: 0.8 * y + 0.1),
        ("copyUV(0, 3) translateUV(0, 7, 7) copyUV(3, 0) A", u_of, lambda y: 0.8 * y + 0.1),
        ("setupProjection(0, scope.xy, 2, 2) projectUV(0) A", lambda x: 0.5 * x, lambda y: 0.5 * y + 1.0),
        ("split(u, uvSpace, 0) { 0.3 : A | ~1 : A }", u_of, lambda y: 0.8 * y + 0.1),
    ],
)
def test_coordinates_go_with_the_surface(assets, rules, u, v):
    places, coordinates = corners_of(scene_of(rules, assets))
    assert len(places)
    expected = np.stack([u(places[:, 0]), v(places[:, 1])], axis=1)
    np.testing.assert_allclose(coordinates, expected, atol=1e-6)


def test_a_color_after_the_asset_is_on_all_of_its_materials_and_one_before_it_on_none(assets):
    scene = scene_of('color("#ff0000") A', assets)
    assert {tuple(scene.materials.color[m]) for m in scene.material} == {(1.0, 0.0, 0.0)}
    assert {scene.materials.textures[m] for m in scene.material} == {"", "parts/brick.png"}
    grammar = Grammar.parse('Lot --> color("#ff0000") s(4, 1, 0) i("parts/wall.obj:notex") A')
    scene = realize(derive(grammar, 1, 1, assets=assets))
    assert {tuple(scene.materials.color[m]) for m in scene.material} == {(1.0, 1.0, 1.0), (0.0, 0.0, 1.0)}
    assert {scene.materials.textures[m] for m in scene.material} == {""}


def test_without_coordinates_an_image_is_projected_and_set_1_does_not_matter(assets):
    deleted = corners_of(scene_of("deleteUV(0) A", assets))[1]
    assert np.ptp(deleted[:, 0]) == pytest.approx(2.0)
    (other,) = {tuple(map(tuple, corners_of(scene_of(rules, assets))[1])) for rules in ("A", "deleteUV(1) A")}
    assert other


def test_files_have_the_coordinates_and_the_image(assets, tmp_path):
    scene = scene_of("split(x) { 1.5 : A | ~1 : A }", assets)
    save(scene, tmp_path / "m.glb", options=SaveOptions(assets=assets))
    content = (tmp_path / "m.glb").read_bytes()
    document = json.loads(content[20 : 20 + struct.unpack_from("<I", content, 12)[0]])
    assert len(document["images"]) == 1
    save(scene, tmp_path / "m.obj", options=SaveOptions(assets=assets))
    lines = [line.split() for line in (tmp_path / "m.obj").read_text().splitlines()]
    coordinates = np.array([line[1:3] for line in lines if line[0] == "vt"], float)
    assert sorted(set(np.round(coordinates[:, 0], 6).tolist())) == [0.2, 0.5, 0.6]
    assert len(list(tmp_path.glob("m_texture_*.png"))) == 1


def test_a_stored_forest_has_the_values_of_corners(assets, tmp_path):
    grammar = Grammar.parse('Lot --> s(4, 1, 0) i("parts/wall.obj") split(x) { 1.5 : A | ~1 : A }')
    forest = derive(grammar, 2, 1, assets=assets)
    save_forest(forest, tmp_path / "forest")
    stored = load_forest(tmp_path / "forest").meshes.data
    made = forest.meshes.data
    assert stored is not None
    assert made is not None
    np.testing.assert_array_equal(stored.values, made.values)
    np.testing.assert_array_equal(stored.slots, made.slots)


def test_pictures_show_images_and_colours_in_place_of_unusable_ones(assets):
    scene = scene_of('setupProjection(0, scope.xy, 1, 1) projectUV(0) texture("parts/brick.png") A', assets)
    plain, shown = (np.asarray(render(scene, pixels=48, assets=folder), float) for folder in (None, assets))
    redder = (shown[:, :, 0] - shown[:, :, 2]) - (plain[:, :, 0] - plain[:, :, 2])
    assert redder.max() > 60.0
    (assets / "parts" / "brick.png").write_bytes(b"\x89PNG\r\n\x1a\nnot an image")
    assert with_pictures(scene, assets).materials.pictures == {}


@pytest.mark.parametrize(
    ("rules", "num_faces"),
    [
        ("primitiveCube() A", 6),
        ("primitiveQuad() A", 1),
        ('i("builtin:cube") A', 6),
        ("primitiveCube() comp(f) { side : t(0, 0, 1) A }", 4),
        ("primitiveCube() tileUV(0, '0.5, '1) A", 12),
        ("primitiveCube() translateUV(0, 3, 1) scaleUV(0, 2, 0.5) A", 6),
    ],
)
def test_an_image_is_once_on_each_face_of_a_cube_and_of_a_quad(assets, rules, num_faces):
    grammar = Grammar.parse(f'Lot --> s(3, 2, 1) projectUV(0) texture("parts/brick.png") {rules}')
    _, coordinates = corners_of(realize(derive(grammar, 1, 1, assets=assets)))
    assert uv_area(coordinates) == pytest.approx(num_faces)


def test_a_cut_cube_has_no_coordinates_of_whole_faces(assets):
    grammar = Grammar.parse(
        'Lot --> s(4, 2, 3) projectUV(0) primitiveCube() texture("parts/brick.png") split(x) { ~1 : A | ~1 : NIL }'
    )
    _, coordinates = corners_of(realize(derive(grammar, 1, 1, assets=assets)))
    assert uv_area(coordinates) == pytest.approx(2 * (2 * 2 + 2 * 3 + 2 * 3))


def test_transparent_parts_of_an_image_are_holes_where_the_file_says_so(assets, tmp_path):
    wall = assets / "parts" / "wall.mtl"
    wall.write_text(wall.read_text().replace("newmtl glass", "map_d Brick.PNG\nnewmtl glass"))
    grammar = Grammar.parse('Lot --> i("parts/wall.obj") A')
    forest = derive(grammar, 1, 1, assets=assets)
    save_forest(join_forests([forest, forest]), tmp_path / "forest")
    for each in (forest, load_forest(tmp_path / "forest")):
        assert realize(each).materials.cut_out == {"parts/brick.png"}
    path = save(realize(forest), tmp_path / "m.glb", options=SaveOptions(assets=assets))
    document = json.loads(path.read_bytes()[20 : 20 + struct.unpack_from("<I", path.read_bytes(), 12)[0]])
    assert {material.get("alphaMode") for material in document["materials"]} == {"MASK", "BLEND"}
