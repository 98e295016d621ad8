"""Sides of lots are those that a person on the street would name."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.geometry.lot_sides import BACK, FRONT, LEFT, NO_SIDE, RIGHT, edge_sides, front_normals
from tests.cases import bulk

SQUARE = [(0, 10), (10, 10), (10, 0), (0, 0)]
LONG = [(0, 10), (30, 10), (30, 0), (0, 0)]
COURTYARD = [*SQUARE, (0, 10), (3, 7), (3, 3), (7, 3), (7, 7), (3, 7)]
WIDTHS = st.sampled_from([0.0, 0.0, 6.5, 12.0])


def sides(corners: object, widths: object) -> list[int]:
    outline = np.array(corners, dtype=np.float64)
    return edge_sides(outline, np.array([0, len(outline)]), np.array(widths, dtype=np.float64)).tolist()


@st.composite
def lots(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Convex outlines, counter-clockwise seen from above, with street widths."""
    angles = np.sort(draw(st.lists(st.integers(0, 71), min_size=3, max_size=8, unique=True))) * np.radians(5.0)
    corners = np.stack([np.cos(angles) * 20, -np.sin(angles) * 13], axis=1)
    return corners, np.array(draw(st.lists(WIDTHS, min_size=len(angles), max_size=len(angles))))


@pytest.mark.parametrize(
    ("corners", "widths", "expected"),
    [
        (SQUARE, [8, 0, 0, 0], [FRONT, RIGHT, BACK, LEFT]),
        (SQUARE, [0, 8, 0, 0], [LEFT, FRONT, RIGHT, BACK]),
        (LONG, [8, 6, 0, 0], [FRONT, FRONT, BACK, LEFT]),
        (SQUARE, [8, 6, 0, 0], [FRONT, FRONT, RIGHT, LEFT]),
        (SQUARE, [8, 0, 6, 0], [FRONT, RIGHT, FRONT, LEFT]),
        (SQUARE, [0, 0, 0, 0], [RIGHT, RIGHT, BACK, LEFT]),
        (SQUARE, [8, 6, 6, 6], [FRONT] * 4),
        (COURTYARD, [8, 0, 0, 0, 5, 0, 0, 0, 0, 5], [FRONT, RIGHT, BACK, LEFT, NO_SIDE]),
    ],
)
def test_sides_of_lots_that_one_can_draw(corners, widths, expected):
    assert sides(corners, widths)[: len(expected)] == expected


def test_bridges_to_a_courtyard_are_no_streets_whatever_their_width():
    found = sides(COURTYARD, [8, 0, 0, 0, 5, 0, 0, 0, 0, 5])
    assert found[4] == found[9] == NO_SIDE
    assert set(found[5:9]) == {BACK, LEFT, RIGHT}


@given(lots())
@bulk(60)
def test_exactly_the_edges_along_streets_are_the_front(lot):
    corners, widths = lot
    found = np.array(sides(corners, widths))
    assert ((found == FRONT) == (widths > 0.0)).all()
    assert (found != NO_SIDE).all()


@given(lots(), st.integers(0, 7), st.floats(0.1, 0.9))
@bulk(60)
def test_dividing_an_edge_changes_no_side(lot, edge, share):
    corners, widths = lot
    edge %= len(corners)
    middle = (1.0 - share) * corners[edge] + share * corners[(edge + 1) % len(corners)]
    divided = np.insert(corners, edge + 1, middle, axis=0)
    found = sides(divided, np.insert(widths, edge + 1, widths[edge]))
    assert found[edge] == found[edge + 1]
    assert np.delete(found, edge + 1).tolist() == sides(corners, widths)


@given(lots(), st.floats(0.0, 6.3), st.floats(-1e4, 1e4))
@bulk(60)
def test_sides_turn_and_move_with_the_lot(lot, angle, distance):
    corners, widths = lot
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    assert sides(corners @ turn + distance, widths) == sides(corners, widths)


@given(st.lists(lots(), min_size=1, max_size=4))
@bulk(30)
def test_a_batch_has_the_sides_of_its_lots(batch):
    corners = np.concatenate([lot[0] for lot in batch])
    offsets = np.cumsum([0, *(len(lot[0]) for lot in batch)])
    together = edge_sides(corners, offsets, np.concatenate([lot[1] for lot in batch]))
    assert together.tolist() == [side for lot in batch for side in sides(*lot)]
    front = front_normals(corners, offsets, np.concatenate([lot[1] for lot in batch]))
    np.testing.assert_allclose(np.hypot(*front.T), 1.0)
