"""Triangles of glTF scenes: what they are by the specification, by another library, and for broken files."""

from __future__ import annotations

import copy
import io
import json
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from trimesh.exchange.gltf import export_glb

from grammarlab.assets.gltf_scene import read_gltf
from grammarlab.assets.mesh_files import without_neighbours
from grammarlab.assets.mesh_parts import MeshPart
from grammarlab.errors import AssetError
from tests.assets.documents import BOX, BOX_TRIANGLES, SQUARE, SQUARE_TRIANGLES, Document, rich_document
from tests.cases import bulk

MOST = 1_000_000
QUICK = bulk(100, suppress_health_check=[HealthCheck.too_slow])
TURN = Rotation.from_euler("xyz", [0.3, -1.1, 2.0])


def read(content: bytes | Document) -> list[MeshPart]:
    return read_gltf(content.gltf() if isinstance(content, Document) else content, without_neighbours, MOST)


def corners(parts: list[MeshPart]) -> np.ndarray:
    """[T, 3, 3] corners of all triangles."""
    return np.concatenate([np.zeros((0, 3, 3)), *(part.points[part.triangles] for part in parts)])


def area_vectors(parts: list[MeshPart]) -> np.ndarray:
    a, b, c = corners(parts).transpose(1, 0, 2)
    return np.cross(b - a, c - a) / 2.0


def volume(parts: list[MeshPart]) -> float:
    return float(np.linalg.det(corners(parts)).sum() / 6.0)


def shown(mesh: int, document: Document, **node: Any) -> Document:
    document.show(document.add("nodes", {"mesh": mesh, **node}))
    return document


@pytest.mark.parametrize("index_type", [None, np.uint8, np.uint16, np.uint32])
@pytest.mark.parametrize(
    ("mode", "rows"),
    [
        (None, SQUARE_TRIANGLES),
        (4, SQUARE_TRIANGLES),
        (4, [*SQUARE_TRIANGLES, 0, 1]),
        (5, [0, 1, 2, 3]),
        (5, [0, 1, 2, 3, 3, 3, 3]),
        (6, [0, 1, 3, 2]),
    ],
)
def test_every_mode_covers_the_square_once_and_faces_its_front(mode, rows, index_type) -> None:
    document = Document()
    rows = np.array(rows)
    primitive = {} if mode is None else {"mode": mode}
    if index_type is None:
        mesh = document.mesh(SQUARE[rows], **primitive)
    else:
        mesh = document.mesh(SQUARE, **primitive, indices=document.accessor(rows.astype(index_type)))
    parts = read(shown(mesh, document))
    assert area_vectors(parts).sum(axis=0).tolist() == [0.0, 0.0, 1.0]
    assert (area_vectors(parts)[:, 2] >= 0.0).all()


@pytest.mark.parametrize("mode", [1, 2, 3])
def test_lines_and_primitives_without_positions_are_left_out(mode) -> None:
    document = Document()
    mesh = document.mesh(SQUARE, SQUARE_TRIANGLES)
    normals = document.accessor(SQUARE)
    others = [{"attributes": {"NORMAL": normals}}, {"attributes": {"POSITION": normals}, "mode": mode}]
    document.json["meshes"][mesh]["primitives"] = [others[0], *document.json["meshes"][mesh]["primitives"], others[1]]
    (part,) = read(shown(mesh, document))
    assert len(part.triangles) == 2


def test_points_are_a_part_without_triangles() -> None:
    document = Document()
    (part,) = read(shown(document.mesh(SQUARE, mode=0), document, translation=[1, 0, 0]))
    assert part.points.tolist() == (SQUARE + np.array([1, 0, 0])).tolist()
    assert not part.triangles.size


def test_points_with_indices_are_those_of_the_indices() -> None:
    document = Document()
    positions = document.bare(np.zeros((100_000, 3), np.float32))
    primitive = {"attributes": {"POSITION": positions}, "indices": document.accessor(np.zeros(1, np.uint8)), "mode": 0}
    mesh = document.add("meshes", {"primitives": [primitive]})
    (part,) = read(shown(mesh, document))
    assert part.points.shape == (1, 3)


@pytest.mark.parametrize("index_type", [np.uint8, np.uint16, np.uint32])
@pytest.mark.parametrize("has_base", [True, False])
@pytest.mark.parametrize("padding", [0, 4])
def test_sparse_accessors_are_the_dense_ones(index_type, has_base, padding) -> None:
    base = SQUARE if has_base else np.zeros_like(SQUARE)
    dense, changed = base.copy(), np.array([1, 2, 3], index_type)
    dense[changed] = np.random.default_rng(0).uniform(size=(3, 3))
    document = Document()
    sparse = {
        "count": 3,
        "indices": {
            "bufferView": document.view(changed.tobytes()),
            "componentType": {1: 5121, 2: 5123, 4: 5125}[changed.itemsize],
        },
        "values": {"bufferView": document.view(b"skip" + dense[changed].tobytes()), "byteOffset": 4},
    }
    if has_base:
        positions = document.accessor(base, padding=padding, sparse=sparse)
    else:
        positions = document.bare(base, sparse=sparse)
    indices = document.accessor(SQUARE_TRIANGLES.astype(np.uint8))
    mesh = document.add("meshes", {"primitives": [{"attributes": {"POSITION": positions}, "indices": indices}]})
    assert corners(read(shown(mesh, document))) == pytest.approx(dense[SQUARE_TRIANGLES].reshape(-1, 3, 3))


@pytest.mark.parametrize("component", ["i1", "u1", "i2", "u2"])
@pytest.mark.parametrize("normalized", [True, False])
@pytest.mark.parametrize("padding", [0, 1, 2])
def test_quantised_positions_have_their_size_in_metres(component, normalized, padding) -> None:
    largest = np.iinfo(component).max
    document = Document()
    positions = document.accessor((BOX * largest).astype(component), padding=padding, normalized=normalized)
    indices = document.accessor(BOX_TRIANGLES.astype(np.uint8))
    mesh = document.add("meshes", {"primitives": [{"attributes": {"POSITION": positions}, "indices": indices}]})
    document.json["extensionsRequired"] = document.json["extensionsUsed"] = ["KHR_mesh_quantization"]
    scale = [2.0, 3.0, 5.0] if normalized else [2.0 / largest, 3.0 / largest, 5.0 / largest]
    assert volume(read(shown(mesh, document, scale=scale))) == pytest.approx(30.0)


def test_normalised_integers_end_at_minus_one() -> None:
    document = Document()
    values = np.array([[-128, -127, 127], [-64, 0, 64], [1, 2, 3]], np.int8)
    mesh = document.add(
        "meshes", {"primitives": [{"attributes": {"POSITION": document.accessor(values, normalized=True)}}]}
    )
    found = corners(read(shown(mesh, document)))[0]
    assert found == pytest.approx(np.maximum(values / 127.0, -1.0))


@pytest.mark.parametrize("rotation_type", ["f4", "i1", "i2"])
@pytest.mark.parametrize(
    "given", [("TRANSLATION",), ("ROTATION",), ("SCALE",), ("TRANSLATION", "ROTATION", "SCALE"), ()]
)
def test_instances_are_at_their_places_below_their_node(given, rotation_type) -> None:
    random = np.random.default_rng(1)
    shift, turn = random.normal(size=(5, 3)), Rotation.from_quat(random.normal(size=(5, 4)))
    stretch = random.uniform(-2, 2, (5, 3))
    quaternions = turn.as_quat()
    document = Document()
    is_integer = rotation_type != "f4"
    if is_integer:
        quaternions = np.round(quaternions * np.iinfo(rotation_type).max)
        turn = Rotation.from_quat(quaternions)
    attributes = {
        "TRANSLATION": document.accessor(shift.astype(np.float32)),
        "ROTATION": document.accessor(quaternions.astype(rotation_type), normalized=is_integer),
        "SCALE": document.accessor(stretch.astype(np.float32)),
        "_TEMPERATURE": document.accessor(np.ones(5, np.float32)),
    }
    chosen = {name: attributes[name] for name in (*given, "_TEMPERATURE")}
    mesh = document.mesh(BOX, BOX_TRIANGLES)
    instanced = {
        "mesh": mesh,
        "translation": [0, 7, 0],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": chosen}},
    }
    child = document.add("nodes", {"mesh": document.mesh(SQUARE, SQUARE_TRIANGLES)})
    node = document.add("nodes", {**instanced, "children": [child]})
    document.show(document.add("nodes", {"rotation": TURN.as_quat().tolist(), "children": [node]}))
    expected = []
    for each in range(5):
        points = BOX * stretch[each] if "SCALE" in given else BOX
        points = turn[each].apply(points) if "ROTATION" in given else points
        points = points + shift[each] if "TRANSLATION" in given else points
        expected.append(TURN.apply(points + np.array([0, 7, 0]))[BOX_TRIANGLES].reshape(-1, 3, 3))
    boxes, square = read(document)
    found, expected = corners([boxes]), np.concatenate(expected)
    assert len(square.triangles) == 2
    assert np.sort(found, axis=1) == pytest.approx(np.sort(expected, axis=1), abs=1e-5)
    sizes = np.abs(stretch.prod(axis=1)) if "SCALE" in given else np.ones(5)
    assert volume([boxes]) == pytest.approx(sizes.sum(), abs=1e-4)


@pytest.mark.parametrize("scale", [[1, 1, 1], [-1, 1, 1], [-1, -1, 1], [2, -3, -4], [-1, -1, -1]])
def test_mirrored_boxes_keep_their_outside(scale) -> None:
    document = Document()
    mesh = document.mesh(BOX, BOX_TRIANGLES)
    child = document.add("nodes", {"mesh": mesh, "scale": scale, "rotation": TURN.as_quat().tolist()})
    document.show(document.add("nodes", {"children": [child], "translation": [3, 4, 5]}))
    assert volume(read(document)) == pytest.approx(abs(np.prod(scale)))


def test_a_matrix_is_the_transform_of_its_parts() -> None:
    parts = {"translation": [1.0, 2.0, 3.0], "rotation": TURN.as_quat().tolist(), "scale": [2.0, -1.0, 0.5]}
    matrix = np.eye(4)
    matrix[:3, :3] = TURN.as_matrix() * parts["scale"]
    matrix[:3, 3] = parts["translation"]
    found = []
    for node in (parts, {"matrix": matrix.T.ravel().tolist()}):
        document = Document()
        found.append(corners(read(shown(document.mesh(BOX, BOX_TRIANGLES), document, **node))))
    assert found[0] == pytest.approx(found[1])


def test_only_the_default_scene_is_read_or_the_first_or_all_nodes() -> None:
    document = Document()
    mesh = document.mesh(BOX, BOX_TRIANGLES)
    for x in (1, 2, 4):
        document.add("nodes", {"mesh": mesh, "scale": [x, 1, 1]})
    document.json["scenes"] = [{"nodes": [0, 2]}, {"nodes": [1]}]
    assert volume(read(document)) == pytest.approx(5.0)
    document.json["scene"] = 1
    assert volume(read(document)) == pytest.approx(2.0)
    del document.json["scene"], document.json["scenes"]
    assert volume(read(document)) == pytest.approx(7.0)


def test_invisible_nodes_are_left_out_with_their_children() -> None:
    document = Document()
    mesh = document.mesh(BOX, BOX_TRIANGLES)
    child = document.add("nodes", {"mesh": mesh})
    hidden = {"extensions": {"KHR_node_visibility": {"visible": False}}, "children": [child]}
    document.show(document.add("nodes", {"mesh": mesh}), document.add("nodes", hidden))
    document.json["extensionsRequired"] = ["KHR_node_visibility"]
    assert volume(read(document)) == pytest.approx(1.0)


@pytest.mark.parametrize(("of_mesh", "of_node", "width"), [([], [], 1.0), ([0.5], [], 1.5), ([0.5], [1.0], 2.0)])
def test_morph_targets_move_points_by_the_weights_of_the_file(of_mesh, of_node, width) -> None:
    document = Document()
    moved = document.accessor(BOX * np.array([1, 0, 0], np.float32))
    mesh = document.mesh(BOX, BOX_TRIANGLES, targets=[{"POSITION": moved}])
    document.json["meshes"][mesh] |= {"weights": of_mesh} if of_mesh else {}
    assert volume(read(shown(mesh, document, **({"weights": of_node} if of_node else {})))) == pytest.approx(width)


def test_a_skin_has_the_pose_of_its_joints() -> None:
    document = Document()
    lower, upper = BOX[:, 1] == 0, BOX[:, 1] == 1
    mesh = document.mesh(BOX, BOX_TRIANGLES)
    attributes = document.json["meshes"][mesh]["primitives"][0]["attributes"]
    attributes["JOINTS_0"] = document.accessor(np.where(upper[:, None], [1, 0, 0, 0], [0, 1, 0, 0]).astype(np.uint8))
    attributes["WEIGHTS_0"] = document.accessor(np.tile(np.array([1, 0, 0, 0], np.float32), (8, 1)))
    inverse = np.tile(np.eye(4, dtype=np.float32), (2, 1, 1))
    inverse[1, :3, 3] = [0, -1, 0]
    document.add(
        "skins", {"joints": [1, 2], "inverseBindMatrices": document.accessor(inverse.transpose(0, 2, 1).reshape(2, 16))}
    )
    skinned = document.add("nodes", {"mesh": mesh, "skin": 0, "translation": [99, 99, 99]})
    document.add("nodes", {"children": [2], "translation": [5, 0, 0]})
    document.add("nodes", {"translation": [0, 3, 0]})
    document.show(skinned, 1)
    (part,) = read(document)
    assert part.points[upper] == pytest.approx(BOX[upper] + [5, 2, 0])
    assert part.points[lower] == pytest.approx(BOX[lower] + [5, 0, 0])


def test_colors_are_those_of_the_materials() -> None:
    document = Document()
    document.add("materials", {"pbrMetallicRoughness": {"baseColorFactor": [1.0, 0.5, 0.0, 0.2]}})
    document.add("materials", {"pbrMetallicRoughness": {}})
    nodes = [document.add("nodes", {"mesh": document.mesh(SQUARE, material=each)}) for each in (0, 1)]
    document.show(*nodes, document.add("nodes", {"mesh": document.mesh(SQUARE)}))
    assert [part.color for part in read(document)] == [(1.0, 0.502, 0.0, 0.2), (1.0, 1.0, 1.0, 1.0), None]


def test_buffers_are_inside_or_in_files_beside() -> None:
    document = Document()
    shown(document.mesh(SQUARE, SQUARE_TRIANGLES), document)
    beside = {**document.json, "buffers": [{"byteLength": len(document.buffer), "uri": "a%20b.bin"}]}
    quoted = "data:," + "".join(f"%{each:02x}" for each in document.buffer)
    within = {**document.json, "buffers": [{"byteLength": len(document.buffer), "uri": quoted}]}
    expected = corners(read(document))
    assert corners(read(document.glb())).tolist() == expected.tolist()
    assert corners(read(json.dumps(within).encode())).tolist() == expected.tolist()
    found = read_gltf(json.dumps(beside).encode(), {"a b.bin": document.buffer}.__getitem__, MOST)
    assert corners(found).tolist() == expected.tolist()
    with pytest.raises(AssetError, match=r"refers to the file 'a b\.bin'"):
        read(json.dumps(beside).encode())


@pytest.mark.parametrize("name", ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "ACME_bent_space"])
def test_required_extensions_that_are_not_read_are_named(name) -> None:
    document = shown(0, rich_document())
    document.json["extensionsRequired"] = ["KHR_materials_unlit", name]
    with pytest.raises(AssetError, match=f"{name}.* export it without"):
        read(document)


def test_compressed_meshes_are_read_from_their_uncompressed_copy_or_refused_by_name() -> None:
    document = Document()
    mesh = document.mesh(SQUARE, SQUARE_TRIANGLES)
    primitive = document.json["meshes"][mesh]["primitives"][0]
    primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    document.json["extensionsUsed"] = ["KHR_draco_mesh_compression"]
    assert len(corners(read(shown(mesh, document)))) == 2
    del document.json["accessors"][0]["bufferView"]
    with pytest.raises(AssetError, match="KHR_draco_mesh_compression"):
        read(document)


def test_a_compressed_buffer_without_a_copy_is_refused_by_name() -> None:
    document = shown(0, rich_document())
    document.json["bufferViews"][0] |= {"buffer": 1, "extensions": {"EXT_meshopt_compression": {"buffer": 0}}}
    content = json.loads(document.gltf())
    content["buffers"].append({"byteLength": 1000})
    with pytest.raises(AssetError, match="EXT_meshopt_compression"):
        read(json.dumps(content).encode())


def changed(path: tuple[Any, ...], value: Any) -> bytes:
    """The rich document with another value at a place."""
    content = json.loads(rich_document().gltf())
    entry = content
    for key in path[:-1]:
        entry = entry[key]
    entry[path[-1]] = value
    return json.dumps(content).encode()


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("asset", "version"), "1.0", "version 2.0 .* found '1.0'"),
        (("nodes", 4, "children"), [0], "two parents, or is part of a cycle"),
        (("nodes", 4, "children"), [4], "cycle"),
        (("scenes", 0, "nodes"), [0, 0], "two parents"),
        (("scenes", 0, "nodes"), [-1], "nodes has no entry -1"),
        (("nodes", 1, "mesh"), -1, "meshes has no entry -1"),
        (("nodes", 1, "mesh"), True, "meshes has no entry True"),
        (("nodes", 2, "matrix"), [1] * 15, "15 numbers instead of 16"),
        (("nodes", 2, "matrix"), [float("nan")] * 16, "not finite"),
        (("nodes", 2, "matrix"), [1e300] * 16, "not finite|larger than"),
        (("nodes", 3, "rotation"), [0, 0, 0, 0], "quaternion"),
        (("nodes", 1, "extensions", "EXT_mesh_gpu_instancing", "attributes", "SCALE"), 0, "3 and 8 rows"),
        (("accessors", 0, "count"), 10**9, "at most"),
        (("accessors", 0, "count"), 9, "does not fit"),
        (("accessors", 0, "count"), 7, "corners that do not exist"),
        (("accessors", 0, "byteOffset"), 4, "does not fit"),
        (("accessors", 0, "type"), "VEC2", "2 columns instead of 3"),
        (("accessors", 0, "componentType"), 9, "9"),
        (("bufferViews", 0, "byteStride"), 4, "byteStride is 4"),
        (("bufferViews", 0, "byteStride"), 252, "does not fit"),
        (("bufferViews", 0, "byteLength"), 10**9, "ends at byte"),
        (("bufferViews", 0, "byteOffset"), -4, "byteOffset is -4"),
        (("buffers", 0, "byteLength"), 10**6, "cut off"),
        (("buffers", 0, "uri"), "data:;base64,AAA", "not a valid"),
        (("skins", 0, "joints"), [77], "joints that are not in the scene"),
    ],
)
def test_invalid_values_are_named(path, value, message) -> None:
    with pytest.raises(AssetError, match=message):
        read(changed(path, value))


@pytest.mark.parametrize(
    ("sparse", "message"),
    [
        ({"count": 10**12}, "replaces 1000000000000 of 4"),
        ({"count": -1}, "-1"),
        ({"indices": {"bufferView": 0, "componentType": 5126}}, "not unsigned integers"),
        ({"indices": {"bufferView": 0, "componentType": 5125, "byteOffset": 20}}, "replaces row 1065353216 of 4"),
        ({"values": {"bufferView": 99}}, "bufferViews has no entry 99"),
    ],
)
def test_sparse_values_out_of_range_are_named(sparse, message) -> None:
    document = rich_document()
    (accessor,) = (each for each in document.json["accessors"] if "sparse" in each and each["componentType"] == 5126)
    accessor["sparse"] |= sparse
    with pytest.raises(AssetError, match=message):
        read(document)


def test_a_thousand_million_instances_are_refused_before_they_are_made() -> None:
    document = Document()
    places = document.bare(np.zeros((1, 3), np.float32))
    document.json["accessors"][places]["count"] = 10**9
    instanced = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}
    for mesh in (document.mesh(BOX, BOX_TRIANGLES), document.add("meshes", {"primitives": []})):
        document.json["nodes"] = []
        with pytest.raises(AssetError, match="with all of its instances; at most"):
            read(shown(mesh, document, extensions=instanced))


def test_many_primitives_of_one_large_accessor_are_read_at_once() -> None:
    document = Document()
    positions = document.bare(np.zeros((100_000, 3), np.float32))
    primitive = {"attributes": {"POSITION": positions}, "indices": document.accessor(np.arange(3, dtype=np.uint8))}
    mesh = document.add("meshes", {"primitives": [primitive] * 2_000})
    parts = read(shown(mesh, document))
    assert sum(len(part.points) for part in parts) == 6_000


def test_the_rich_document_has_all_of_its_parts() -> None:
    parts = read(rich_document().glb())
    assert [len(part.triangles) for part in parts] == [36, 2, 2, 2, 2]
    assert volume(parts[:1]) == pytest.approx(24.0)


values = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 12),
    st.sampled_from(
        [10**9, 10**19, -(10**30), 1e308, float("nan"), "", "SCALAR", "data:,", [], {}, [0], {"a": 0}, 5121]
    ),
)


def places_in(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The path of every value of a document."""
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(each for key, entry in entries for each in places_in(entry, (*path, key)))]


RICH = json.loads(rich_document().gltf())
PATHS = [path for path in places_in(RICH) if path]


@QUICK
@given(st.lists(st.tuples(st.sampled_from(PATHS), values), min_size=1, max_size=3))
def test_any_values_in_a_document_end_in_parts_or_in_words(changes) -> None:
    content = copy.deepcopy(RICH)
    for path, value in changes:
        entry: Any = content
        try:
            for key in path[:-1]:
                entry = entry[key]
            entry[path[-1]] = value
        except (LookupError, TypeError):
            continue
    check_readable(json.dumps(content).encode())


@QUICK
@given(st.integers(0, 10_000), st.integers(1, 255), st.booleans())
def test_cut_and_flipped_files_end_in_parts_or_in_words(place, bits, is_cut) -> None:
    content = bytearray(rich_document().glb())
    place %= len(content)
    content[place] ^= bits
    check_readable(bytes(content[:place] if is_cut else content))


def check_readable(content: bytes) -> None:
    try:
        parts = read(content)
    except AssetError:
        return
    for part in parts:
        assert np.isfinite(part.points).all()
        assert part.triangles.size == 0 or part.triangles.max() < len(part.points)


@QUICK
@given(st.lists(st.tuples(st.floats(-9, 9), st.floats(0.1, 3), st.integers(0, 2)), min_size=1, max_size=6))
def test_scenes_of_another_library_are_read_as_it_reads_them(nodes) -> None:
    scene: Any = trimesh.Scene()
    shapes = [
        trimesh.creation.box(),
        trimesh.creation.icosphere(subdivisions=1),
        trimesh.creation.cone(1, 2, sections=7),
    ]
    for number, (shift, scale, shape) in enumerate(nodes):
        transform = trimesh.transformations.rotation_matrix(shift, [1, 2, 3]) @ np.diag([scale, -scale, 1.0, 1.0])
        transform[:3, 3] = [shift, number, 0]
        scene.add_geometry(shapes[shape], geom_name=f"{shape}", node_name=f"{number}", transform=transform)
    content = export_glb(scene)
    expected = trimesh.load_scene(io.BytesIO(content), file_type="glb").to_mesh()
    found = corners(read(content))
    assert len(found) == len(expected.faces)
    assert np.linalg.norm(area_vectors(read(content)), axis=1).sum() == pytest.approx(expected.area, rel=1e-6)
    assert volume(read(content)) == pytest.approx(expected.volume, rel=1e-4, abs=1e-4)
    assert np.array([found.min(axis=(0, 1)), found.max(axis=(0, 1))]) == pytest.approx(expected.bounds, abs=1e-5)
