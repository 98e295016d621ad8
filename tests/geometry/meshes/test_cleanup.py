"""Cleaned meshes have the surface of the mesh, and what the runtime of CityEngine leaves of it."""

from __future__ import annotations

import time
from collections import Counter

import numpy as np
import pytest

from grammarlab.geometry.meshes import primitives
from grammarlab.geometry.meshes.cleanup import Components, cleaned
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.edges import num_holes
from grammarlab.geometry.meshes.measure import area_vectors, areas, volumes
from grammarlab.geometry.meshes.mesh import NUM_ROLES, Meshes
from tests.derivation.operations.leaves import L_SHAPE, sampled, world_meshes

U_SHAPE = np.array([[0, 0, 0], [0, 0, 25], [8, 0, 25], [8, 0, 10], [20, 0, 10], [20, 0, 25], [30, 0, 25], [30, 0, 0.0]])


def grid(columns: int, rows: int, jitter: float = 0.0) -> Meshes:
    """One mesh of square faces of a metre, each with points of its own."""
    squares = [
        [(x, 0.0, z), (x, 0.0, z + 1), (x + 1, 0.0, z + 1), (x + 1, 0.0, z)]
        for x in range(columns)
        for z in range(rows)
    ]
    points = np.array(squares, dtype=np.float64).reshape(-1, 3)
    points += jitter * np.random.default_rng(4).uniform(-1, 1, points.shape)
    count = columns * rows
    return Meshes.from_polygons(points, np.full(count, 4), np.array([count]))


def sizes(mesh: Meshes) -> Counter[int]:
    return Counter(np.diff(mesh.face_offsets).tolist())


@pytest.mark.parametrize(
    ("rule", "faces"),
    [  # from the runtime, on the lots L and U
        ("offset(-2) cleanupGeometry(all, 0)", ({6: 1}, {8: 1})),
        ("offset(-2) cleanupGeometry(vertices, 0.1)", ({4: 6, 6: 1}, {4: 8, 8: 1})),
        ("extrude(5) offset(-1) cleanupGeometry(edges, 0.001)", ({4: 6, 6: 2}, {4: 8, 8: 2})),
        ("offset(-2) extrude(3) cleanupGeometry(all, 0)", ({4: 6, 6: 2}, {4: 8, 8: 2})),
        ("extrude(0.5) cleanupGeometry(all, 1)", ({6: 1}, {8: 1})),
        ("extrude(0.5) cleanupGeometry(all, 0.2)", ({4: 6, 6: 2}, {4: 8, 8: 2})),
        ("roofHip(5) cleanupGeometry(all, 0.9)", ({6: 2}, {8: 2})),
        ("roofGable(30, 1, 1) cleanupGeometry(all, 0.5)", ({3: 2, 4: 2, 5: 2, 6: 1}, None)),
        ("s(0.3, 0, 0.4) cleanupGeometry(all, 1)", ({6: 1}, {8: 1})),
    ],
)
def test_faces_are_those_of_the_runtime(rule: str, faces: tuple[dict[int, int], dict[int, int] | None]) -> None:
    for lot, expected in zip((L_SHAPE, U_SHAPE), faces, strict=True):
        if expected is not None:
            assert sizes(world_meshes(sampled(f"Lot --> {rule} A.", lot))) == expected


@pytest.mark.parametrize("components", ["all", "edges", "faces", "vertices"])
@pytest.mark.parametrize(
    "solid", ["extrude(5) offset(-1)", "offset(-2, border) extrude(3)", "roofHip(40) offset(-0.2)"]
)
def test_the_surface_stays_at_tolerance_zero_and_a_second_time_nothing_changes(
    solid: str, components: Components
) -> None:
    mesh = world_meshes(sampled(f"Lot --> {solid} A.", L_SHAPE))
    once = cleaned(mesh, components, 0.0)
    assert areas(once) == pytest.approx(areas(mesh))
    assert volumes(once) == pytest.approx(volumes(mesh))
    assert np.allclose(area_vectors(once).sum(axis=0), area_vectors(mesh).sum(axis=0))
    assert sizes(cleaned(once, components, 0.0)) == sizes(once)


def test_a_divided_square_is_one_face_again_and_begins_where_its_first_face_did() -> None:
    whole = cleaned(grid(5, 7), "all", 0.0)
    assert sizes(whole) == {4: 1}
    assert whole.points[whole.corners[0]].tolist() == [0.0, 0.0, 0.0]
    assert areas(whole) == pytest.approx([35.0])
    assert sizes(cleaned(grid(5, 7), "edges", 0.0)) == {24: 1}
    assert sizes(cleaned(grid(5, 7, jitter=1e-3), "all", 0.1)) == {4: 1}
    assert sizes(cleaned(grid(5, 7, jitter=1e-3), "all", 0.0)) == {4: 35}


def test_a_ring_around_a_missing_face_gets_a_hole() -> None:
    squares = grid(3, 3)
    ring = cleaned(_of_faces(squares, [0, 1, 2, 3, 5, 6, 7, 8]), "all", 0.0)
    assert ring.num_faces == 1
    assert num_holes(ring).tolist() == [1]
    assert areas(ring) == pytest.approx([8.0])


def _of_faces(meshes: Meshes, chosen: list[int]) -> Meshes:
    points = meshes.points.reshape(-1, 4, 3)[chosen].reshape(-1, 3)
    return Meshes.from_polygons(points, np.full(len(chosen), 4), np.array([len(chosen)]))


def test_faces_with_other_tags_materials_or_coordinates_stay_apart() -> None:
    pair = grid(2, 1)
    flat = pair.points[:, [0, 2]]
    torn = flat.copy()
    torn[4:] += 0.5
    cases = [
        (CornerData.of_sets([flat], 2), 0, 1),
        (CornerData.of_sets([torn], 2), 0, 2),
        (CornerData.of_sets([flat], 2, slots=np.array([0, 1])), 0, 2),
        (None, NUM_ROLES, 2),
        (None, 1, 1),
    ]
    for data, tag, count in cases:
        tagged = Meshes(
            points=pair.points,
            corners=pair.corners,
            face_offsets=pair.face_offsets,
            mesh_faces=pair.mesh_faces,
            mesh_points=pair.mesh_points,
            tags=np.array([0, tag], np.int32),
            data=data,
        )
        result = cleaned(tagged, "all", 0.0)
        assert result.num_faces == count
        if data is not None and count == 1:
            assert result.data is not None
            assert np.array_equal(result.data.coordinates(0), result.points[result.corners][:, [0, 2]])


def test_points_within_a_metre_times_the_tolerance_are_one() -> None:
    cylinder = primitives.cylinder(100)
    wide = cylinder.with_points(6.0 * cylinder.points)
    assert sizes(cleaned(wide, "vertices", 0.5)) == {4: 33, 33: 2}  # corners 0.188 m apart, three of them within 0.5 m
    assert cleaned(wide, "vertices", 0.1).num_faces == 102


def test_a_repeated_face_goes_and_what_would_vanish_stays() -> None:
    square = grid(1, 1)
    twice = Meshes.united([square, square.reversed()])
    assert cleaned(twice, "faces", 0.0).num_faces == 1
    assert cleaned(twice, "vertices", 0.0).num_faces == 2
    small = square.with_points(0.1 * square.points)
    assert cleaned(small, "all", 1.0) is small


def test_many_points_within_a_metre_are_one_without_much_memory() -> None:
    dense = grid(100, 100)
    whole = dense.with_points(0.02 * dense.points)
    begin = time.process_time()
    assert cleaned(whole, "vertices", 1.0).num_faces < 20
    assert time.process_time() - begin < 10.0


def test_faces_of_more_than_the_tolerated_area_stay() -> None:
    mesh = world_meshes(sampled("Lot --> s(6, 0, 0.6) extrude(0.55) cleanupGeometry(faces, 0.5) A."))
    assert sizes(mesh) == {4: 6}  # from the runtime; the smallest faces have 0.33 square metres
