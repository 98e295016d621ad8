from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given

from grammarlab.errors import FacadeError
from grammarlab.facade.reading.cutting import cut
from grammarlab.facade.tree import LEAF, Facade, X, Y, laid_out, plain
from tests.facade.editing.neighbours import Neighbours, neighbours, tree_of
from tests.facade.strategies import trees


def graph_of_boxes(boxes: Sequence[Sequence[float]]) -> Neighbours:
    """Comparison of every pair of boxes (left, bottom, right, top), as a slow reference."""

    def pairs(along: int) -> np.ndarray:
        across = 1 - along
        found = [
            (i, j)
            for i, one in enumerate(boxes)
            for j, other in enumerate(boxes)
            if abs(one[2 + along] - other[along]) < 1e-6
            and min(one[2 + across], other[2 + across]) - max(one[across], other[across]) > 1e-6
        ]
        return np.array(found, dtype=np.int64).reshape(-1, 2)

    return Neighbours(np.arange(len(boxes)), pairs(X), pairs(Y))


def edges(pairs: np.ndarray) -> set[tuple[int, int]]:
    return {(one, other) for one, other in pairs.tolist()}


@given(trees())
def test_the_graph_is_that_of_all_pairs_and_leads_back_to_the_same_tree(facade: Facade) -> None:
    graph = neighbours(facade)
    low, size = facade.position[facade.leaves], facade.size[facade.leaves]
    expected = graph_of_boxes(np.hstack([low, low + size]).tolist())
    assert edges(graph.x_pairs) == edges(expected.x_pairs)
    assert edges(graph.y_pairs) == edges(expected.y_pairs)
    tree = tree_of(graph)
    assert tree.parent.tolist() == facade.parent.tolist()
    assert tree.axis.tolist() == facade.axis.tolist()
    assert graph.node[tree.leaf[tree.leaf >= 0]].tolist() == facade.leaves.tolist()


@given(trees())
def test_the_names_of_leaves_do_not_matter_to_the_way_back(facade: Facade) -> None:
    graph = neighbours(facade)
    shuffle = np.random.default_rng(0).permutation(len(graph.node))
    place = np.argsort(shuffle)
    tree = tree_of(Neighbours(graph.node[shuffle], place[graph.x_pairs], place[graph.y_pairs]))
    assert tree.parent.tolist() == facade.parent.tolist()
    assert graph.node[shuffle][tree.leaf[tree.leaf >= 0]].tolist() == facade.leaves.tolist()


PINWHEEL = [(0, 0, 2, 1), (2, 0, 3, 2), (1, 2, 3, 3), (0, 1, 1, 3), (1, 1, 2, 2)]
REFINED = [(0, 0, 1, 1), (1, 0, 2, 1), (2, 0, 3, 2), (1, 2, 3, 3), (0, 1, 1, 3), (1, 1, 2, 2)]


def test_a_pinwheel_names_its_boxes() -> None:
    with pytest.raises(FacadeError, match="Nodes 0, 1, 2, 3, 4 form a pinwheel"):
        tree_of(graph_of_boxes(PINWHEEL))


def test_a_pinwheel_with_one_box_cut_has_a_tree() -> None:
    graph = graph_of_boxes(REFINED)
    tree = tree_of(graph)
    wanted = np.ones((len(tree.parent), 2))
    boxes = np.array(REFINED, dtype=np.float64)
    inner = tree.leaf < 0
    wanted[~inner] = (boxes[:, 2:] - boxes[:, :2])[tree.leaf[~inner]]
    position, size = laid_out(tree.parent, tree.axis, wanted)
    assert np.allclose(np.hstack([position, position + size])[~inner], boxes[tree.leaf[~inner]])


def test_linking_a_source_to_all_neighbours_of_both_anchors_is_no_facade() -> None:
    """Figure 5: S between anchors 1 and 4, linked to all of their neighbours, is on both sides of 3."""
    anchor_left, below, between, anchor_right, source = range(5)
    beside = [(anchor_left, between), (between, anchor_right), (anchor_left, source), (source, anchor_right)]
    loop = [(source, between), (between, source), (source, below), (below, between)]
    with pytest.raises(FacadeError, match="contradict each other"):
        tree_of(Neighbours(np.arange(5), np.array(beside + loop), np.zeros((0, 2), dtype=np.int64)))


def test_a_sliver_beside_a_box_takes_over_its_left_neighbours() -> None:
    """Figure 6: N at the left of 8 is linked to 1 and 2 at its left, and to the leftmost above and below."""
    parent = np.array([-1, 0, 1, 1, 0, 4, 5, 5, 4, 8, 8, 4, 11, 11])
    axis = np.array([X, Y, LEAF, LEAF, Y, X, LEAF, LEAF, X, LEAF, LEAF, X, LEAF, LEAF], dtype=np.int8)
    wanted = np.ones((14, 2))
    wanted[9, X] = 1e-3
    name = {2: "1", 3: "2", 6: "6", 7: "7", 9: "N", 10: "8", 12: "4", 13: "5"}
    facade = plain(parent, axis, *laid_out(parent, axis, wanted), [name.get(node, "") for node in range(14)])
    graph = neighbours(facade)
    called = [facade.name_of(int(node)) for node in graph.node]
    beside = {(called[one], called[other]) for one, other in graph.x_pairs.tolist()}
    above = {(called[one], called[other]) for one, other in graph.y_pairs.tolist()}
    assert {edge for edge in beside if "N" in edge} == {("1", "N"), ("2", "N"), ("N", "8")}
    assert {edge for edge in above if "N" in edge} == {("N", "4"), ("6", "N")}


def test_one_leaf_and_ten_thousand() -> None:
    one = plain(np.array([-1]), np.array([LEAF]), np.zeros((1, 2)), np.ones((1, 2)), [""])
    assert tree_of(neighbours(one)).axis.tolist() == [LEAF]
    rows = 100
    floors = [np.append(0, np.full(rows, 1 + row * (rows + 1))) for row in range(rows)]
    parent = np.concatenate([[-1], *floors])
    axis = np.full(len(parent), LEAF, dtype=np.int8)
    axis[0], axis[1 :: rows + 1] = Y, X
    facade = plain(parent, axis, *laid_out(parent, axis, np.ones((len(parent), 2))), [""] * len(parent))
    graph = neighbours(facade)
    assert len(graph.x_pairs) == len(graph.y_pairs) == rows * (rows - 1)
    assert tree_of(graph).parent.tolist() == facade.parent.tolist()


def test_where_lines_cross_the_leaves_are_those_of_the_other_tree() -> None:
    """A window of four panes can be divided along both axes."""
    parent, axis = np.array([-1, 0, 1, 1, 0, 4, 4]), np.array([X, Y, LEAF, LEAF, Y, LEAF, LEAF], dtype=np.int8)
    sizes = np.array([[0, 0], [0, 0], [1, 3], [1, 4], [0, 0], [2, 3], [2, 4]], dtype=np.float64)
    facade = plain(parent, axis, *laid_out(parent, axis, sizes), [""] * 7)
    graph = neighbours(facade)
    tree = tree_of(graph)
    assert tree.axis.tolist() == [Y, X, LEAF, LEAF, X, LEAF, LEAF]
    low = facade.position[facade.leaves]
    again, _ = cut(low, low + facade.size[facade.leaves], ["pane"] * 4)
    assert again.axis.tolist() == tree.axis.tolist()
    assert again.parent.tolist() == tree.parent.tolist()
    node = np.where(tree.leaf >= 0, graph.node[tree.leaf], 0)
    position, size = laid_out(tree.parent, tree.axis, facade.size[node])
    leaves = tree.leaf >= 0
    assert np.allclose(position[leaves], facade.position[node[leaves]])
    assert np.allclose(size[leaves], facade.size[node[leaves]])
