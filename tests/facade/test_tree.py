from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.tree import LEAF, Facade, X, Y, check, laid_out, plain


@st.composite
def trees(draw: st.DrawFn, max_nodes: int = 40) -> Facade:
    """A random guillotine tree."""
    randomness = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    parent, axis = [-1], [LEAF]

    def divide(node: int, along: int, depth: int) -> None:
        if depth > 4 or len(parent) >= max_nodes or (depth and randomness.random() < 0.4):
            return
        axis[node] = along
        for _ in range(int(randomness.integers(2, 5))):
            parent.append(node)
            axis.append(LEAF)
            divide(len(parent) - 1, 1 - along, depth + 1)

    divide(0, int(randomness.integers(2)), draw(st.integers(0, 1)))
    wanted = randomness.uniform(0.1, 3.0, (len(parent), 2))
    position, size = laid_out(np.array(parent), np.array(axis, dtype=np.int8), wanted)
    names = [str(randomness.choice(["wall", "window", ""])) if each == LEAF else "" for each in axis]
    return plain(np.array(parent), np.array(axis, dtype=np.int8), position, size, names)


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
