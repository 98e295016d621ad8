"""Connection points of the paper: merged and unmerged pairs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.synthesis.stitching import CLOSE, Matches, matches, stitched

sides = st.tuples(st.integers(1, 6), st.integers(1, 6), st.integers(0, 10_000))


def two_sides(numbers: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    one, other, seed = numbers
    points = np.random.default_rng(seed).uniform(0.0, 1.0, (one + other, 3))
    return points, np.arange(one), one + np.arange(other)


@given(sides)
def test_which_side_comes_first_does_not_matter(numbers: tuple[int, int, int]) -> None:
    points, one, other = two_sides(numbers)
    here, there = matches(points, one, other, 1.0), matches(points, other, one, 1.0)
    assert (here.target == there.target).all()
    assert (here.moved == there.moved).all()


@given(sides)
def test_pairs_are_those_below_the_threshold_of_the_paper(numbers: tuple[int, int, int]) -> None:
    points, one, other = two_sides(numbers)
    found = matches(points, one, other, 10.0)
    small, large = (one, other) if len(one) < len(other) else (other, one)
    if len(one) == len(other):
        small = one if found.target[0] in one else other
        large = other if small is one else one
    distance = np.linalg.norm(points[small][:, None] - points[large], axis=2).min(axis=1)
    low, high = distance.min(), distance.max()
    limit = high if high <= CLOSE * low else (low + high) / 2.0
    assert set(found.target.tolist()) == set(small[distance <= limit].tolist())


@given(sides)
def test_points_without_a_partner_stay_and_order_does_not_matter(numbers: tuple[int, int, int]) -> None:
    points, one, other = two_sides(numbers)
    pairs = [matches(points, one, other, 0.5), matches(points, one[:2], other[-2:], 0.5)]
    found, moved = stitched(points, pairs)
    again, _ = stitched(points, pairs[::-1])
    assert (found == again).all()
    touched = np.concatenate([*(each.target for each in pairs), *(each.moved for each in pairs)])
    apart = np.setdiff1d(np.arange(len(points)), touched)
    assert (found[apart] == points[apart]).all()
    assert not moved[apart].any()
    for each in pairs:
        assert (found[each.target] == found[each.moved]).all()


def test_equal_sides_do_not_move() -> None:
    side = np.random.default_rng(0).uniform(0.0, 1.0, (5, 3))
    points = np.concatenate([side, side])
    found, moved = stitched(points, [matches(points, np.arange(5), 5 + np.arange(5), 1.0)])
    assert (found == points).all()
    assert not moved.any()


def test_nothing_moves_beyond_its_reach() -> None:
    points = np.array([[0.0, 0, 0], [0.0, 0, 0.2]])
    found = matches(points, np.array([0]), np.array([1]), 0.1)
    assert not len(found.target)
    assert stitched(points, [Matches(found.target, found.moved)])[0] == pytest.approx(points)
