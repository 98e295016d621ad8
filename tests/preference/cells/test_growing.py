"""Trees grown again and trees of other labels: what they must not change."""

import numpy as np
import pytest

from grammarlab.preference.cells.cells import ScoreCells, grid_of
from grammarlab.preference.cells.splits import Above, Splits
from grammarlab.preference.cells.tree_growth import Growth, Tree, grow, loosened, regrown, replanted

EVERY = np.arange(60)


def labelled(seed):
    """Rows of counts and alternatives, and scores that two of them decide, with noise."""
    randomness = np.random.default_rng(seed)
    choice = randomness.integers(4, size=60)
    rows = np.column_stack([choice[:, None] == np.arange(4), randomness.integers(3, size=(60, 3))]).astype(np.float64)
    liked = ((choice == 1) | (choice == 2)) & (rows[:, 4] > 0.0)
    scores = np.clip(70.0 * liked + randomness.normal(0.0, 8.0, 60), 0.0, 100.0)
    splits = Splits.of(rows, np.array([0, 0, 0, 0, 1, 2, 3]), np.zeros(7, dtype=bool), scores)
    return rows, ScoreCells(splits, scores, grid_of(scores), 8.0, 0.03)


@pytest.mark.parametrize("seed", range(5))
def test_a_tree_replanted_with_its_own_labels_is_itself(seed):
    rows, cells = labelled(seed)
    tree = grow(cells, EVERY, Growth(1e-2), np.random.default_rng(seed))
    again = replanted(cells, tree, rows, EVERY)
    assert [part.tolist() for part in again.cells()] == [part.tolist() for part in tree.cells()]
    assert again.log_posterior == pytest.approx(tree.log_posterior, abs=1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_splits_that_other_labels_do_not_ask_for_are_cut_back(seed):
    rows, cells = labelled(seed)
    tree = grow(cells, EVERY, Growth(1e-2), np.random.default_rng(seed))
    none = ScoreCells(cells.splits, np.full(60, 30.0), cells.grid, 8.0, 0.03)
    assert tree.split is not None
    assert replanted(none, tree, rows, EVERY).split is None
    some = EVERY[::2]
    part = replanted(cells, tree, rows, some)
    assert np.sort(np.concatenate(list(part.cells()))).tolist() == some.tolist()


@pytest.mark.parametrize("seed", range(5))
def test_what_is_grown_again_is_never_less_likely(seed):
    _, cells = labelled(seed)
    randomness = np.random.default_rng(seed)
    tree = Tree(EVERY, cells.of_cell(EVERY) + float(np.log1p(-0.9)))
    for _ in range(3):
        better = regrown(cells, tree, Growth(1.0), randomness)
        assert better.log_posterior >= tree.log_posterior
        assert np.sort(np.concatenate(list(better.cells()))).tolist() == EVERY.tolist()
        tree = better
    assert tree.log_posterior == pytest.approx(_by_hand(cells, tree, 0), abs=1e-3)


@pytest.mark.parametrize("seed", range(5))
def test_loose_bounds_keep_all_labels_and_lie_between_the_nearest(seed):
    rows, cells = labelled(seed)
    tree = grow(cells, EVERY, Growth(1e-2), np.random.default_rng(seed))
    loose = loosened(tree, rows, np.random.default_rng(seed))
    assert loose.log_posterior == tree.log_posterior
    assert [cell.tolist() for cell in loose.cell_of(rows)[1]] == [cell.tolist() for cell in tree.cell_of(rows)[1]]
    assert np.array_equal(loose.cell_of(rows)[0], tree.cell_of(rows)[0])
    bounds = [(node, other) for node, other in zip(tree.nodes(), loose.nodes(), strict=True) if node.split]
    assert any(node.split != other.split for node, other in bounds)
    assert all(node.split == other.split or isinstance(other.split, Above) for node, other in bounds)


@pytest.mark.parametrize("ends", [(1.0, np.nextafter(1.0, 2.0)), (-1e308, 1e308), (6.5e6, 6.5e6 + 1e-8)])
def test_loose_bounds_of_any_numbers_lie_between_them(ends):
    rows = np.array(ends)[:, None]
    parts = tuple((side, Tree(np.array([side]), 0.0)) for side in range(2))
    tree = Tree(np.arange(2), 0.0, Above(0, ends[0]), parts)
    for seed in range(20):
        loose = loosened(tree, rows, np.random.default_rng(seed))
        assert loose.cell_of(rows)[0].tolist() == [0, 1]


def _by_hand(cells, tree, depth):
    dividing = 0.9 / np.sqrt(1.0 + depth)
    if tree.split is None:
        return cells.of_cell(tree.labels) + np.log1p(-dividing)
    place = next(n for n, split in enumerate(cells.splits.splits) if split is tree.split)
    mass = cells.splits.mass_of(cells.splits.parts[place, tree.labels], tree.labels)
    return np.log(dividing * mass) + sum(_by_hand(cells, part, depth + 1) for _, part in tree.parts)
