from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.facade.editing.springs import springs
from grammarlab.facade.sizes.constraints import leaf_weights
from grammarlab.facade.sizes.size_wishes import Size
from grammarlab.facade.sizes.solve import resize
from grammarlab.facade.tree import Facade, X
from tests.facade.sized import sized, storeys


@given(sized(), st.integers(0, 1), st.floats(0.6, 2.0))
def test_a_facade_has_the_energy_of_its_spring_without_grids_and_no_less_with_them(
    facade: Facade, along: int, factor: float
) -> None:
    metres = factor * facade.size[0, along]
    weight = leaf_weights(facade.size[facade.leaves], facade.size[0], "default")[:, along]
    spring = springs(facade, along, facade.size[:, along], weight)
    found = resize(facade, [Size(0, along, metres)])
    energy = spring.energy(0, metres)
    assert energy <= found.energy[along] * (1.0 + 1e-9) + 1e-12
    shrunk = (found.facade.size[:, along] < 0.01 * facade.size[:, along]).any()
    if not facade.grids and not shrunk:
        assert energy == pytest.approx(found.energy[along], rel=1e-6)
    assert np.allclose(spring.length, facade.size[:, along])


@given(st.integers(1, 30), st.floats(0.3, 3.0), st.floats(0.8, 1.5))
def test_the_spring_of_a_facade_with_a_locked_part_has_its_energy(node: int, locked: float, factor: float) -> None:
    facade = replace(storeys(3, 2), grids=())
    metres, held = factor * facade.width, locked * float(facade.size[node, X])
    weight = leaf_weights(facade.size[facade.leaves], facade.size[0], "default")[:, X]
    spring = springs(facade, X, facade.size[:, X], weight, {node: held})
    found = resize(facade, [Size(0, X, metres), Size(node, X, held)])
    if found.conflict:
        return
    energy = spring.energy(0, metres)
    assert energy <= found.energy[X] * (1.0 + 1e-9) + 1e-9
    if not (found.facade.size[:, X] < 0.01 * facade.size[:, X]).any():
        assert energy == pytest.approx(found.energy[X], rel=1e-3, abs=1e-9)
