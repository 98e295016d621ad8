"""The bound of the parts beside repeated bands is at most their cost in any facade with repetitions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.errors import FacadeError
from grammarlab.facade.editing.grids import with_grid
from grammarlab.facade.editing.repeats import find_repeats
from grammarlab.facade.editing.springs import energy_beside, least_energy, origin_of
from grammarlab.facade.editing.variations import unedited
from grammarlab.facade.sizes.model import ALIGNMENT, SYMMETRY, WISH
from grammarlab.facade.sizes.size_wishes import Size
from grammarlab.facade.tree import Facade, X
from tests.facade.samples import Node, across, built, leaf, stacked

HELD = (WISH, ALIGNMENT, SYMMETRY)


def mixed(widths: list[float], below: list[float]) -> Facade:
    """A storey of repeatable windows, and one of shops and a sign with tied sizes."""

    def storey(label: str, sizes: list[float]) -> Node:
        gap = leaf("wall", 0.4, 2.0)
        return across(gap, *[part for size in sizes for part in (leaf(label, size, 2.0), gap)])

    facade = built(
        stacked(storey("shop", below), leaf("wall", 5), storey("sign", below[::-1]), storey("window", widths))
    )
    for label in ("window", "shop", "sign"):
        facade = with_grid(facade, label, [node for node in facade.leaves if facade.name_of(node) == label])
    elements = [node for node in facade.leaves if facade.name_of(node) in {"shop", "sign"}]
    return with_grid(facade, "below", elements)


lengths = st.lists(st.floats(0.5, 2.0), min_size=2, max_size=4)


@settings(max_examples=20)
@given(lengths, lengths, st.floats(0.5, 2.0), st.data())
def test_nothing_beside_the_bands_costs_less_whatever_is_repeated(
    widths: list[float], below: list[float], wider: float, data: st.DataObject
) -> None:
    facade = mixed(widths, below)
    grid = data.draw(st.sampled_from(facade.grids))
    found = find_repeats(unedited(facade), grid, X)
    if found is None:
        return
    wish = Size(0, X, wider * facade.width)
    beside = energy_beside(found, facade, wish, "default", HELD)
    for _ in range(3):
        counts = data.draw(st.lists(st.integers(0, 3), min_size=len(widths), max_size=len(widths)))
        try:
            made = found.variation(found.spread(np.resize(counts, int(found.kind.max()) + 1)))
        except FacadeError:
            continue
        whole = least_energy(made.facade, origin_of(facade, made), [wish], "default", HELD)
        assert beside <= whole + 1e-12


def test_it_is_the_energy_of_these_parts_alone() -> None:
    facade = mixed([1.0, 1.5], [0.6, 0.9, 1.8])
    (grid,) = [each for each in facade.grids if each.name == "window"]
    found = find_repeats(unedited(facade), grid, X)
    assert found is not None
    wish = Size(0, X, 1.4 * facade.width)
    tied = energy_beside(found, facade, wish, "default", HELD)
    free = energy_beside(found, facade, wish, "default", (WISH,))
    assert tied > free > 0.0
    same = Size(0, X, facade.width)
    natural = energy_beside(found, facade, same, "default", HELD)
    assert natural == pytest.approx(energy_beside(found, facade, same, "default", (WISH,)), abs=1e-9)
