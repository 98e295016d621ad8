from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import LEAF, Facade, X, Y, check, laid_out, plain
from tests.facade.strategies import trees


@given(trees())
def test_what_is_laid_out_decomposes_and_its_leaves_tile_it(facade: Facade) -> None:
    check(facade)
    areas = facade.size[facade.leaves].prod(axis=1)
    assert np.isclose(areas.sum(), facade.width * facade.height)


@given(trees())
def test_a_subtree_is_one_piece(facade: Facade) -> None:
    for node in range(len(facade)):
        inside = {node}
        for other in range(node + 1, len(facade)):
            if int(facade.parent[other]) in inside:
                inside.add(other)
        assert inside == set(range(node, facade.end[node]))
        assert facade.children[node].tolist() == [n for n in range(len(facade)) if facade.parent[n] == node]


def test_sizes_that_fit_are_kept() -> None:
    parent, axis = np.array([-1, 0, 0, 2, 2]), np.array([X, LEAF, Y, LEAF, LEAF], dtype=np.int8)
    _, size = laid_out(parent, axis, np.array([[0, 0], [1, 4], [0, 0], [2, 1], [2, 3]], dtype=np.float64))
    assert size.tolist() == [[3, 4], [1, 4], [2, 4], [2, 1], [2, 3]]


def two() -> Facade:
    return plain(
        np.array([-1, 0, 0]),
        np.array([X, LEAF, LEAF], dtype=np.int8),
        np.array([[0, 0], [0, 0], [1, 0]], dtype=np.float64),
        np.array([[3, 2], [1, 2], [2, 2]], dtype=np.float64),
        ["", "wall", "window"],
    )


@pytest.mark.parametrize(
    ("column", "value", "says"),
    [
        ("size", [[3, 2], [1, 2], [2.1, 2]], "The parts of node 0 miss its width by 0.0333"),
        ("size", [[3, 2], [1, 2], [2, 1.5]], "miss its height"),
        ("size", [[3, 2], [1, 2], [2, 0]], "Node 2: expected a width and height above 0"),
        ("size", [[3, 2], [1, 2], [2, np.nan]], "finite"),
        ("position", [[0, 0], [0, 0], [1.5, 0]], "miss its width"),
        ("parent", [-1, 0, 2], "earlier nodes"),
        ("parent", [-1, 0, 1], "Node 0: axis 0 with 1 parts"),
        ("label", [-1, 0, 2], "indices below 2"),
        ("axis", [LEAF, LEAF], "expected shape"),
    ],
)
def test_what_is_no_facade_is_explained(column: str, value: list[object], says: str) -> None:
    check(two())
    with pytest.raises(FacadeError, match=says):
        check(replace(two(), **{column: np.array(value)}))
