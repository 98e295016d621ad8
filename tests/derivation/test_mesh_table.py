"""The table of meshes has each mesh once, and equality is that of all bits."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.derivation.frames import FrameTable
from grammarlab.derivation.state.mesh_table import MeshTable
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box, quad
from grammarlab.language.grammar import Grammar


def _without_values(meshes: Meshes) -> Meshes:
    return meshes.with_data(CornerData.of_sets([np.full((len(meshes.corners), 2), np.nan)], meshes.num_faces))


def _polygons(seed: int, count: int) -> list[Meshes]:
    """Meshes of one or two faces on few different corners: many are equal, and many nearly so."""
    random = np.random.default_rng(seed)
    meshes = []
    for _ in range(count):
        points = np.array([[0.0, 0.25, 1.0], [random.choice([0.0, -0.0]), 0.0, 1.0]])
        faces = [[0, 1, 2, 3]] if random.random() < 0.5 else [[0, 1, 2], [2, 3, 0]]
        mesh = Meshes.single(points[[0, 1, 1, random.integers(0, 2)]], faces, [int(random.integers(0, 2))] * len(faces))  # ty: ignore[invalid-argument-type]
        if random.random() < 0.5:
            uv = np.full((len(mesh.corners), 2), random.choice([0.0, -0.0, np.nan]))
            slots = random.integers(0, 2, len(faces))
            mesh = mesh.with_data(CornerData.of_sets([uv], len(faces), slots=slots))
        meshes.append(mesh)
    return meshes


def _bits(mesh: Meshes) -> tuple[bytes, ...]:
    data = (_without_values(mesh) if mesh.data is None else mesh).data
    assert data is not None
    values = np.where(np.isnan(data.values), np.nan, data.values)
    columns = (mesh.points, mesh.corners, mesh.face_offsets, mesh.tags, values, data.slots)
    return tuple(column.tobytes() for column in columns)


@pytest.mark.parametrize("hashes_differ", [True, False])
def test_meshes_share_an_id_exactly_if_all_their_bits_are_equal(monkeypatch, hashes_differ):
    if not hashes_differ:
        monkeypatch.setattr(Meshes, "fingerprints", lambda meshes: np.zeros(len(meshes), np.uint64))
    table, meshes = MeshTable(), _polygons(7, 400)
    ids = np.concatenate([table.add(Meshes.concatenate(meshes[i : i + 7])) for i in range(0, len(meshes), 7)])
    assert table.take(ids).same_as(Meshes.concatenate(meshes))
    bits = [_bits(mesh) for mesh in meshes]
    bits_of_id = dict(zip(ids.tolist(), bits, strict=True))
    assert [bits_of_id[number] for number in ids.tolist()] == bits
    if hashes_differ:
        assert len(set(ids.tolist())) == len(set(bits)) == len(table) - 4 < 200
        assert table.freeze().take(ids).same_as(Meshes.concatenate(meshes))


def test_mirrors_of_meshes_are_involutions_and_equal_those_made_one_by_one():
    table, other = MeshTable(), MeshTable()
    meshes = Meshes.concatenate(_polygons(3, 60))
    ids = table.add(meshes)
    turned = table.mirrored(ids, 2)
    assert (table.mirrored(turned, 2) == ids).all()
    alone = [int(other.mirrored(other.add(meshes.take(np.array([k]))), 2)[0]) for k in range(len(meshes))]
    assert table.take(turned).same_as(other.take(np.array(alone)))


def test_a_tower_of_mirrored_and_trimmed_inserts_has_as_many_meshes_for_any_number_of_storeys():
    grammar = Grammar.parse("""
        attr storeys = 2
        Lot --> extrude(3 * storeys) comp(f) { side : split(y) { 3 : split(x) { ~2 : Bay(split.index % 2 == 1) }* }* }
        Bay(odd) --> case odd : mirrorScope(true, false, false) Insert else : s(-scope.sx, '1, '1) Insert
        Insert --> s('1.2, '1, 0.5) i("builtin:cone") comp(f) { all = extrude(0.1) A. | side : B. }
    """)
    few, many = (
        derive(grammar, 2, 1, footprint=(12.0, 8.0), attributes={"storeys": float(storeys)}) for storeys in (3, 9)
    )
    assert len(many.leaves) > 2.9 * len(few.leaves)
    assert len(many.meshes) == len(few.meshes) < len(few.leaves) / 4


def test_rotations_of_alike_frames_equal_those_of_each():
    table = FrameTable()
    turns = np.stack([np.linalg.qr(np.random.default_rng(k).normal(size=(3, 3)))[0] for k in range(3)] + [np.eye(3)])
    frames = table.add(turns[:2])[np.array([0, 1, 0, 1, 0, 0])]
    number = np.array([0, 1, 2, 3, 0, 3])
    alike = table.rotated_alike(frames, turns, number)
    expected = table.rotations(table.rotated(frames, turns[number]))
    assert table.rotations(alike).tobytes() == expected.tobytes()
    assert alike[0] == alike[4]


@pytest.mark.parametrize("rows", [[0, 1], [1, 0], [0, 0], [1], [0, 1, 1], []])
def test_meshes_at_rows_are_those_of_a_list(rows):
    meshes = Meshes.concatenate([box(), quad()])
    each = [meshes.take(np.array([row])) for row in rows]
    taken = meshes.take(np.array(rows, dtype=np.int64))
    assert taken.same_as(Meshes.concatenate(each)) if each else len(taken) == 0
    assert (taken is meshes) == (rows == [0, 1])
