"""Faults that a person sees."""

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.facade.editing.composition import composed
from grammarlab.facade.editing.faults import Faults, find_faults
from grammarlab.facade.editing.variations import Variation, unedited
from grammarlab.facade.editing.wall_slabs import find_elements
from grammarlab.facade.tree import Facade, X
from tests.facade.samples import across, built, leaf, stacked


def house() -> Facade:
    """Two storeys of three windows between corner pillars, on a ground floor with a door."""
    gap, pillar = leaf("wall", 1.0, 2.5), leaf("pillar", 0.5, 2.5)
    row = across(pillar, *[part for _ in range(3) for part in (gap, leaf("window", 1.0, 2.5))], gap, pillar)
    ground = across(leaf("wall", 3.0, 3.0), leaf("door", 2.0, 3.0), leaf("wall", 3.0, 3.0))
    band = leaf("cornice", 8.0, 0.5)
    return built(stacked(ground, band, row, band, row, leaf("cornice", 8.0, 0.7)))


def stretched(facade: Facade, factors: tuple[float, float]) -> Facade:
    return replace(facade, position=facade.position * factors, size=facade.size * factors)


def of_intervals(*intervals: tuple[float, float]) -> tuple[Variation, Faults]:
    facade = house()
    elements = find_elements(facade, X)
    variation = composed(unedited(facade), X, intervals, elements.node[elements.is_solid])
    return variation, find_faults(facade, variation, variation.facade)


def test_a_facade_and_the_same_stretched_by_a_third_have_no_faults() -> None:
    facade = house()
    for factors in ((1.0, 1.0), (1.3, 1.0), (1.0, 0.75), (3.0, 3.0)):
        assert find_faults(facade, unedited(facade), stretched(facade, factors)).words == ()
    assert find_faults(facade, unedited(facade), stretched(facade, (1.5, 1.0))).words == ("stretched openings",)
    words = find_faults(facade, unedited(facade), stretched(facade, (0.45, 0.45))).words
    assert words == ("elements of less than half of their size",)


@pytest.mark.parametrize(("shift", "share"), [(0.01, 0.0), (0.1, 1.0)])
def test_windows_of_one_storey_that_are_shifted_are_out_of_line(shift: float, share: float) -> None:
    facade = house()
    upper = (facade.position[:, 1] > 5.0) & (facade.label == facade.labels.index("window"))
    position = facade.position.copy()
    position[upper, X] += shift
    faults = find_faults(facade, unedited(facade), replace(facade, position=position))
    # Three of seven pairs: two more lie beside each other in each storey.
    assert faults.out_of_line == pytest.approx(share * 3 / 7)
    assert bool(faults.words) == (share > 0.0)


def test_windows_that_were_equal_and_are_not_are_unequal() -> None:
    facade = house()
    size = facade.size.copy()
    size[np.flatnonzero(facade.label == facade.labels.index("window"))[0], 1] *= 1.2
    assert find_faults(facade, unedited(facade), replace(facade, size=size)).unequal == pytest.approx(1.2)


def test_repeated_doors_corners_and_cut_openings_are_faults_and_repeated_windows_are_not() -> None:
    assert of_intervals((0.0, 3.0), (1.0, 8.0))[1].words == ()
    assert of_intervals((0.0, 5.5), (2.5, 8.0))[1].words == ("another number of doors",)
    assert of_intervals((0.0, 3.0), (0.0, 8.0))[1].words == ("parts of the edge inside",)
    # A wall of four times its length, and windows of half of theirs.
    faults = of_intervals(*[(0.5, 1.5)] * 8, (0.0, 8.0))[1]
    assert faults.open == pytest.approx(0.5)
    assert "blank walls" in faults.words
    variation, _ = of_intervals((0.0, 8.0))
    visible = variation.visible.copy()
    visible[variation.facade.label == variation.facade.labels.index("door"), 2] = 0.5
    assert find_faults(house(), replace(variation, visible=visible), variation.facade).words == ("cut openings",)
