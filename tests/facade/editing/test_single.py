from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.edit_sequences import sequences
from grammarlab.facade.editing.grids import grid_of, with_grid
from grammarlab.facade.editing.variations import Edit, Variation, applied, edits, unedited, vary
from grammarlab.facade.grid import Grid
from grammarlab.facade.tree import Facade, X, Y, check
from tests.facade.editing.neighbours import neighbours
from tests.facade.gridded import gridded, same_topology, transposed
from tests.facade.samples import across, built, leaf, stacked, windows

axes = st.sampled_from([X, Y])


def lines(grid: Grid, axis: int) -> np.ndarray:
    return grid.places().T if axis == X else grid.places()


def names(facade: Facade, nodes: np.ndarray) -> list[str]:
    return [facade.name_of(node) if node >= 0 else "-" for node in nodes.tolist()]


def line_names(facade: Facade, grid: str, axis: int) -> list[list[str]]:
    return [names(facade, line) for line in lines(grid_of(facade, grid), axis)]


def same_facade(one: Facade, other: Facade) -> None:
    assert same_topology(one, other)
    assert np.allclose(one.position, other.position, rtol=0, atol=1e-9 * one.size[0].max())
    assert np.allclose(one.size, other.size, rtol=1e-9)
    assert np.array_equal(one.label, other.label)
    assert [(g.name, g.node.tolist(), g.row.tolist(), g.column.tolist()) for g in one.grids] == [
        (g.name, g.node.tolist(), g.row.tolist(), g.column.tolist()) for g in other.grids
    ]


@given(gridded(), axes)
def test_each_variation_is_a_facade_with_one_line_more_or_less_and_other_grids_as_they_were(
    facade: Facade, axis: int
) -> None:
    before = grid_of(facade, "one")
    other = grid_of(facade, "two")
    for variation in vary(facade, "one", axis, also=[]).variations:
        check(variation.facade)
        areas = variation.facade.size[variation.facade.leaves].prod(axis=1)
        assert np.isclose(areas.sum(), variation.facade.width * variation.facade.height)
        (edit,) = variation.edits
        after = grid_of(variation.facade, "one")
        old, new = lines(before, axis), lines(after, axis)
        if edit.position is None:
            assert len(new) <= len(old) - 1
            continue
        assert len(new) == len(old) + 1
        kept = np.delete(new, edit.position, axis=0)
        assert np.array_equal(np.where(kept < 0, -1, variation.source[kept]), old)
        line = new[edit.position]
        assert np.array_equal(variation.source[line[line >= 0]], old[edit.line][line >= 0])
        assert variation.missing or ((line < 0) == (old[edit.line] < 0)).all()
        same = grid_of(variation.facade, "two")
        assert variation.source[same.node].tolist() == other.node.tolist()
        assert (same.row.tolist(), same.column.tolist()) == (other.row.tolist(), other.column.tolist())


@given(gridded(), axes)
def test_new_elements_stand_between_their_anchors(facade: Facade, axis: int) -> None:
    for variation in vary(facade, "one", axis, also=[], removals=False).variations:
        middle = variation.facade.position[:, axis] + variation.facade.size[:, axis] / 2
        place = variation.edits[0].position
        assert place is not None
        new = lines(grid_of(variation.facade, "one"), axis)
        for cross in range(new.shape[1]):
            near = [new[at, cross] for at in (place - 1, place, place + 1) if 0 <= at < len(new)]
            if new[place, cross] >= 0:
                along = np.diff(middle[near]) if axis == X else -np.diff(middle[near])
                assert (along > 0).all()


@given(gridded(), axes)
def test_what_is_inserted_and_removed_leaves_no_trace(facade: Facade, axis: int) -> None:
    start = unedited(facade)
    for edit in edits(facade, ["one"], axis):
        if edit.position is None:
            continue
        try:
            more = applied(start, edit)
        except FacadeError:
            continue
        less = applied(more, Edit(("one",), axis, edit.position))
        same_facade(less.facade, facade)
        assert less.source.tolist() == list(range(len(facade)))


@given(gridded())
def test_rows_are_columns_of_the_facade_turned_about_its_diagonal(facade: Facade) -> None:
    upright, lying = unedited(transposed(facade)), unedited(facade)
    num_rows = grid_of(facade, "one").num_rows
    for line in range(num_rows):
        for place in (None, *range(num_rows + 1)):
            other = Edit(("one",), X, num_rows - 1 - line, None if place is None else num_rows - place)
            try:
                row = applied(lying, Edit(("one",), Y, line, place))
            except FacadeError:
                with pytest.raises(FacadeError):
                    applied(upright, other)
                continue
            column = applied(upright, other)
            same_facade(transposed(column.facade), row.facade)
            assert column.source.tolist() == row.source.tolist()
            assert np.array_equal(column.visible[:, [1, 0, 3, 2]], row.visible)


def test_there_is_a_variation_for_each_different_column_at_each_place() -> None:
    facade = windows(3, 4, (1.0, 2.0, 3.0, 1.0))
    found = vary(facade, "window", X, removals=False)
    assert len(found.variations) == 3 * 5
    assert found.discarded == ()
    assert {(each.edits[0].line, each.edits[0].position) for each in found.variations} == {
        (line, place) for line in range(3) for place in range(5)
    }
    assert len(vary(facade, "window", X, insertions=False).variations) == 4
    assert len(vary(facade, "window", Y, removals=False).variations) == 1 * 4


@pytest.mark.parametrize("bays", [False, True])
def test_all_sequences_of_columns_are_those_of_a_list(bays: bool) -> None:
    """Brute force: a wall of columns is a list, an insertion copies one of its items."""

    def widths(variation: Variation) -> tuple[float, ...]:
        first_row = grid_of(variation.facade, "window").places()[0]
        return tuple(variation.target[first_row, X].tolist())

    start = (1.0, 2.0, 4.0)
    expected = {start}
    for _ in range(2):
        expected = {
            (*each[:place], item, *each[place:])
            for each in expected
            for item in set(each)
            for place in range(len(each) + 1)
        }
    facade = windows(2, 3, start, bays=bays)
    found = sequences(facade, "window", X, 2)
    assert sorted(widths(each) for each in found) == sorted(expected)
    for each in found:
        assert np.isclose(each.facade.width, sum(widths(each)) + 0.5 * (len(widths(each)) + 1))
        assert np.isclose(each.facade.height, facade.height)
    fewer = sequences(facade, "window", X, -2)
    assert sorted(widths(each) for each in fewer) == [(1.0,), (2.0,), (4.0,)]
    assert sequences(facade, "window", X, 0)[0].facade is facade


@pytest.mark.parametrize("bays", [False, True])
@pytest.mark.parametrize("axis", [X, Y])
def test_even_a_facade_without_memory_returns_to_its_sizes(axis: int, bays: bool) -> None:
    facade = windows(3, 4, (1.0, 2.0, 3.0), bays=bays)
    for variation in vary(facade, "window", axis, removals=False).variations:
        place = variation.edits[0].position
        assert place is not None
        assert variation.facade.size[0, axis] > facade.size[0, axis]
        same_facade(applied(unedited(variation.facade), Edit(("window",), axis, place)).facade, facade)


@pytest.mark.parametrize("facade", [windows(2, 3, (1.0, 2.0, 3.0)), windows(2, 3, (1.0, 2.0, 3.0), bays=True)])
def test_a_copy_has_the_neighbours_of_its_source_and_of_its_anchors(facade: Facade) -> None:
    """Figure 5: the paper's links of S, without its contradictions."""

    def around(wall: Facade) -> dict[int, set[tuple[int, int, int]]]:
        graph = neighbours(wall)
        links: dict[int, set[tuple[int, int, int]]] = {node: set() for node in graph.node.tolist()}
        for along, pairs in ((X, graph.node[graph.x_pairs]), (Y, graph.node[graph.y_pairs])):
            for one, other in pairs.tolist():
                links[one].add((along, 1, other))
                links[other].add((along, 0, one))
        return links

    before = around(facade)
    for variation in vary(facade, "window", X, removals=False).variations:
        edit, after = variation.edits[0], around(variation.facade)
        old, new = (grid_of(wall, "window").places() for wall in (facade, variation.facade))
        assert edit.position is not None
        for row in range(2):
            anchors = old[row, max(edit.position - 1, 0) : edit.position + 1].tolist()
            allowed = set().union(*(before[node] for node in [*anchors, int(old[row, edit.line])]))
            if edit.position in {0, 3}:
                # At the ends the gap between the nearest two columns is repeated.
                allowed |= before[int(old[row, 1])]
            found = {
                (along, side, int(variation.source[node])) for along, side, node in after[int(new[row, edit.position])]
            }
            assert found <= allowed
            assert {(along, side) for along, side, _ in found} == {(X, 0), (X, 1), (Y, 0), (Y, 1)}


def links(facade: Facade) -> dict[int, set[tuple[str, int]]]:
    """For each leaf, its neighbours and their sides."""
    graph = neighbours(facade)
    found: dict[int, set[tuple[str, int]]] = {node: set() for node in graph.node.tolist()}
    sides = (("right", "left", graph.x_pairs), ("above", "below", graph.y_pairs))
    for ahead, behind, pairs in sides:
        for one, other in graph.node[pairs].tolist():
            found[one].add((ahead, other))
            found[other].add((behind, one))
    return found


def test_an_insertion_links_a_copy_as_the_edges_of_the_paper_do() -> None:
    """Figure 6: N at the left of 8 takes over 1 and 2 from it, and is linked to the leftmost leaves above and below.

    The paper adds one edge after the other to the graph; here a subtree is placed, with the same edges.
    """
    left = stacked(leaf("1", 1, 1.5), leaf("2", 1, 1.5))
    lower, upper = across(leaf("6"), leaf("7")), across(leaf("4"), leaf("5"))
    facade = built(across(left, stacked(lower, across(leaf("8"), leaf("9")), upper)))
    node = {facade.name_of(each): each for each in facade.leaves.tolist()}
    facade = with_grid(facade, "row", [node["8"], node["9"]])
    for edit, expected in (
        (Edit(("row",), X, 0, 0), {("left", "1"), ("left", "2"), ("right", "8"), ("above", "4"), ("below", "6")}),
        (Edit(("row",), X, 1, 0), {("left", "1"), ("left", "2"), ("right", "8"), ("above", "4"), ("below", "6")}),
        # At the far end everything is mirrored, except that nothing is beyond it.
        (Edit(("row",), X, 1, 2), {("left", "9"), ("above", "5"), ("below", "7")}),
    ):
        wall = applied(unedited(facade), edit).facade
        new = grid_of(wall, "row").node.tolist()[edit.position or 0]
        assert {(side, wall.name_of(other)) for side, other in links(wall)[new]} == expected
        # Only the copy was added, and all other edges are unchanged.
        assert len(wall.leaves) == len(facade.leaves) + 1


def test_one_copy_of_the_surroundings_serves_all_rows_of_one_parent() -> None:
    """Coupled insertion: the parts between the rows of bays are repeated once, not once for each row."""
    facade = windows(3, 2, (1.0, 2.0), bays=True)
    wall = applied(unedited(facade), Edit(("window",), X, 0, 1)).facade
    bay = facade.children[int(facade.children[0][1])]
    gap = 1
    assert len(wall.leaves) == len(facade.leaves) + len(bay) + gap
    new = grid_of(wall, "window").places()[:, 1].tolist()
    found = links(wall)
    for upper, lower in pairwise(new):
        # A wall between two new windows is above the one and below the other.
        between = {each for side, each in found[lower] if side == "above"}
        assert between == {each for side, each in found[upper] if side == "below"}
        assert len(between) == 1


def test_the_surroundings_come_along_and_bands_are_stretched() -> None:
    """Figure 4: a part over both anchors stays one piece; the wall between them is on both sides of S."""
    facade = windows(1, 2, (1.0, 2.0))
    (variation,) = [
        v
        for v in vary(facade, "window", X, removals=False).variations
        if str(v.edits[0]).endswith("1 repeated after column 1")
    ]
    wall = variation.facade
    row = wall.children[int(wall.children[0][1])]
    assert names(wall, row) == ["wall", "window", "wall", "window", "wall", "window", "wall"]
    assert variation.source[row].tolist() == [3, 4, 5, 4, 5, 6, 7]
    assert variation.source[wall.children[0]].tolist() == [1, 2, 8]
    assert np.allclose(wall.size[wall.children[0], X], facade.width + 1.5)


def test_a_source_in_bays_brings_what_is_above_and_below_it() -> None:
    facade = windows(2, 2, (1.0, 2.0), bays=True)
    wall = applied(unedited(facade), Edit(("window",), X, 1, 0)).facade
    bays = [names(wall, wall.children[int(child)]) for child in wall.children[0] if wall.axis[child] == Y]
    assert bays == [["wall", "window", "wall", "window", "wall"]] * 3
    assert np.isclose(wall.height, facade.height)


def test_what_cannot_be_edited_is_explained() -> None:
    facade = windows(2, 3)
    with pytest.raises(FacadeError, match="expected one of: window"):
        vary(facade, "door", X)
    two = with_grid(facade, "first", grid_of(facade, "window").node[:2])
    with pytest.raises(FacadeError, match="the same number of columns"):
        vary(two, "window", X, also=["first"])
    alone = with_grid(built(leaf("window")), "window", [0])
    found = vary(alone, "window", X)
    assert [grid.num_columns for variation in found.variations for grid in variation.facade.grids] == [2, 2]
    with pytest.raises(FacadeError, match="remove the whole facade"):
        applied(unedited(alone), Edit(("window",), X, 0))


def test_a_facade_that_is_too_deep_is_refused_and_one_of_a_hundred_levels_is_edited() -> None:
    def nested(levels: int) -> Facade:
        inner = leaf("window", 1.0, 1.0)
        for level in range(levels):
            inner = (across if level % 2 else stacked)(inner, leaf("wall"))
        facade = built(inner)
        return with_grid(facade, "window", [node for node in facade.leaves if facade.name_of(node) == "window"])

    assert vary(nested(150), "window", X).variations
    with pytest.raises(FacadeError, match="201 levels of nested parts; expected at most 200"):
        vary(nested(201), "window", X)
