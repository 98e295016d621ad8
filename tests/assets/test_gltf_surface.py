"""Normals, texture coordinates, materials and images of glTF files."""

from __future__ import annotations

import json

import numpy as np
import pytest

from grammarlab.assets.gltf_scene import read_gltf
from grammarlab.assets.gltf_surface import image_inside
from grammarlab.assets.image_paths import image_beside
from grammarlab.assets.mesh_files import load_asset, without_neighbours
from grammarlab.assets.mtl_reader import read_mtl
from grammarlab.errors import AssetError
from tests.assets.documents import SQUARE, SQUARE_TRIANGLES, Document, rich_document


def test_corners_have_the_normals_and_coordinates_of_their_points_at_all_places() -> None:
    document = rich_document()
    part = read_gltf(document.gltf(), without_neighbours, 10**6)[0]
    # The node above stretches by 2, 2, -2; three instances stand at (0, 1, 2), (3, 4, 5) and (6, 7, 8).
    assert len(part.corners) == 3 * 36
    own = part.points[part.corners] / [2, 2, -2] - np.repeat([[0, 1, 2], [3, 4, 5], [6, 7, 8]], 36, axis=0)
    assert part.normals is not None
    expected = (2.0 * own - 1.0) * [1, 1, -1]
    np.testing.assert_allclose(part.normals / np.abs(part.normals), expected, atol=1e-6)
    image, other = part.coordinates
    np.testing.assert_allclose(other, own[:, :2] * (1, -1) + (0, 1), atol=1e-4)
    turn = np.array([[np.cos(0.5), np.sin(0.5)], [-np.sin(0.5), np.cos(0.5)]])
    downwards = (own[:, 1:] * (2, 4)) @ turn.T + (0.5, 0.25)
    np.testing.assert_allclose(image, downwards * (1, -1) + (0, 1), atol=1e-4)


def test_a_material_is_what_the_file_says(tmp_path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "rich.glb").write_bytes(rich_document().glb())
    material = load_asset("parts/rich.glb", tmp_path).materials[0]
    assert material is not None
    assert material.texture == "parts/rich.glb#image0"
    assert material.color == pytest.approx((1.0, 0.737, 0.0, 1.0), abs=2e-3)  # sRGB of linear 1, 0.5, 0
    assert material.emissive == pytest.approx((0.0, 0.737, 1.0), abs=2e-3)
    assert (material.metallic, material.roughness) == (1.0, 0.25)


def test_an_image_inside_a_file_is_read_and_others_are_not() -> None:
    for content in (rich_document().glb(), rich_document().gltf()):
        assert image_inside(content, 0) == b"picture"
        with pytest.raises(AssetError, match="no image 7"):
            image_inside(content, 7)
    with pytest.raises(AssetError):
        image_inside(b"{}", 0)
    within = {"asset": {"version": "2.0"}, "images": [{"uri": "data:image/png;base64,cGljdHVyZQ=="}]}
    assert image_inside(json.dumps(within).encode(), 0) == b"picture"
    beside = {"asset": {"version": "2.0"}, "images": [{"uri": "../secret.png"}]}
    with pytest.raises(AssetError):
        image_inside(json.dumps(beside).encode(), 0)


@pytest.mark.parametrize(
    "change",
    [
        {"textures": [{"source": 99}]},
        {"textures": []},
        {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": -1}}}]},
        {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": 7}}]},
        {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "roughnessFactor": "x"}}]},
    ],
)
def test_broken_materials_are_refused_or_plain_and_never_end_badly(change) -> None:
    document = Document()
    mesh = document.mesh(SQUARE, SQUARE_TRIANGLES, material=0)
    document.add("materials", {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})
    document.add("textures", {"source": 0})
    document.add("images", {"uri": "a.png"})
    document.show(document.add("nodes", {"mesh": mesh}))
    document.json |= change
    try:
        (part,) = read_gltf(document.gltf(), without_neighbours, 10**6)
    except AssetError:
        return
    assert len(part.triangles) == 2


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("brick.png", "parts/brick.png"),
        ("BRICK.PNG", "parts/brick.png"),
        (r"C:\\old\\place\\Brick.png", "parts/brick.png"),
        ("/etc/brick.png", "parts/brick.png"),
        ("../brick.png", "parts/brick.png"),
        ("Maps/stone.png", "parts/maps/stone.png"),
        (r"maps\\stone.png", "parts/maps/stone.png"),
        ("./maps/./stone.png", "parts/maps/stone.png"),
        ("../secret.png", "parts/secret.png"),
        ("maps/../../secret.png", "parts/secret.png"),
        ("link.png", "parts/link.png"),
        ("none.png", "parts/none.png"),
        ("\0", "parts/\0"),
        ("", ""),
        ("..", "parts/.."),
    ],
)
def test_images_are_found_beside_the_file_only(tmp_path, name, found) -> None:
    (tmp_path / "parts" / "maps").mkdir(parents=True)
    for path in ("parts/brick.png", "parts/maps/stone.png", "secret.png"):
        (tmp_path / path).write_bytes(b"")
    (tmp_path / "parts" / "link.png").symlink_to(tmp_path / "secret.png")
    assert image_beside(name.replace("\\\\", "\\"), (tmp_path / "parts").relative_to(tmp_path), tmp_path) == found


@pytest.mark.parametrize(
    ("text", "texture", "color"),
    [
        (b"Kd 1 0 0\nmap_Kd a b.png", "a b.png", (1.0, 0.0, 0.0, 1.0)),
        (b"map_Kd -clamp on -s 1 2 -o 0.5 0 0 -bm 2 a.png\nTr 0.6", "a.png", (1.0, 1.0, 1.0, 0.4)),
        (b"map_Kd -s 1 2 3 4.png", "4.png", (1.0, 1.0, 1.0, 1.0)),
        (b"kd 0 0 1\nD 0.2\nmap_kd -unknown 3 a.png", "-unknown 3 a.png", (0.0, 0.0, 1.0, 0.2)),
        (b"Kd 1 1 1\nTr 1.000000", "", (1.0, 1.0, 1.0, 1.0)),
        (b"Kd x y z\nd nan\nmap_Kd", None, None),
        (b"Kd 1 1", None, None),
    ],
)
def test_materials_of_obj_files(text, texture, color) -> None:
    material = read_mtl(b"newmtl one\n" + text)[b"one"]
    assert (material and material.texture, material and material.color) == (texture, color)
