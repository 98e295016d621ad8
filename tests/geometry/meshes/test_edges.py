from collections import Counter

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.geometry.meshes.edges import edges, faces_at_boundary, num_edges
from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.measure import num_faces, num_vertices
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box, disk, quad
from tests.geometry.bodies import FRAME, solids

QUICK = settings(max_examples=40, deadline=None)


@QUICK
@given(solids)
def test_solids_obey_the_formula_of_euler(solid):
    assert (num_vertices(solid) - num_edges(solid) + num_faces(solid)).tolist() == [2]


@QUICK
@given(st.lists(st.one_of(solids, st.integers(3, 8).map(disk)), min_size=1, max_size=3))
def test_the_table_is_what_a_walk_around_the_faces_meets(batch):
    meshes = Meshes.concatenate(batch)
    rows, met = meshes.corner_points(), {}
    for face in range(meshes.num_faces):
        begin, end = meshes.face_offsets[face : face + 2]
        for corner in range(begin, end):
            following = corner + 1 if corner + 1 < end else begin
            met.setdefault(frozenset((int(rows[corner]), int(rows[following]))), []).append(face)
    table = edges(meshes)
    found = [frozenset(pair) for pair in zip(table.start.tolist(), table.end.tolist(), strict=True)]
    assert found == list(met)
    assert table.num_faces.tolist() == [len(faces) for faces in met.values()]
    assert table.faces.tolist() == [[*faces, -1][:2] for faces in met.values()]
    assert Counter(table.edge_of_corner.tolist()) == dict(enumerate(table.num_faces.tolist()))


def test_the_bridge_of_a_keyhole_is_no_edge():
    table = edges(FRAME)
    assert len(table) == 8
    assert table.is_boundary.all()
    assert len(edges(extrude(FRAME, np.ones(1)))) == 24


def test_faces_at_the_boundary_have_an_edge_of_their_own():
    lid = Meshes.single(box().points, box().corners.reshape(6, 4)[1:].tolist())
    assert faces_at_boundary(lid, edges(lid)).tolist() == [False, True, True, True, True]
    assert not faces_at_boundary(box(), edges(box())).any()
    assert faces_at_boundary(quad(), edges(quad())).all()


def test_meshes_without_faces_have_no_edges():
    nothing = Meshes.single(np.zeros((0, 3)), [])
    assert len(edges(nothing)) == 0
    assert num_edges(nothing).tolist() == [0]
    assert faces_at_boundary(nothing, edges(nothing)).tolist() == []
