"""Products that cover elements."""

import random
from itertools import product

import pytest

from grammarlab.layers.covers import products
from tests.cases import some


@pytest.mark.parametrize("seed", some(range(40)))
def test_places_are_covered_and_nothing_else_is_shown(seed: int) -> None:
    rng = random.Random(seed)
    columns = [(2 * each, 2 * each + rng.choice([1, 2])) for each in range(rng.randint(1, 6))]
    rows = [(3 * each, 3 * each + 2) for each in range(rng.randint(1, 5))]
    every = [*product(columns, rows)]
    places = {each for each in every if rng.random() < 0.7}
    behind = {each for each in every if each not in places and rng.random() < 0.5}
    found = products("w", places, lambda across, up: (across, up) in behind, 64)
    shown = {each for one in found for each in product(one.across, one.up)}
    assert places <= shown <= places | behind
    assert len(found) <= len({up for _, up in places})


def test_a_grid_behind_a_door_is_one_product() -> None:
    columns, rows = [(0, 1), (2, 3), (4, 5)], [(0, 1), (2, 3)]
    door = (columns[1], rows[0])
    places = {*product(columns, rows)} - {door}
    (one,) = products("window", places, lambda across, up: (across, up) == door, 9)
    assert (one.across, one.up) == (frozenset(columns), frozenset(rows))
    assert len(products("window", places, lambda *_: False, 9)) == 2


def test_of_too_many_products_the_largest_are_found() -> None:
    places = {((2 * each, 2 * each + 1), (2 * each, 2 * each + 1)) for each in range(9)}
    assert len(products("w", places, lambda *_: False, 4)) == 4
    assert products("w", (), lambda *_: False, 4) == []
