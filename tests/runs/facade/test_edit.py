"""Edits of random facades, and grids that go on in other storeys."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.file import load_facade
from grammarlab.facade.grids.joint import with_joint
from grammarlab.facade.tree import Facade, X, check
from grammarlab.runs.facade.edit import edit
from tests.facade.sized import sized

ARCADE = Path(__file__).parents[3] / "grammars" / "facades" / "arcade.json"


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
        assert best.facade.grids[0].num_rows == 3
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
