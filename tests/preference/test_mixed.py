"""Comparisons that agree with one another give the preference its direction."""

import os

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.learning.fitting import fit
from grammarlab.preference.blended import BlendedPreference

MANY = int(os.environ.get("GRAMMARLAB_PAIRS", "0"))
SETS = range(MANY) if MANY else (2, 6, 18, 23)
"""Seeds of sets of comparisons: a few on which cells are undivided or both parts count, or many if asked for."""
DESIGNS = 300


def designs(randomness: np.random.Generator) -> Floats:
    """[m, 4] a size, a count of storeys, a flag and another size, as grammars have them."""
    height, depth = randomness.uniform(3.0, 9.0, (2, DESIGNS))
    return np.column_stack([height, np.floor(height), np.round(randomness.random(DESIGNS)), depth])


def compared(values: Floats, num: int, share_of_ties: float, randomness: np.random.Generator):
    """First and second designs, scores and kinds of comparisons of which all decided ones prefer the higher value."""
    pairs = np.array([randomness.choice(len(values), 2, replace=False) for _ in range(10 * num)])
    difference = values[pairs[:, 0]] - values[pairs[:, 1]]
    near = np.abs(difference) < 0.1 * values.std()
    ties = round(share_of_ties * num)
    chosen = np.concatenate([np.flatnonzero(near)[:ties], np.flatnonzero(~near)[: num - ties]])
    first, second = np.where(difference[chosen, None] < 0.0, pairs[chosen, ::-1], pairs[chosen]).T
    kinds = np.where(near[chosen], "tie", "rather").tolist()
    return first, second, np.where(near[chosen], 50.0, 100.0), kinds


def learned(seed: int) -> tuple[BlendedPreference, Floats, Floats]:
    """A preference learned from 12 to 60 comparisons, the designs, and the value of each that is preferred."""
    randomness = np.random.default_rng(seed)
    rows = designs(randomness)
    column, sign = (0, 1, 3)[seed % 3], (1.0, -1.0)[seed // 3 % 2]
    values = sign * rows[:, column]
    first, second, scores, kinds = compared(values, int(randomness.integers(12, 61)), seed % 2 * 0.1, randomness)
    continuous = np.array([True, False, False, True])
    preference = fit(rows[first], scores, kinds=kinds, others=rows[second], continuous=continuous)
    assert isinstance(preference, BlendedPreference)
    return preference.for_density(rows, np.full(DESIGNS, 1.0 / DESIGNS)), rows, values


def gain(preference: BlendedPreference, rows: Floats, values: Floats) -> float:
    """Change of the mean value by the density that the preference is, in standard deviations."""
    density = np.maximum(preference.predict(rows).mean, 0.0)
    return float((density / density.sum()) @ values - values.mean()) / float(values.std())


def test_the_preferred_direction_is_learned_from_19_of_20_sets():
    wrong = [seed for seed in SETS if gain(*learned(seed)) <= 0.1]
    assert len(wrong) <= 0.05 * len(SETS), wrong
