"""Edits of random facades, and grids that go on in other storeys."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.edit import edit
from grammarlab.facade.editing.grid_proposals import with_joint
from grammarlab.facade.editing.grids import with_grid
from grammarlab.facade.file import load_facade
from grammarlab.facade.sizes.size_wishes import Size, Wish
from grammarlab.facade.tree import Facade, X, Y, check
from tests.facade.gridded import transposed
from tests.facade.samples import Node, across, built, leaf, stacked, windows
from tests.facade.sized import sized

ARCADE = Path(__file__).parents[2] / "grammars" / "facades" / "arcade.json"


@given(sized(max_nodes=25), st.floats(0.4, 2.2), st.sampled_from([(0, 0), (1, 0), (0, -1)]))
@settings(max_examples=15)
def test_every_result_is_a_facade_as_wide_as_asked_or_says_why_not(
    facade: Facade, wider: float, counts: tuple[int, int]
) -> None:
    try:
        results = edit(facade, width=wider * facade.width, columns=counts[0], rows=counts[1], most=3)
    except FacadeError:
        assert any(counts), "sizes alone always have an answer"
        return
    assert results
    for each in results:
        check(each.facade)
        if not each.conflict:
            assert each.facade.width == pytest.approx(wider * facade.width, rel=1e-6)
            assert max(each.residuals.alignment, each.residuals.symmetry) <= 1e-6


def test_all_storeys_of_the_arcade_get_the_same_columns_and_the_portal_stays() -> None:
    arcade = load_facade(ARCADE)
    portal = arcade.labels.index("portal")
    for wider in (0.7, 1.5):
        best, *others = edit(arcade, width=wider * arcade.width)
        assert all(best.energy < 0.25 * each.energy for each in others)
        joint = with_joint(best.facade).grids[0]
        # The portal is as high as two rows.
        assert (joint.num_rows, len(joint.node)) == (3, 3 * joint.num_columns - 2)
        size = best.facade.size[best.facade.label == portal, X].max()
        assert size == pytest.approx(arcade.size[arcade.label == portal, X].max(), rel=0.3)


def test_grids_of_the_same_columns_are_joined_and_others_are_not() -> None:
    arcade = load_facade(ARCADE)
    joint, band = with_joint(arcade).grids
    names = {grid.name: grid for grid in arcade.grids}
    expected = np.sort(np.append(names["arched window"].node, names["square window"].node))
    np.testing.assert_array_equal(joint.node, expected)
    assert (joint.num_rows, joint.num_columns) == (3, 7)
    assert band is names["band"] or band.name == "band"
    flats = load_facade(ARCADE.with_name("flats.json"))
    assert {grid.name for grid in with_joint(flats).grids} == {grid.name for grid in flats.grids}


def periodic(columns: int) -> Facade:
    """Storeys of equal windows with margins of half a gap, between strips as wide as the facade."""
    gap, margin, strip = leaf("wall", 1.8, 1.5), leaf("wall", 0.9, 1.5), leaf("wall", 3.0 * columns, 0.75)
    inner = [part for _ in range(columns) for part in (gap, leaf("window", 1.2, 1.5))][1:]
    facade = built(stacked(strip, *[part for _ in range(2) for part in (across(margin, *inner, margin), strip)]))
    return with_grid(facade, "window", [node for node in facade.leaves if facade.name_of(node) == "window"])


@pytest.mark.parametrize("times", range(2, 13))
@pytest.mark.parametrize("columns", [2, 5])
def test_equal_columns_are_repeated_exactly_at_multiples_of_the_size(columns: int, times: int) -> None:
    facade = periodic(columns)
    for each, along in ((facade, X), (transposed(facade), Y)):
        metres = times * float(each.size[0, along])
        best, *others = edit(each, width=metres if along == X else None, height=metres if along == Y else None)
        assert best.proven
        assert best.energy == pytest.approx(0.0, abs=1e-9)
        assert all(other.energy > 1.0 for other in others)
        (grid,) = best.facade.grids
        assert (grid.num_columns, grid.num_rows)[along] == times * columns
        assert best.facade.size[grid.node, along] == pytest.approx(1.2)


def test_a_size_for_which_columns_are_not_chosen_says_so_with_every_result() -> None:
    facade = periodic(5)
    results = edit(facade, width=600.0 * facade.width)
    assert len(results) == 2
    for each in results:
        (reason,) = each.missing
        assert reason.endswith("leaves; expected at most 10,000.")


def house() -> Facade:
    """Two columns of windows on both sides of a door, which is 2 m wide and 3 m high, in three storeys."""

    def storey(middle: Node) -> Node:
        pair = [part for _ in range(2) for part in (leaf("window", 1.2, 1.5), leaf("wall", 1.8, 1.5))]
        bays = [stacked(leaf("wall", 1, 0.75), across(*pair[:3]), leaf("wall", 1, 0.75)) for _ in range(2)]
        wall = leaf("wall", 1.3, 3.0)
        return across(wall, bays[0], wall, middle, wall, bays[1], wall)

    facade = built(stacked(storey(leaf("door", 2.0, 3.0)), *[storey(leaf("wall", 2.0, 3.0)) for _ in range(2)]))
    facade = with_grid(facade, "window", [node for node in facade.leaves if facade.name_of(node) in {"window", "door"}])
    return facade


def node_of(facade: Facade, name: str) -> int:
    return next(node for node in facade.leaves.tolist() if facade.name_of(node) == name)


@pytest.mark.parametrize(
    ("name", "axis", "locked", "factor"),
    [("door", X, 6.0, 0.93), ("door", Y, 4.5, 0.78), ("window", X, 3.0, 1.0), ("door", X, 2.0, 0.6)],
)
def test_the_lock_of_a_part_does_not_remove_it(name: str, axis: int, locked: float, factor: float) -> None:
    facade = house()
    lock = Size(node_of(facade, name), axis, locked)
    metres = factor * float(facade.size[0, axis])
    results = edit(facade, width=metres if axis == X else None, height=metres if axis == Y else None, locks=[lock])
    for each in results:
        copies = [one for one in each.locks if isinstance(one, Size)]
        assert copies
        assert not each.conflict
        assert all(each.facade.name_of(one.node) == name for one in copies)
        assert [each.facade.size[one.node, axis] for one in copies] == pytest.approx([locked] * len(copies))
        assert each.facade.labels.index("door") in each.facade.label


def test_locks_that_contradict_each_other_are_named_and_nothing_is_proven() -> None:
    facade = house()
    window, other = [node for node in facade.leaves.tolist() if facade.name_of(node) == "window"][:2]
    locks: list[Wish] = [Size(window, X, 3.0), Size(other, X, 1.0)]
    for each in edit(facade, width=facade.width, locks=locks):
        assert {f"window (node {window}) is 3 m wide", f"window (node {other}) is 1 m wide"} <= set(each.conflict)
        assert not each.proven
        assert len(each.locks) >= 2


def test_a_removed_column_with_the_only_copy_of_a_locked_part_is_a_conflict_and_comes_last() -> None:
    facade = windows(2, 3)
    lock = Size(int(facade.grids[0].places()[0, 0]), X, 1.0)
    results = edit(facade, columns=-1, locks=[lock])
    assert [bool(each.locks) for each in results] == sorted((bool(each.locks) for each in results), reverse=True)
    for each in results:
        named = f"window (node {lock.node}) is 1 m wide, but no copy of it is left"
        assert each.conflict == (() if each.locks else (named,))
    assert not results[-1].locks
