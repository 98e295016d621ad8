"""Parts put together again: areas stay, edges inside have two faces, and flat parts become one face."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.geometry.meshes import reconnection
from grammarlab.geometry.meshes.corner_data import CornerData
from grammarlab.geometry.meshes.edges import boundary_lengths, is_closed_surface
from grammarlab.geometry.meshes.measure import areas, volumes
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box
from grammarlab.geometry.meshes.reconnection import reconnected
from grammarlab.language.grammar import Grammar
from tests.cases import bulk
from tests.derivation.operations.leaves import sampled, world_meshes

F_SHAPE = "inline({}) split(x) {{ 10 : X. | ~1 : split(z) {{ 4 : X. | 4 : NIL }}* }}"


def apart(mesh: Meshes) -> Meshes:
    """A mesh whose faces share no points."""
    faces = np.array([mesh.num_faces])
    return Meshes.from_polygons(mesh.points[mesh.corner_points()], np.diff(mesh.face_offsets), faces)


def rectangles(rows: list[list[float]]) -> Meshes:
    """Upright rectangles in rows of given widths, one metre high each, without common points."""
    points = []
    for y, widths in enumerate(rows):
        ends = np.cumsum([0.0, *widths]) / sum(widths)
        for a, b in pairwise(ends):
            points += [[a, y, 0], [b, y, 0], [b, y + 1, 0], [a, y + 1, 0]]
    count = len(points) // 4
    return Meshes.from_polygons(np.array(points), np.full(count, 4), np.array([count]))


@given(st.lists(st.lists(st.floats(0.1, 3.0), min_size=1, max_size=6), min_size=1, max_size=5))
@bulk(60)
def test_bricks_of_a_wall_share_all_edges_inside_it(rows):
    wall = rectangles(rows)
    result = reconnected(wall)
    assert result is not None
    assert result.num_faces == wall.num_faces
    assert areas(result) == pytest.approx(areas(wall))
    assert boundary_lengths(result) == pytest.approx([2.0 + 2.0 * len(rows)])


def test_six_faces_are_a_box_again_with_the_same_faces():
    result = reconnected(apart(box()))
    assert result is not None
    assert len(result.points) == 8
    assert is_closed_surface(result).all()
    assert volumes(result) == pytest.approx([1.0])
    assert np.array_equal(result.points[result.corners], box().points[box().corners])


def test_new_corners_have_coordinates_between_those_of_their_neighbours():
    wall = rectangles([[1.0], [1.0, 3.0]])
    coordinates = wall.points[wall.corner_points()][:, :2] * 7.0
    result = reconnected(replace(wall, data=CornerData.of_sets([coordinates], wall.num_faces)))
    assert result is not None
    assert result.data is not None
    assert np.diff(result.face_offsets).tolist() == [5, 4, 4]
    assert result.data.coordinates(0) == pytest.approx(result.points[result.corners][:, :2] * 7.0)


def test_the_parts_of_a_lot_become_one_face_that_is_extruded_as_one():
    """The example of the documentation: a footprint like an F."""
    lot = (30.0, 20.0)
    flat = sampled(f"Lot --> {F_SHAPE.format('recompose')} cleanupGeometry(all, 0) A", lot)
    assert world_meshes(flat).num_faces == 1
    expected = 10 * 20 + 20 * 4 * 3
    assert areas(world_meshes(flat)) == pytest.approx([expected])
    solid = sampled(f"Lot --> {F_SHAPE.format('recompose')} cleanupGeometry(all, 0) extrude(3) A", lot)
    assert volumes(world_meshes(solid)) == pytest.approx([3.0 * expected])
    assert world_meshes(solid).num_faces == 2 + 12
    appended = sampled(f"Lot --> {F_SHAPE.format('append')} A", lot)
    assert areas(world_meshes(appended)) == pytest.approx([expected])
    assert boundary_lengths(world_meshes(appended)) > boundary_lengths(world_meshes(flat))


def test_too_many_edges_are_appended_with_a_warning(monkeypatch):
    monkeypatch.setattr(reconnection, "MOST_EDGES", 3)
    forest = derive(Grammar.parse(f"Lot --> {F_SHAPE.format('recompose')} A"), 1, 1)
    assert [warning.message for warning in forest.warnings] == [
        "inline(recompose) connects at most 3 edges; more are appended"
    ]
