import base64
import json
import os
import struct

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from trimesh.exchange.gltf import export_gltf

from grammarlab.assets import mesh_files as assets
from grammarlab.assets.mesh_files import AssetFolder, load_asset
from grammarlab.errors import AssetError
from grammarlab.geometry.meshes.measure import is_closed, volumes
from grammarlab.geometry.meshes.primitives import cone
from grammarlab.geometry.meshes.triangulate import triangulate

QUICK = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)
STRETCH, SHIFT = np.array([2.0, 3.0, 4.0]), np.array([10.0, -1.0, 5.0])


def cone_mesh():
    return trimesh.Trimesh(cone().points * STRETCH + SHIFT, triangulate(cone())[0], process=False)


def triangle_gltf(**changes):
    """A glTF of one triangle with its buffer inside, with parts replaced."""
    data = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0]], np.float32).tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "buffers": [
            {
                "byteLength": len(data),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
            }
        ],
    }
    return json.dumps({**document, **changes})


@pytest.mark.parametrize("suffix", ["obj", "glb", "gltf"])
def test_meshes_come_back_in_the_unit_cube_with_their_size_kept(tmp_path, suffix):
    if suffix == "gltf":
        for name, content in export_gltf(trimesh.Scene(cone_mesh())).items():
            (tmp_path / name.replace("model.gltf", "cone.gltf")).write_bytes(content)
    else:
        cone_mesh().export(tmp_path / f"cone.{suffix}")
    asset = load_asset(f"cone.{suffix}", tmp_path)
    assert asset.low == pytest.approx(SHIFT, abs=1e-5)
    assert asset.size == pytest.approx(STRETCH, abs=1e-5)
    low, high = asset.meshes.bounds()
    assert low == pytest.approx(0.0)
    assert high == pytest.approx(1.0)
    assert is_closed(asset.meshes)[0]
    assert volumes(asset.meshes)[0] == pytest.approx(volumes(cone())[0], rel=1e-5)


def test_groups_are_merged_and_nodes_placed(tmp_path):
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box())
    scene.add_geometry(trimesh.creation.box(), transform=trimesh.transformations.translation_matrix([9.0, 0.0, 0.0]))
    scene.export(tmp_path / "boxes.glb")
    asset = load_asset("boxes.glb", tmp_path)
    assert len(asset.meshes) == 1
    assert asset.size.tolist() == [10.0, 1.0, 1.0]


def test_a_flat_mesh_stays_flat(tmp_path):
    (tmp_path / "flat.obj").write_text("v 0 1 0\nv 2 1 0\nv 2 1 3\nv 0 1 3\nf 1 2 3 4\n")
    asset = load_asset("flat.obj", tmp_path)
    assert asset.size.tolist() == [2.0, 0.0, 3.0]
    assert set(asset.meshes.points[:, 1]) == {0.0}


def test_a_folder_reads_each_file_once(tmp_path):
    cone_mesh().export(tmp_path / "cone.obj")
    folder = AssetFolder(tmp_path)
    first = folder.load("cone.obj")
    (tmp_path / "cone.obj").unlink()
    assert folder.load("cone.obj") is first


@pytest.mark.parametrize("path", ["../secret.obj", "sub/../../secret.obj", "link.obj", "linked/secret.obj"])
def test_nothing_outside_the_folder_is_read(tmp_path, path):
    cone_mesh().export(tmp_path / "secret.obj")
    root = tmp_path / "root"
    (root / "sub").mkdir(parents=True)
    (root / "link.obj").symlink_to(tmp_path / "secret.obj")
    (root / "linked").symlink_to(tmp_path)
    with pytest.raises(AssetError, match="outside"):
        load_asset(path, root)


@pytest.mark.parametrize("uri", ["../data.bin", "..%2Fdata.bin", "/data.bin", "link.bin"])
def test_a_gltf_cannot_refer_to_files_outside(tmp_path, uri):
    root = tmp_path / "root"
    root.mkdir()
    (tmp_path / "data.bin").write_bytes(np.eye(3, dtype=np.float32).tobytes())
    (root / "link.bin").symlink_to(tmp_path / "data.bin")
    (root / "evil.gltf").write_text(triangle_gltf(buffers=[{"byteLength": 36, "uri": uri}]))
    with pytest.raises(AssetError, match=r"outside|there is no asset"):
        load_asset("evil.gltf", root)


def test_a_gltf_may_refer_to_files_beside_it_in_the_folder(tmp_path):
    (tmp_path / "deep").mkdir()
    (tmp_path / "shared data.bin").write_bytes(np.eye(3, dtype=np.float32).tobytes())
    uri = "../shared%20data.bin"
    (tmp_path / "deep" / "good.gltf").write_text(triangle_gltf(buffers=[{"byteLength": 36, "uri": uri}]))
    assert load_asset("deep/good.gltf", tmp_path).meshes.num_faces == 1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"accessors": [{"componentType": 5126, "count": 10**12, "type": "VEC3"}]}, "at most"),
        ({"accessors": [{"componentType": 5126, "count": -1, "type": "VEC3"}]}, "count .* -1"),
        ({"accessors": [{"componentType": 5126, "count": "3", "type": "VEC3"}]}, "count .* '3'"),
        (
            {
                "nodes": [{"mesh": 0}] * 10,
                "scenes": [{"nodes": list(range(10))}],
                "accessors": [{"componentType": 5126, "count": 10**6, "type": "VEC3"}],
            },
            "at most",
        ),
        ({"nodes": [{"children": [1]}, {"children": [2]}, {"children": [1]}]}, "two parents"),
        ({"nodes": [{"children": [1]}, {"children": [0]}]}, "cycle"),
        ({"nodes": [{"children": [5]}]}, "not a valid glTF"),
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "KHR_draco_mesh_compression"),
        ({"meshes": "none"}, "not a valid glTF"),
        ({"nodes": 7}, "not a valid glTF"),
    ],
)
def test_a_gltf_that_asks_for_too_much_is_refused_before_it_is_unfolded(tmp_path, changes, message):
    (tmp_path / "bomb.gltf").write_text(triangle_gltf(**changes))
    with pytest.raises(AssetError, match=message):
        load_asset("bomb.gltf", tmp_path)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.obj", None, "there is no asset"),
        ("mesh.fbx", b"x", "expected .obj"),
        ("empty.obj", b"", "cannot be read|no faces"),
        ("points.obj", b"v 0 0 0\nv 1 0 0\n", "cannot be read|no faces"),
        ("corner.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "asset"),
        ("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "finite"),
        ("text.glb", b"certainly not binary", "asset"),
        ("short.glb", b"glTF\x02\x00", "not a valid glTF"),
        ("deep.gltf", b"[" * 100_000, "not a valid glTF"),
        ("chunk.glb", b"glTF" + struct.pack("<IIII", 2, 20, 0, 1), "first chunk"),
    ],
)
def test_broken_files_say_what_is_wrong(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(AssetError, match=message) as caught:
        load_asset(name, tmp_path)
    assert name in str(caught.value)


def test_large_files_and_meshes_are_refused(tmp_path, monkeypatch):
    cone_mesh().export(tmp_path / "cone.obj")
    monkeypatch.setattr(assets, "MAX_FACES", 10)
    with pytest.raises(AssetError, match="triangles"):
        load_asset("cone.obj", tmp_path)
    monkeypatch.setattr(assets, "MAX_BYTES", 100)
    with pytest.raises(AssetError, match="bytes"):
        load_asset("cone.obj", tmp_path)


def test_the_files_of_one_gltf_are_counted_together(tmp_path, monkeypatch):
    buffers = [{"byteLength": 36, "uri": f"{k}.bin"} for k in range(4)]
    for k in range(4):
        (tmp_path / f"{k}.bin").write_bytes(np.eye(3, dtype=np.float32).tobytes() * 100)
    views = [{"buffer": k, "byteLength": 36} for k in range(4)]
    accessors = [{"bufferView": k, "componentType": 5126, "count": 3, "type": "VEC3"} for k in range(4)]
    meshes = [{"primitives": [{"attributes": {"POSITION": k}} for k in range(4)]}]
    document = triangle_gltf(buffers=buffers, bufferViews=views, accessors=accessors, meshes=meshes)
    (tmp_path / "many.gltf").write_text(document)
    assert load_asset("many.gltf", tmp_path).meshes.num_faces == 4
    monkeypatch.setattr(assets, "MAX_BYTES", 10_000)
    with pytest.raises(AssetError, match="bytes"):
        load_asset("many.gltf", tmp_path)


def test_links_to_themselves_are_named(tmp_path):
    (tmp_path / "loop.obj").symlink_to("loop.obj")
    (tmp_path / "loop").symlink_to("loop")
    for path, root in (("loop.obj", tmp_path), ("loop/a.obj", tmp_path), ("a.obj", tmp_path / "loop")):
        with pytest.raises(AssetError, match=f'the asset "{path}" cannot be looked up'):
            load_asset(path, root)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize("suffix", ["obj", "glb", "gltf"])
def test_folders_pipes_and_large_files_are_not_read(tmp_path, suffix):
    (tmp_path / f"folder.{suffix}").mkdir()
    os.mkfifo(tmp_path / f"pipe.{suffix}")
    with (tmp_path / f"large.{suffix}").open("wb") as file:
        file.truncate(1 << 33)
    for name, message in (("folder", "there is no asset"), ("pipe", "there is no asset"), ("large", "more than the")):
        with pytest.raises(AssetError, match=message):
            load_asset(f"{name}.{suffix}", tmp_path)


def test_points_that_no_face_uses_do_not_change_the_size(tmp_path):
    (tmp_path / "stray.obj").write_text("v 99 99 99\nv 0 0 0\nv 1 0 0\nv 0 2 0\nf 2 3 4\n")
    assert load_asset("stray.obj", tmp_path).size.tolist() == [1.0, 2.0, 0.0]


@QUICK
@given(st.text(alphabet="./\\\x00ab~%", max_size=12))
def test_any_path_is_an_asset_error_or_inside(tmp_path, path):
    with pytest.raises(AssetError):
        load_asset(path, tmp_path)


@QUICK
@given(st.sampled_from(["obj", "glb", "gltf"]), st.integers(0, 400), st.binary(min_size=1, max_size=6))
def test_damaged_files_never_end_in_another_error(tmp_path, suffix, place, damage):
    if suffix == "gltf":
        content = triangle_gltf().encode()
    else:
        content = cone_mesh().export(file_type=suffix)
        content = content.encode() if isinstance(content, str) else content
    place %= len(content)
    (tmp_path / f"damaged.{suffix}").write_bytes(content[:place] + damage + content[place + len(damage) :])
    try:
        asset = load_asset(f"damaged.{suffix}", tmp_path)
    except AssetError:
        return
    assert asset.meshes.num_faces > 0
    assert np.isfinite(asset.meshes.points).all()
