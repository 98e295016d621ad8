"""Random functions from the posterior of a preference: values of all models at once."""

from __future__ import annotations

import numpy as np

from grammarlab.preference.base import MAX_SCORE, AbstractPreference, Floats
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.cells.partition import PartitionPreference
from grammarlab.preference.factors import ProductPreference
from grammarlab.preference.likelihood import value_of
from grammarlab.preference.processes.disagreement import joint


def draws(preference: AbstractPreference, rows: Floats, num: int, randomness: np.random.Generator) -> Floats | None:
    """[num, m] scores of rows, 0 to 100, each row one function; None for preferences without a posterior.

    A blend draws from its cells and from its process by their shares, a product from each of its factors.

    Args:
        preference: the preference.
        rows: [m, F].
        num: number of functions, >= 1.
        randomness: generator.
    """
    if isinstance(preference, ProductPreference):
        parts = [draws(factor, rows, num, randomness) for factor in preference.factors.values()]
        known = [part for part in parts if part is not None]
        return MAX_SCORE * np.prod(np.array(known) / MAX_SCORE, axis=0) if len(known) == len(parts) else None
    if isinstance(preference, PartitionPreference):
        return _of_cells(preference, rows, num, randomness)
    if isinstance(preference, BlendedPreference):
        by_process = round(preference.share * num)
        found = np.concatenate(
            [
                _of_process(preference, rows, by_process, randomness),
                _of_cells(preference.partition, rows, num - by_process, randomness),
            ]
        )
        # Factors are independent: one may draw from cells and another from a process.
        return randomness.permutation(found)
    return None


def _of_cells(preference: PartitionPreference, rows: Floats, num: int, randomness: np.random.Generator) -> Floats:
    found = np.zeros((num, len(rows)))
    for place, (number, posteriors) in enumerate(preference.divisions(rows, num, randomness)):
        below = posteriors.cumsum(axis=1)
        value = np.argmax(below >= randomness.random((len(below), 1)) * below[:, -1:], axis=1)
        found[place] = preference.cells.grid[value[number]]
    return found


def _of_process(preference: BlendedPreference, rows: Floats, num: int, randomness: np.random.Generator) -> Floats:
    """Draws of mean scores, converted to values."""
    if not num:
        return np.zeros((0, len(rows)))
    mean, covariance = joint(preference.process, rows, np.zeros(rows.shape[1]))
    length, direction = np.linalg.eigh(covariance)
    away = randomness.normal(size=(num, len(rows))) @ (direction * np.sqrt(np.maximum(length, 0.0))).T
    return value_of(mean + away, preference.noise, preference.blunders)
