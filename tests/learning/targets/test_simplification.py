"""The smallest tree that is near enough: as far from the predictions as is allowed, and no farther."""

import numpy as np
import pytest

from grammarlab.learning.targets.simplification import TOLERANCE, Simplified, _Path, simpler, smallest
from grammarlab.preference.regression_tree import Split

ROWS = np.arange(8.0)[:, None]
SPLITS = tuple(Split(leaf, 0, leaf + 1.0) for leaf in range(3))


class Measured(_Path):
    """A path whose trees of 1, 2, … leaves have given distances, also from all designs."""

    def distance(self, preference):
        return self.js[len(preference.scores) - 1]

    def rounded(self, exact, bound):
        assert not bound < self.distance(exact)
        return Simplified(exact, bound)


def chosen(*distances):
    """Number of leaves of the chosen tree, and how far it may become for rounder numbers."""
    path = Measured(ROWS, ROWS[:, 0], np.ones(8), SPLITS, distances)
    result = path.nearly_nearest()
    return len(result.preference.scores), result.js


@pytest.mark.parametrize(
    ("distances", "size", "bound"),
    [
        ((0.02, 0.004, 0.003, 0.0), 2, 0.004),
        ((0.02, np.nextafter(0.004, 1.0), 0.003, 0.0), 3, 0.004),
        ((0.02, 0.0049, 0.0045, 0.0042), 4, 0.0042),
        ((0.02, 0.01, 0.0051, TOLERANCE), 4, TOLERANCE),
        ((0.02, 0.006 + 0.004, 0.007, 0.006), 2, 0.006 + TOLERANCE),
        ((0.02, np.nextafter(0.006 + 0.004, 1.0), 0.007, 0.006), 3, 0.006 + TOLERANCE),
        ((0.006, 0.02, 0.03, 0.04), 1, 0.006 + TOLERANCE),
    ],
)
def test_the_smallest_tree_is_as_far_as_is_allowed_and_no_farther(distances, size, bound):
    assert chosen(*distances) == (size, pytest.approx(bound))


def test_a_distance_that_is_no_number_ends_in_the_nearest_known_tree():
    assert chosen(0.02, np.nan, 0.01, 0.008)[0] == 2


@pytest.mark.parametrize("seed", range(6))
def test_functions_are_within_what_is_allowed_of_the_nearest_tree(seed):
    randomness = np.random.default_rng(seed)
    rows, weights = randomness.uniform(size=(600, 3)), randomness.uniform(0.5, 2.0, 600)
    scores = randomness.uniform(0.0, 100.0, 600) if seed % 2 else 100.0 * (rows.sum(axis=1) > 1.5)
    columns = np.arange(3)
    path = _Path.grown(rows, scores, weights, columns, 16)
    nearest = path.distance(path.preference(1 + int(np.argmin(path.js))))
    most = TOLERANCE if nearest <= TOLERANCE else nearest + TOLERANCE
    assert smallest(rows, scores, weights, columns, 16).js <= most
    functions = list(simpler(rows, scores, weights, columns, 16))
    if not path.smallest:
        assert [each.js <= most for each in functions] == [True]
