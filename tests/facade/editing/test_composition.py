"""Facades put together from intervals of others."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.facade.editing.composition import composed
from grammarlab.facade.editing.variations import unedited
from grammarlab.facade.editing.wall_slabs import find_elements
from grammarlab.facade.tree import Facade, X, Y, check
from tests.facade.gridded import transposed
from tests.facade.integers import integer_facades
from tests.facade.samples import across, built, leaf, stacked, windows


@given(
    integer_facades(),
    st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)), min_size=1, max_size=4),
    st.integers(0, 1),
)
@settings(max_examples=60)
def test_any_intervals_make_a_facade_of_their_length_without_a_cut_opening(
    facade: Facade, shares: list[tuple[float, float]], along: int
) -> None:
    whole = float(facade.size[0, along])
    intervals = [(whole * min(pair), whole * max(pair)) for pair in shares]
    length = sum(end - begin for begin, end in intervals)
    if length < 0.1:
        return
    elements = find_elements(facade, along)
    made = composed(unedited(facade), along, intervals, elements.node[elements.is_solid])
    check(made.facade)
    assert np.isclose(made.facade.size[0, along], length)
    assert made.facade.size[0, 1 - along] == facade.size[0, 1 - along]
    solid = np.isin(made.source, elements.node[elements.is_solid])
    assert (made.visible[solid] == (0.0, 0.0, 1.0, 1.0)).all()
    np.testing.assert_array_equal(made.facade.size[:, 1 - along], facade.size[made.source, 1 - along])


@given(integer_facades(), st.floats(0.1, 0.9), st.integers(0, 1))
@settings(max_examples=20)
def test_intervals_that_continue_each_other_are_the_facade_itself(facade: Facade, share: float, along: int) -> None:
    whole = float(facade.size[0, along])
    elements = find_elements(facade, along)
    pieces = [(0.0, share * whole), (share * whole, whole)]
    made = composed(unedited(facade), along, pieces, elements.node[elements.is_solid])
    np.testing.assert_array_equal(made.source, np.arange(len(facade)))
    np.testing.assert_array_equal(made.facade.axis, facade.axis)
    np.testing.assert_allclose(made.facade.position, facade.position, atol=1e-12)
    np.testing.assert_allclose(made.facade.size, facade.size, atol=1e-12)


def test_a_repeated_column_is_the_facade_with_one_column_more() -> None:
    for rows, columns in ((1, 2), (3, 4)):
        for along in (0, 1):
            facade, wider = windows(rows, columns), windows(rows, columns + 1)
            if along:
                facade, wider = transposed(facade), transposed(wider)
            elements = find_elements(facade, along)
            # A column and a gap are 1.5 m long, and start in the middle of a gap of 0.5 m.
            pieces = [(0.0, 1.75), (0.25, float(facade.size[0, along]))]
            made = composed(unedited(facade), along, pieces, elements.node[elements.is_solid]).facade
            np.testing.assert_array_equal(made.axis, wider.axis)
            np.testing.assert_allclose(made.size, wider.size)
            (one,), (other,) = made.grids, wider.grids
            np.testing.assert_array_equal(one.places(), other.places())


def test_a_storey_of_another_rhythm_bends_around_its_openings_and_a_cornice_is_extended() -> None:
    upper = across(*[part for _ in range(3) for part in (leaf("wall", 0.5), leaf("window"), leaf("wall", 0.5))])
    lower = across(leaf("wall", 1.2), leaf("door", 1.6), leaf("wall", 3.2))
    facade = built(stacked(lower, leaf("cornice", 6.0, 0.3), upper))
    elements = find_elements(facade, X)
    solid = elements.node[elements.is_solid]
    # The cut at 2.0 m crosses the door.
    made = composed(unedited(facade), X, [(0.0, 2.0), (0.0, 6.0)], solid)
    names = [made.facade.name_of(node) for node in made.facade.leaves]
    assert (names.count("door"), names.count("cornice"), names.count("window")) == (1, 1, 4)
    door = next(node for node in made.facade.leaves if made.facade.name_of(node) == "door")
    assert made.facade.position[door, X] == np.float64(3.2)
    assert np.isclose(made.facade.size[door, X], 1.6)
    check(replace(made.facade, grids=()))


def test_the_end_of_a_portal_of_the_column_before_is_not_repeated() -> None:
    """The portal is longer than the repeated column, as a cornice is, but ends soon after its start."""
    bay = [leaf("wall", 0.5, 2.0), leaf("window", 1.0, 2.0), leaf("wall", 0.5, 2.0)]
    above = across(*bay * 4)
    # Beside the end of the portal, at 4.2 m, a cornice and a wall share its height.
    beside = stacked(leaf("wall", 3.8, 0.5), leaf("molding", 3.8, 0.5))
    portal = across(leaf("wall", 1.8, 1.0), leaf("deco", 2.4, 1.0), beside)
    facade = built(stacked(portal, above))
    elements = find_elements(facade, X)
    made = composed(unedited(facade), X, [(0.0, 6.0), (4.0, 6.0), (4.0, 8.0)], elements.uncut).facade
    names = [made.name_of(node) for node in made.leaves.tolist()]
    assert (names.count("window"), names.count("deco"), names.count("molding")) == (6, 1, 1)
    deco = made.leaves[names.index("deco")]
    assert np.allclose([made.position[deco, X], made.size[deco, X]], [1.8, 2.4])


def test_a_cut_just_inside_of_a_window_repeats_it_whole_and_the_moulding_below_it_gives_way() -> None:
    storey = across(
        leaf("wall", 0.5, 2.5), stacked(leaf("molding", 1.0, 0.5), leaf("window", 1.0, 2.0)), leaf("wall", 0.5, 2.5)
    )
    cornice = across(leaf("wall", 0.5, 1.0), leaf("cornice", 1.0, 1.0), leaf("wall", 0.5, 1.0))
    facade = built(stacked(leaf("wall", 2.0, 2.0), storey, cornice, leaf("wall", 2.0, 0.7)))
    elements = find_elements(facade, Y)
    # The window begins at 2.5 m. With its moulding, the storey is higher than the room between the cuts.
    made = composed(unedited(facade), Y, [(0.0, 5.6), (2.52, 5.6), (2.52, 6.2)], elements.uncut).facade
    heights: dict[str, list[float]] = {}
    for node in made.leaves.tolist():
        heights.setdefault(made.name_of(node), []).append(round(float(made.size[node, Y]), 6))
    assert heights["window"] == [2.0, 2.0, 2.0]
    assert len(heights["cornice"]) == len(heights["molding"]) == 3
    assert max(heights["cornice"] + heights["molding"]) <= 1.0
