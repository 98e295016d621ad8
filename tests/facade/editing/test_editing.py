import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.grid_proposals import with_proposals
from grammarlab.facade.editing.grids import (
    aligned,
    arranged,
    following,
    grid_of,
    lasso,
    lines,
    toggled,
    with_grid,
    without_grid,
)
from grammarlab.facade.tree import Facade, X, Y
from tests.facade.gridded import enclosing
from tests.facade.samples import Node, across, built, door_over_two_rows, leaf, stacked, windows
from tests.facade.strategies import trees


def called(facade: Facade, name: str) -> np.ndarray:
    return np.array([node for node in range(len(facade)) if facade.name_of(node) == name])


@given(st.lists(st.tuples(st.integers(0, 20), st.integers(1, 8)), min_size=1, max_size=12))
def test_intervals_of_a_line_overlap_pairwise_and_lines_follow_each_other(intervals: list[tuple[int, int]]) -> None:
    low = np.array([start for start, _ in intervals], dtype=np.float64)
    high = low + [size for _, size in intervals]
    line = lines(low, high)
    for one in range(len(low)):
        for other in range(len(low)):
            if line[one] == line[other]:
                assert min(high[one], high[other]) > max(low[one], low[other])
            elif line[one] < line[other]:
                assert low[one] < high[other]
    assert sorted(set(line.tolist())) == list(range(int(line.max()) + 1))


def test_intervals_that_overlap_with_one_line_only_are_swept_as_in_the_paper() -> None:
    low, high = np.array([0.0, 5.0, 0.4, 5.2, 9.0]), np.array([1.0, 6.0, 1.5, 5.9, 9.5])
    assert lines(low, high).tolist() == [0, 1, 0, 1, 2]


@given(trees())
def test_no_two_leaves_of_a_facade_share_a_place(facade: Facade) -> None:
    grid = arranged(facade, "all", facade.leaves)
    places = grid.places()
    assert sorted(places[places >= 0].tolist()) == facade.leaves.tolist()
    assert (places >= 0).any(axis=0).all()
    assert (places >= 0).any(axis=1).all()


def test_rows_count_from_the_top_and_columns_from_the_left() -> None:
    facade = windows(2, 3)
    places = grid_of(facade, "window").places()
    assert places.shape == (2, 3)
    assert (np.diff(facade.position[places, X], axis=1) > 0).all()
    assert (np.diff(facade.position[places, Y], axis=0) < 0).all()


def test_a_door_over_two_rows_has_the_lower_one_and_leaves_a_phantom() -> None:
    """Figure 11."""
    facade = with_grid(
        door_over_two_rows(), "all", np.concatenate([called(door_over_two_rows(), name) for name in ("window", "door")])
    )
    places = grid_of(facade, "all").places()
    assert [[facade.name_of(node) if node >= 0 else "-" for node in row] for row in places.tolist()] == [
        ["window", "window", "window"],
        ["window", "-", "window"],
        ["window", "door", "window"],
    ]


def test_unlike_elements_at_uneven_distances_have_phantoms_between() -> None:
    """Figure 3a."""
    upper = across(leaf("a", 1), leaf("wall", 3), leaf("b", 2))
    lower = across(leaf("c", 1.5), leaf("wall", 1), leaf("d", 0.5), leaf("wall", 1.2), leaf("e", 1.8))
    facade = built(stacked(lower, leaf("wall", 6, 1), upper))
    facade = with_grid(
        facade, "all", np.flatnonzero([facade.name_of(n) not in {"wall", ""} for n in range(len(facade))])
    )
    names = [[facade.name_of(n) if n >= 0 else "-" for n in row] for row in grid_of(facade, "all").places().tolist()]
    assert names == [["a", "-", "b"], ["c", "d", "e"]]


def three_levels() -> Facade:
    def sash() -> Node:
        return stacked(leaf("glass", 0.4, 0.5), leaf("glass", 0.4, 0.5), label="sash")

    def window() -> Node:
        return across(sash(), leaf("wall", 0.05, 1), sash(), label="window")

    floor = across(leaf("wall", 1), window(), leaf("wall", 1), window(), leaf("wall", 1), window(), leaf("wall", 1))
    return built(stacked(leaf("wall", 7, 1), floor, leaf("wall", 7, 1), floor, leaf("wall", 7, 1)))


def test_grids_within_elements_of_grids_are_subgrids() -> None:
    """Figures 3b and 10: windows, their sashes, the panes of these."""
    facade = with_proposals(three_levels())
    above = enclosing(facade)
    assert [grid.name for grid in facade.grids[:3]] == ["window", "sash", "sash 2"]
    assert len(facade.grids) == 1 + 6 + 12
    depth = [0] * len(above)
    for inner, outer in enumerate(above.tolist()):
        depth[inner] = 0 if outer < 0 else depth[outer] + 1
    assert [depth.count(level) for level in range(3)] == [1, 6, 12]
    assert set(following(facade, "sash")) == {f"sash {number}" for number in range(2, 7)}
    assert following(facade, "window") == ()


def test_proposals_are_grids_of_at_least_two_and_share_no_node() -> None:
    facade = with_proposals(windows(3, 4))
    assert [(grid.name, grid.num_rows, grid.num_columns) for grid in facade.grids] == [("window", 3, 4)]
    assert with_proposals(built(leaf("window", 1))).grids == ()


@given(trees())
def test_proposals_hold_for_any_tree(facade: Facade) -> None:
    facade = with_proposals(facade)
    for grid in facade.grids:
        assert len(grid.node) >= 2
        assert len({facade.name_of(node) for node in grid.node.tolist()}) == 1
    assert len({grid.name for grid in facade.grids}) == len(facade.grids)


def test_many_small_grids_of_sizes_that_do_not_fit_together() -> None:
    """Figure 13: elements of one label without a common grid are grouped by size."""
    tall = across(
        leaf("wall", 1, 3), leaf("window", 1, 3), leaf("wall", 2, 3), leaf("window", 1, 3), leaf("wall", 5, 3)
    )
    flat = across(leaf("wall", 7, 1), leaf("window", 1.4, 1), leaf("wall", 0.2, 1), leaf("window", 1.4, 1))
    facade = with_proposals(built(stacked(tall, leaf("wall", 10, 1), flat)))
    assert sorted((grid.num_rows, grid.num_columns) for grid in facade.grids) == [(1, 2), (1, 2)]


def test_elements_are_taken_and_given_by_hand() -> None:
    facade = windows(2, 3)
    first = int(grid_of(facade, "window").node[0])
    fewer = toggled(facade, "window", [first])
    assert first not in grid_of(fewer, "window").node
    assert np.array_equal(grid_of(toggled(fewer, "window", [first]), "window").node, grid_of(facade, "window").node)
    assert toggled(facade, "window", grid_of(facade, "window").node).grids == ()
    assert without_grid(facade, "window").grids == ()


def test_a_lasso_takes_what_lies_wholly_inside() -> None:
    facade = windows(2, 3)
    window = called(facade, "window")
    assert lasso(facade, [0, 0], facade.size[0]).tolist() == window.tolist()
    box = window[0]
    low, high = facade.position[box], facade.position[box] + facade.size[box]
    assert lasso(facade, high, low).tolist() == [box]
    assert lasso(facade, low + 0.1, high).tolist() == []
    assert set(lasso(facade, [0, 0], facade.size[0], "wall")) == set(called(facade, "wall").tolist())


@pytest.mark.parametrize("nodes", [[], [-1], [10**6], [0, 1]])
def test_what_is_no_grid_is_explained(nodes: list[int]) -> None:
    with pytest.raises(FacadeError, match="Grid mine: "):
        arranged(windows(2, 2), "mine", nodes)
    with pytest.raises(FacadeError, match="expected one of: window"):
        grid_of(windows(1, 2), "door")


def test_sills_stand_in_line_with_windows_and_shops_do_not() -> None:
    gap = leaf("wall", 0.5)
    sills = across(gap, leaf("sill", 1.2), leaf("wall", 0.3), leaf("sill", 1.2), leaf("wall", 0.3))
    shops = across(leaf("shop", 0.8), leaf("shop", 2.7))
    facade = built(stacked(shops, leaf("wall", 3.5), sills, across(gap, leaf("window"), gap, leaf("window"), gap)))
    facade = with_proposals(facade)
    facade = with_grid(facade, "shop", called(facade, "shop"))
    assert aligned(facade, "window", X) == ("sill",)
    assert set(aligned(facade, "sill", X)) == {"window"}
    assert aligned(facade, "window", Y) == ()
    assert aligned(with_proposals(three_levels()), "window", X) == ()
