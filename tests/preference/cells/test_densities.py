"""Values of cells for a density: exact where one cell is unknown, nearer than expected values where several are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from grammarlab.learning.targets.divergence import jensen_shannon
from grammarlab.preference.cells.density_values import values_for_density

GRID = np.array([0.0, 4.0, 50.0, 80.0])
PARTS = arrays(np.float64, (3, 4), elements=st.floats(0.01, 1.0))
MASSES = arrays(np.float64, 3, elements=st.floats(0.01, 1.0))


def sure(value):
    return (value == GRID).astype(float)


def test_an_unknown_cell_of_nearly_all_designs_has_its_expected_share():
    posteriors, masses = np.array([sure(80.0), [0.97, 0.03, 0.0, 0.0]]), np.array([0.01, 0.99])
    values = values_for_density(posteriors, GRID, masses)
    share = 0.03 * (4.0 * 0.99) / (4.0 * 0.99 + 80.0 * 0.01)
    assert values[1] * 0.99 / (values @ masses) == pytest.approx(share)
    assert values[0] == 80.0
    by_expected = posteriors @ GRID * masses
    assert by_expected[1] / by_expected.sum() > 5 * share


@pytest.mark.parametrize("values", [[80.0, 4.0, 0.0], [0.0, 0.0, 0.0], [50.0]])
def test_known_values_and_a_single_cell_stay(values):
    found = values_for_density(np.array([sure(value) for value in values]), GRID, np.ones(len(values)) / len(values))
    np.testing.assert_allclose(found, values)


def test_a_single_unknown_cell_and_cells_without_designs_have_expected_values():
    unknown = np.array([0.5, 0.0, 0.5, 0.0])
    assert values_for_density(unknown[None], GRID, np.ones(1)) == pytest.approx([25.0])
    found = values_for_density(np.array([sure(80.0), unknown]), GRID, np.array([1.0, 0.0]))
    assert found == pytest.approx([80.0, 25.0])


@given(PARTS, MASSES)
def test_proportions_of_masses_matter_and_the_highest_value_is_as_expected(odds, masses):
    posteriors = odds / odds.sum(axis=1, keepdims=True)
    found, expected = values_for_density(posteriors, GRID, masses), posteriors @ GRID
    assert (found >= 0.0).all()
    assert found.max() == pytest.approx(expected.max())
    np.testing.assert_allclose(values_for_density(posteriors, GRID, 7.0 * masses), found)
    order = np.array([2, 0, 1])
    np.testing.assert_allclose(values_for_density(posteriors[order], GRID, masses[order]), found[order])


@pytest.mark.parametrize("seed", range(3))
def test_densities_of_drawn_values_are_nearer_than_to_expected_values(seed):
    randomness = np.random.default_rng(seed)
    # Hardly any design is surely liked, and several large cells may have small values.
    posteriors = np.array([sure(80.0), *([0.9, 0.08, 0.02, 0.0] for _ in range(3))])
    masses = np.array([0.01, *randomness.dirichlet(np.ones(3))])
    expected = posteriors @ GRID
    drawn = [[randomness.choice(GRID, p=row) for row in posteriors] for _ in range(400)]

    def distance(values):
        densities = [np.array(each) * masses for each in drawn]
        return np.mean([jensen_shannon(each / each.sum(), values * masses / (values @ masses)) for each in densities])

    assert distance(values_for_density(posteriors, GRID, masses)) < 0.9 * distance(expected)
