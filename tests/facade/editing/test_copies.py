from dataclasses import replace

import numpy as np
from hypothesis import given

from grammarlab.facade.editing.pieces import NEW, take
from grammarlab.facade.tree import LEAF, Facade, Picture, X, check
from tests.facade.samples import across, built, leaf
from tests.facade.strategies import trees


@given(trees())
def test_a_facade_of_copies_of_all_its_nodes_is_itself(facade: Facade) -> None:
    same = check(take(facade, facade.parent, facade.axis, np.arange(len(facade))))
    for column in ("position", "size", "label", "window", "picture"):
        assert np.allclose(getattr(same, column), getattr(facade, column))


def test_copies_have_outlines_and_parts_of_pictures_and_new_nodes_have_neither() -> None:
    first = built(across(leaf("arch", 1), leaf("door", 2)))
    first = replace(
        first,
        outline_offsets=np.array([0, 0, 3, 3]),
        outline_points=np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]]),
        pictures=(Picture("a.png", b""),),
        picture=np.array([-1, 0, 0]),
        window=np.array([[0, 0, 1, 1], [0, 0, 0.5, 1], [0.5, 0, 1, 1.0]]),
    )
    shown = np.array([[0, 0, 1, 1], [0, 0, 1, 1], [0.5, 0, 1, 0.5], [0, 0, 1, 1]])
    parent, axis = np.array([-1, 0, 0, 0]), np.array([X, LEAF, LEAF, LEAF], dtype=np.int8)
    copy = check(take(first, parent, axis, np.array([NEW, 2, 1, 1]), visible=shown))
    assert [copy.name_of(node) for node in range(4)] == ["", "door", "arch", "arch"]
    assert [len(copy.outline(node)) for node in range(4)] == [0, 0, 3, 3]
    assert copy.picture.tolist() == [-1, 0, 0, 0]
    assert copy.window[2].tolist() == [0.25, 0, 0.5, 0.5]
    assert copy.size[:, X].tolist() == [4, 2, 1, 1]
