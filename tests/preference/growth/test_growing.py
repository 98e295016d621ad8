"""Trees: the best one by brute force, their posterior by its definition, and trees of other labels."""

import itertools

import numpy as np
import pytest

from grammarlab.preference.cells.cells import ScoreCells, grid_of
from grammarlab.preference.growth.cuts import price_of_bounds
from grammarlab.preference.growth.split_columns import SplitColumns
from grammarlab.preference.growth.splits import Names, Split, Value
from grammarlab.preference.growth.tree_growth import (
    Others,
    Tree,
    TreeGrowth,
    loosened,
    posterior_shares,
)
from grammarlab.preference.judge.leaf_evidence import LeafEvidence
from grammarlab.preference.person import Person


def labelled(seed, num=60):
    """Rows of counts, alternatives and a draw, and scores that two of them decide, with noise."""
    randomness = np.random.default_rng(seed)
    choice = randomness.integers(4, size=num)
    counts = randomness.integers(3, size=(num, 3))
    rows = np.column_stack([choice[:, None] == np.arange(4), counts, randomness.random(num)]).astype(np.float64)
    liked = ((choice == 1) | (choice == 2)) & (rows[:, 4] > 0.0)
    scores = np.clip(70.0 * liked + randomness.normal(0.0, 8.0, num), 0.0, 100.0)
    return rows, scores


def growth_of(rows, scores, noise=8.0):
    groups, continuous = np.array([0, 0, 0, 0, 1, 2, 3, 4]), np.arange(8) == 7
    columns = SplitColumns.of(rows, groups, continuous, scores)
    return TreeGrowth(columns, ScoreCells(scores, grid_of(scores), noise, 0.03))


def by_definition(growth, tree, rows, depth=0):
    """Log-posterior of a tree: evidence of its cells, prior of its nodes, of what they read and of their bounds."""
    dividing = 0.9 / np.sqrt(1.0 + depth)
    if tree.split is None:
        return growth.evidence.of_labels(tree.labels) + np.log1p(-dividing)
    part_of = tree.split.parts(rows[tree.labels])
    for part, branch in tree.parts:
        assert np.array_equal(branch.labels, tree.labels[part_of == part])
    assert {part for part, _ in tree.parts} == set(part_of.tolist())
    num_places = len(np.unique(tree.split.reading.read(rows[tree.labels]))) - 1
    price = growth.columns.prices[growth.columns.place(tree.split.reading)]
    price = price + price_of_bounds(len(tree.parts) - 1, num_places)
    return np.log(dividing) - price + sum(by_definition(growth, part, rows, depth + 1) for _, part in tree.parts)


@pytest.mark.parametrize("seed", range(4))
def test_posteriors_are_those_of_the_definition_however_a_tree_was_found(seed):
    rows, scores = labelled(seed)
    growth, randomness = growth_of(rows, scores), np.random.default_rng(seed)
    grown = growth.trees()
    drawn = [growth.drawn(4.0, randomness) for _ in range(6)]
    again = growth_of(rows, scores, noise=4.0).trees(Others(drawn, rows))
    for tree in grown + drawn:
        assert tree.log_posterior == pytest.approx(by_definition(growth, tree, rows), abs=1e-3)
        assert np.sort(np.concatenate(list(tree.cells()))).tolist() == list(range(60))
    for tree in again:
        assert tree.log_posterior == pytest.approx(by_definition(growth_of(rows, scores, 4.0), tree, rows), abs=1e-3)
    assert grown == sorted(grown, key=lambda tree: -tree.log_posterior)
    assert posterior_shares(grown).sum() == pytest.approx(1.0)
    # The labels ask for both: the choice, or one of its alternatives, and the count.
    read = {column for node in grown[0].nodes() if node.split for column in node.split.columns}
    assert 4 in read
    assert read & {1, 2}


def of_cells(scores):
    return ScoreCells(scores, grid_of(scores), 3.0, 0.03)


def of_leaves(scores):
    return LeafEvidence.of(scores, Person(3.0, 0.03))


@pytest.mark.parametrize("evidence_of", [of_cells, of_leaves])
@pytest.mark.parametrize("seed", range(3))
def test_the_best_tree_is_the_best_of_all_and_has_a_part_of_their_evidence(seed, evidence_of):
    rows = np.array(list(itertools.product([0.0, 1.0], repeat=3)) * 3)
    liked = [(rows[:, 0] > 0) & (rows[:, 1] > 0), rows[:, 0] != rows[:, 2], rows.sum(axis=1) > 2.0][seed]
    scores = np.where(liked, 80.0, 0.0)
    columns = SplitColumns.of(rows, np.arange(3), np.zeros(3, dtype=bool), scores)
    evidence = evidence_of(scores)
    growth = TreeGrowth(columns, evidence)
    found, every = growth.trees()[0], np.arange(24)

    def leaf(labels, depth):
        return evidence.of_labels(labels) + np.log1p(-0.9 / np.sqrt(1.0 + depth))

    def total(labels, depth, of_all, of_part):
        values = [leaf(labels, depth)]
        for column in range(3):
            sides = [labels[rows[labels, column] == value] for value in (0.0, 1.0)]
            if all(len(side) for side in sides):
                parts = sum(of_part(side, depth + 1) for side in sides)
                values.append(np.log(0.9 / np.sqrt(1.0 + depth) / 3.0) + parts)
        return of_all(values)

    def best(labels, depth):
        return total(labels, depth, max, best)

    def of_all_trees(labels, depth):
        return total(labels, depth, np.logaddexp.reduce, of_all_trees)

    assert found.log_posterior == pytest.approx(best(every, 0), abs=1e-3)
    # The best tree and single cuts beside its nodes are some of all trees; beside a cell they are all cuts.
    assert found.log_posterior < growth.with_others(found) < of_all_trees(every, 0) + 1e-3
    single_cuts = total(every, 0, np.logaddexp.reduce, leaf)
    assert growth.with_others(Tree(every, 0.0)) == pytest.approx(single_cuts, abs=1e-3)
    assert np.logaddexp(growth.divided(found), leaf(every, 0)) == pytest.approx(growth.with_others(found))


@pytest.mark.parametrize("root", range(3))
def test_a_tree_begins_with_the_given_column_or_is_not_worth_it(root):
    rows = np.array(list(itertools.product([0.0, 1.0], repeat=3)) * 3)
    scores = np.where((rows[:, 0] > 0) & (rows[:, 1] > 0), 80.0, 0.0)
    columns = SplitColumns.plain(rows, np.full(3, np.log(3.0)))
    tree = TreeGrowth(columns, of_leaves(scores)).grown(np.arange(24), root)
    assert (tree.split is None) == (root == 2)
    assert tree.split is None or tree.split.columns == (root,)


def test_the_best_cut_of_many_values_is_the_best_of_all_bands():
    rows = np.random.default_rng(3).random((40, 1))
    scores = np.where((rows[:, 0] > 0.31) & (rows[:, 0] < 0.52), 90.0, 10.0)
    columns = SplitColumns.of(rows, np.zeros(1, dtype=np.int64), np.ones(1, dtype=bool), scores)
    tree = TreeGrowth(columns, ScoreCells(scores, grid_of(scores), 3.0, 0.03)).trees()[0]
    assert tree.split is not None
    inside = np.sort(rows[scores > 50.0, 0])
    below, above = rows[rows < inside[0]].max(), rows[rows > inside[-1]].min()
    assert tree.split.bounds == pytest.approx(((below + inside[0]) / 2.0, (inside[-1] + above) / 2.0))
    assert all(part.split is None for _, part in tree.parts)


@pytest.mark.parametrize("seed", range(4))
def test_a_tree_tried_with_its_own_labels_is_itself(seed):
    rows, scores = labelled(seed)
    tree = growth_of(rows, scores).trees()[0]
    again = growth_of(rows, scores).sketches(Others([tree], rows))[0]
    assert [cell.tolist() for cell in again.cells()] == [cell.tolist() for cell in tree.cells()]
    assert again.log_posterior == pytest.approx(tree.log_posterior, abs=1e-4)


@pytest.mark.parametrize("seed", range(4))
def test_splits_that_other_labels_do_not_ask_for_are_cut_back(seed):
    rows, scores = labelled(seed)
    tree = growth_of(rows, scores).trees()[0]
    assert tree.split is not None
    none = growth_of(rows, np.full(60, 30.0)).trees(Others([tree], rows))
    assert [each.split for each in none] == [None]
    some = rows[::2]
    part = growth_of(some, scores[::2]).trees(Others([tree], some))[0]
    assert np.sort(np.concatenate(list(part.cells()))).tolist() == list(range(30))


def test_little_doubt_draws_the_best_tree_and_much_doubt_many():
    rows, scores = labelled(0)
    growth, randomness = growth_of(rows, scores), np.random.default_rng(1)
    best = growth.trees()[0]
    assert growth.drawn(1e-3, randomness).log_posterior == pytest.approx(best.log_posterior, abs=1e-6)
    assert len({growth.drawn(8.0, randomness).log_posterior for _ in range(10)}) >= 3


@pytest.mark.parametrize("seed", range(4))
def test_loose_bounds_keep_all_labels_and_lie_between_the_nearest(seed):
    rows, scores = labelled(seed)
    tree = growth_of(rows, scores).drawn(4.0, np.random.default_rng(seed))
    loose = loosened(tree, rows, np.random.default_rng(seed))
    assert loose.log_posterior == tree.log_posterior
    assert [cell.tolist() for cell in loose.cell_of(rows)[1]] == [cell.tolist() for cell in tree.cell_of(rows)[1]]
    assert np.array_equal(loose.cell_of(rows)[0], tree.cell_of(rows)[0])
    pairs = [(node.split, other.split) for node, other in zip(tree.nodes(), loose.nodes(), strict=True) if node.split]
    assert all((own == other) != isinstance(own.reading, Value) for own, other in pairs)


@pytest.mark.parametrize("ends", [(1.0, np.nextafter(1.0, 2.0)), (-1e308, 1e308), (6.5e6, 6.5e6 + 1e-8)])
def test_loose_bounds_of_any_numbers_lie_between_them(ends):
    rows = np.array(ends)[:, None]
    parts = tuple((side, Tree(np.array([side]), 0.0)) for side in range(2))
    tree = Tree(np.arange(2), 0.0, Split(Value(0), (ends[0],)), parts)
    for seed in range(20):
        loose = loosened(tree, rows, np.random.default_rng(seed))
        assert loose.cell_of(rows)[0].tolist() == [0, 1]


@pytest.mark.parametrize("ends", [(1.0, np.nextafter(1.0, 2.0)), (6.5e6, 6.5e6 + 1e-8), (0.0, 5e-324)])
def test_bounds_between_any_numbers_divide_them(ends):
    rows = np.tile(np.array(ends)[:, None], (4, 1))
    scores = np.tile([0.0, 90.0], 4)
    columns = SplitColumns.of(rows, np.zeros(1, dtype=np.int64), np.ones(1, dtype=bool), scores)
    tree = TreeGrowth(columns, ScoreCells(scores, grid_of(scores), 0.5, 0.03)).trees()[0]
    assert [cell.tolist() for cell in tree.cells()] == [[0, 2, 4, 6], [1, 3, 5, 7]]


def test_rows_that_are_read_nowhere_belong_to_the_whole_node():
    rows = np.eye(3)[np.array([0, 1, 2] * 6)]
    parts = tuple((part, Tree(np.arange(part, 18, 3), 0.0)) for part in range(3))
    tree = Tree(np.arange(18), 0.0, Split(Names((0, 1, 2), np.eye(3)), (0.5, 1.5)), parts)
    number, cells = tree.cell_of(np.array([[0.0, 0.0, 1.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]]))
    assert [cells[index].tolist() for index in number] == [
        list(range(2, 18, 3)),
        list(range(18)),
        list(range(0, 18, 3)),
    ]
    assert np.array_equal(tree.cell_of(rows)[0], np.tile([0, 1, 2], 6))


def test_a_tree_that_reads_what_labels_do_not_have_is_a_cell():
    rows, _ = labelled(0)
    other = Tree(np.arange(60), 0.0, Split(Value(4), (0.5,)), ((0, Tree(np.arange(60), 0.0)),))
    rows[:, 4] = 1.0
    assert growth_of(rows, np.zeros(60)).trees(Others([other], rows))[0].split is None
