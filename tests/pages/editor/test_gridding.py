"""What clicks and rectangles do to grids."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.grids import grid_of, is_background, topmost
from grammarlab.facade.tree import Facade
from grammarlab.pages.editor.commands import pressed, renamed, with_lasso, with_pressed
from tests.facade.gridded import gridded
from tests.facade.samples import across, built, leaf, stacked, windows


@given(gridded(), st.data())
def test_a_second_press_on_the_same_leaf_undoes_the_first(facade: Facade, data: st.DataObject):
    leaf_node = int(data.draw(st.sampled_from(facade.leaves.tolist())))
    grid = grid_of(facade, "one")
    once = with_pressed(facade, "one", leaf_node)
    changed = pressed(facade, "one", leaf_node)
    left = set(grid.node.tolist()) ^ {changed}
    assert changed <= leaf_node < facade.end[changed]
    if not left:
        assert "one" not in [each.name for each in once.grids]
        return
    assert set(grid_of(once, "one").node.tolist()) == left
    if pressed(once, "one", leaf_node) == changed:
        again = with_pressed(once, "one", leaf_node)
        assert np.array_equal(grid_of(again, "one").node, grid.node)


@given(gridded(), st.data())
def test_a_lasso_takes_what_a_look_at_each_node_takes(facade: Facade, data: st.DataObject):
    low, high = (np.array([data.draw(st.floats(-1.0, 9.0)) for _ in range(2)]) for _ in range(2))
    corners = np.sort([low, high], axis=0)
    slack = 1e-9 * facade.size[0]
    inside = [
        bool((facade.position[node] >= corners[0] - slack).all())
        and bool((facade.position[node] + facade.size[node] <= corners[1] + slack).all())
        and not is_background(facade)[node]
        for node in range(len(facade))
    ]
    expected = topmost(facade, np.array(inside))
    if not expected.size:
        with pytest.raises(FacadeError, match="No element is inside"):
            with_lasso(facade, low, high)
        return
    made, name = with_lasso(facade, low, high)
    assert np.array_equal(grid_of(made, name).node, expected)
    assert made.grids[:-1] == facade.grids
    assert len({grid.name for grid in made.grids}) == len(made.grids)


def test_a_press_within_a_window_of_parts_means_the_window():
    facade = built(
        across(
            stacked(leaf("pane"), leaf("pane"), label="window"),
            leaf("wall"),
            stacked(leaf("pane"), leaf("pane"), label="window"),
        )
    )
    one, two = (int(each) for each in np.flatnonzero(facade.label == facade.labels.index("window")))
    made, name = with_lasso(facade, [0.0, 0.0], [1.0, 9.0])
    assert name == "window"
    both = with_pressed(made, name, two + 1)
    assert grid_of(both, name).node.tolist() == [one, two]
    assert grid_of(with_pressed(both, name, one + 2), name).node.tolist() == [two]


@pytest.mark.parametrize("name", ["", "  ", "two"])
def test_no_two_grids_get_one_name(name: str):
    facade = windows(2, 3)
    grid = facade.grids[0]
    made, other = with_lasso(facade, [0.0, 0.0], [3.0, 9.0])
    made = renamed(made, other, " two ")
    assert [each.name for each in made.grids] == [grid.name, "two"]
    with pytest.raises(FacadeError, match="no other grid"):
        renamed(made, grid.name, name)


def test_what_is_not_there_is_explained():
    facade = windows(2, 3)
    with pytest.raises(FacadeError, match="expected 0 to"):
        pressed(facade, facade.grids[0].name, len(facade))
    with pytest.raises(FacadeError, match="Unknown grid 'no'"):
        with_pressed(facade, "no", 1)
