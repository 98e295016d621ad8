"""Values drawn to few levels."""

from itertools import combinations

import numpy as np
import pytest

from grammarlab.preference.simplified import drawn_to_levels


def moved(values, masses, drawn):
    return float(masses @ (np.sqrt(values) - np.sqrt(drawn)) ** 2)


@pytest.mark.parametrize("seed", range(5))
def test_no_other_cuts_explain_more_of_the_roots(seed):
    random = np.random.default_rng(seed)
    values, masses = random.uniform(0, 100, 7), random.uniform(0.1, 1, 7)
    roots = np.sqrt(np.sort(values))
    mass = masses[np.argsort(values)]

    def cost(cuts):
        parts = np.split(np.arange(7), cuts)
        return sum(mass[p] @ (roots[p] - np.average(roots[p], weights=mass[p])) ** 2 for p in parts)

    best = min(combinations(range(1, 7), 2), key=cost)
    order = np.argsort(np.argsort(values))
    wanted = np.searchsorted(best, order, side="right")
    drawn = drawn_to_levels(values, masses, 3)
    assert len({*zip(wanted, drawn, strict=True)}) == len(set(drawn)) == 3


def test_the_mean_stays_and_few_values_stay_as_they_are():
    values, masses = np.array([0.0, 3.0, 60.0, 61.0]), np.array([5.0, 1.0, 2.0, 1.0])
    assert masses @ drawn_to_levels(values, masses, 2) == pytest.approx(masses @ values)
    assert drawn_to_levels(values, masses, 4) is values


def test_thousands_of_values_and_values_without_mass_are_taken_too():
    values = np.linspace(0.0, 100.0, 5_000)
    masses = (np.arange(5_000) % 2).astype(float)
    drawn = drawn_to_levels(values, masses, 7)
    assert len(np.unique(drawn)) == 7
    assert np.abs(drawn - values).max() < 40.0
    assert np.isfinite(drawn_to_levels(values, np.zeros(5_000), 3)).all()
