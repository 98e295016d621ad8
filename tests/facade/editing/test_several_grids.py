"""Facades with wings, doors over several rows, and several grids at once: Figures 8 and 10 to 13."""

from collections import Counter
from dataclasses import replace

import numpy as np

from grammarlab.facade.editing.edit_sequences import distinct
from grammarlab.facade.editing.grid_proposals import with_proposals
from grammarlab.facade.editing.grids import grid_of, kinds, with_grid
from grammarlab.facade.editing.variations import Edit, applied, unedited, vary
from grammarlab.facade.tree import Facade, Picture, X, Y, check
from tests.facade.editing.test_single import line_names, names
from tests.facade.samples import Node, across, built, door_over_two_rows, leaf, stacked


def two_wings() -> Facade:
    """Two walls of two rows and columns of windows side by side, and a grid over both."""

    def wing() -> Node:
        floor = across(*[leaf("wall", 0.5), leaf("window")] * 2, leaf("wall", 0.5))
        return stacked(leaf("wall", 3.5), floor, leaf("wall", 3.5), floor)

    facade = built(across(wing(), wing()))
    return with_grid(facade, "window", [node for node in facade.leaves if facade.name_of(node) == "window"])


def test_two_wings_are_widened_between_them_by_what_belongs_to_one_column() -> None:
    facade = two_wings()
    wall = applied(unedited(facade), Edit(("window",), X, 0, 2)).facade
    assert len(wall.children[0]) == 3
    assert grid_of(wall, "window").num_columns == 5
    assert np.isclose(wall.width, 2 * 3.5 + 2.0)


def test_no_row_of_a_phantom_is_widened_and_all_others_are() -> None:
    """Figures 8 and 11: nothing can be inserted beside the place above a door."""
    facade = door_over_two_rows()
    elements = [node for node in range(len(facade)) if facade.name_of(node) in {"window", "door"}]
    facade = with_grid(facade, "all", elements)
    variation = applied(unedited(facade), Edit(("all",), X, 0, 1))
    assert variation.missing == (
        "all: column 1 repeated after column 1: nothing in row 2 of all, the place beside it is empty",
    )
    wall = variation.facade
    assert [names(wall, row) for row in grid_of(wall, "all").places()] == [
        ["window", "window", "window", "window"],
        ["window", "-", "-", "window"],
        ["window", "window", "door", "window"],
    ]
    counts = Counter(names(wall, np.arange(len(wall))))
    assert (counts["window"], counts["door"]) == (7 + 2, 1)


def test_doors_are_repeated_with_their_phantom() -> None:
    facade = door_over_two_rows()
    elements = [node for node in range(len(facade)) if facade.name_of(node) in {"window", "door"}]
    facade = with_grid(facade, "all", elements)
    variation = applied(unedited(facade), Edit(("all",), X, 1, 3))
    column = grid_of(variation.facade, "all").places()[:, 3]
    assert names(variation.facade, column) == ["window", "-", "door"]
    assert variation.missing == ()
    assert np.isclose(variation.facade.height, facade.height)


def hierarchical() -> Facade:
    """Two rows of three windows of two panes: one grid of windows, and one grid in each of them."""

    def window() -> Node:
        return across(leaf("pane", 0.5, 1.5), leaf("pane", 0.5, 1.5), label="window")

    def bay() -> Node:
        return stacked(leaf("wall"), window(), leaf("wall"), window(), leaf("wall"))

    gap = leaf("wall", 0.5, 6)
    return with_proposals(built(across(gap, bay(), gap, bay(), gap, bay(), gap)))


def test_outer_and_inner_grids_are_edited_apart_and_together() -> None:
    """Figure 10."""
    facade = hierarchical()
    assert len(facade.grids) == 1 + 6
    panes = facade.name_of(int(facade.grids[1].node[0]))
    assert panes == "pane"
    outer = applied(unedited(facade), Edit(("window",), X, 0, 1))
    assert grid_of(outer.facade, "window").num_columns == 4
    assert [grid.num_columns for grid in outer.facade.grids[1:]] == [2] * 8
    (inner,) = distinct(vary(facade, "pane", X, removals=False).variations, kinds(facade))
    assert len(inner.edits[0].grids) == 6
    assert [grid.num_columns for grid in inner.facade.grids] == [3] + [3] * 6
    both = applied(inner, Edit(("window",), X, 0, 1))
    assert [grid.num_columns for grid in both.facade.grids] == [4] + [3] * 8
    assert both.steps[-1] == "window: column 1 repeated after column 1"
    check(both.facade)


def test_unlike_elements_of_one_grid_are_repeated_row_by_row() -> None:
    """Figure 12: each row gets its own kind of element in a new column, and any row can be repeated."""
    gap = leaf("wall", 0.5)
    rows = [
        across(gap, *[part for _ in range(3) for part in (leaf(label), gap)]) for label in ("door", "arch", "window")
    ]
    facade = built(stacked(*[part for row in rows for part in (row, leaf("wall", 5))]))
    elements = [node for node in facade.leaves if facade.name_of(node) != "wall"]
    facade = with_grid(facade, "all", elements)
    column = applied(unedited(facade), Edit(("all",), X, 1, 2)).facade
    assert line_names(column, "all", Y) == [["window"] * 4, ["arch"] * 4, ["door"] * 4]
    rows_of = {
        tuple(each[0] for each in line_names(v.facade, "all", Y))
        for v in vary(facade, "all", Y, removals=False).variations
    }
    start = ["window", "arch", "door"]
    assert rows_of == {(*start[:p], item, *start[p:]) for item in start for p in range(4)}


def test_small_grids_are_edited_while_others_are_only_stretched() -> None:
    """Figures 8 and 13: three steps, each with another active grid."""
    gap = leaf("wall", 0.5)
    upper = across(gap, leaf("window"), gap, leaf("window"), gap)
    lower = across(gap, leaf("shop", 2), gap, leaf("door"), gap)
    facade = built(stacked(lower, leaf("wall", 4), upper, leaf("wall", 4), upper))
    for name in ("window", "shop", "door"):
        facade = with_grid(facade, name, [node for node in facade.leaves if facade.name_of(node) == name])
    variation = unedited(facade)
    for edit in (Edit(("window",), X, 0, 2), Edit(("shop",), X, 0, 0), Edit(("window",), Y, 0, 1)):
        variation = applied(variation, edit)
    shapes = {grid.name: (grid.num_rows, grid.num_columns) for grid in variation.facade.grids}
    assert shapes == {"window": (3, 3), "shop": (1, 2), "door": (1, 1)}
    assert variation.steps == (
        "window: column 1 repeated after column 2",
        "shop: column 1 repeated before column 1",
        "window: row 1 repeated after row 1",
    )


def test_cut_copies_show_their_part_of_the_picture() -> None:
    facade, cut = two_wings(), 0
    facade = replace(facade, pictures=(Picture("wall.png", b""),), picture=np.zeros(len(facade), dtype=np.int64))
    low, high = facade.position / facade.size[0], (facade.position + facade.size) / facade.size[0]
    facade = replace(facade, window=np.hstack([low, high]))
    for variation in vary(facade, "window", X).variations + vary(facade, "window", Y).variations:
        wall, first = variation.facade, facade.window[variation.source]
        expected = np.hstack(
            [
                first[:, :2] + variation.visible[:, :2] * (first[:, 2:] - first[:, :2]),
                first[:, :2] + variation.visible[:, 2:] * (first[:, 2:] - first[:, :2]),
            ]
        )
        assert np.allclose(wall.window[wall.leaves], expected[wall.leaves])
        cut += int((variation.visible != [0, 0, 1, 1]).any(axis=1).sum())
    assert cut
