"""Similarity of two facades."""

import numpy as np
import pytest
import shapely

from grammarlab.facade.reading.cutting import cut
from grammarlab.facade.tree import Facade
from grammarlab.layers.infer import compare


def facade(seed: int, labels: str = "abw") -> Facade:
    """Columns of random widths with random labels; `w` is the wall."""
    rng = np.random.default_rng(seed)
    ends = np.concatenate([[0.0], np.sort(rng.uniform(0.5, 9.5, 5)), [10.0]])
    middle = rng.uniform(1.0, 3.0)
    low = np.array([[x, y] for x in ends[:-1] for y in (0.0, middle)])
    high = np.array([[x, y] for x in ends[1:] for y in (middle, 4.0)])
    names = ["wall" if each == "w" else str(each) for each in rng.choice(list(labels), len(low))]
    return cut(low, high, names)[0]


@pytest.mark.parametrize("seed", range(8))
def test_the_area_is_that_of_intersections(seed: int) -> None:
    one, other = facade(seed), facade(seed + 50)
    shapes = [
        {
            name: shapely.union_all(
                [shapely.box(*each.position[leaf], *(each.position[leaf] + each.size[leaf])) for leaf in each.leaves
                 if each.name_of(leaf) == name]
            )
            for name in ("a", "b", "wall")
        }
        for each in (one, other)
    ]  # fmt: skip
    expected = sum(shapely.intersection(shapes[0][name], shapes[1][name]).area for name in shapes[0]) / 40.0
    found = compare(one, other)
    assert found.area == pytest.approx(expected)
    assert compare(other, one).area == pytest.approx(expected)
    assert 0.0 <= found.quality <= 1.0
    assert found.quality <= 1.0 - abs(found.elements - found.other_elements) / (found.elements + found.other_elements)


def test_a_facade_shows_itself() -> None:
    found = compare(facade(3), facade(3))
    assert (found.area, found.iou, found.quality) == pytest.approx((1.0, 1.0, 1.0))
    plain = compare(facade(3, "w"), facade(3, "w"))
    assert (plain.area, plain.iou, plain.quality, plain.elements) == (pytest.approx(1.0), 1.0, 1.0, 0)


def test_half_a_window_is_half_a_window() -> None:
    one = cut(np.array([[0.0, 0.0], [4.0, 0.0]]), np.array([[4.0, 3.0], [8.0, 3.0]]), ["window", "wall"])[0]
    other = cut(np.array([[0.0, 0.0], [2.0, 0.0]]), np.array([[2.0, 3.0], [8.0, 3.0]]), ["window", "wall"])[0]
    found = compare(one, other)
    assert (found.area, found.iou) == pytest.approx((0.75, 0.5))
