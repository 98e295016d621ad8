"""Values of cells that make their expected shares in a density.

A density divides values by their total over all designs. If cells hold masses w of the designs, the share of a cell in
this total is v w / (v w + r), r the total of the other cells, and the expected density has the expected share. Expected
values have another one: if hardly any design is liked, and a cell of nearly all designs has a value of 0 with a
probability of 97 % and a small one otherwise, its expected value has most of the total, but its expected share is at
most 3 %.
"""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import FEW, ROUNDING, Floats


def values_for_density(posteriors: Floats, grid: Floats, masses: Floats) -> Floats:
    """[k] values of cells with which each has its expected share in the total, with the same highest value.

    Args:
        posteriors: [k, G] probability of each value of each cell; rows sum to 1.
        grid: [G] possible values, >= 0.
        masses: [k] share of the designs in each cell, >= 0.
    """
    expected = posteriors @ grid
    values = expected
    # Each sweep takes the total of the other cells from the sweep before.
    for _ in range(FEW):
        others = np.maximum(masses @ values - masses * values, 0.0)
        value_mass = grid * masses[:, None]
        share = (posteriors * (value_mass / np.maximum(value_mass + others[:, None], ROUNDING))).sum(axis=1)
        # A cell without designs, or without other cells of some value, has no share that its value could change.
        has_share = (masses > 0.0) & (others > ROUNDING)
        odds = share / np.maximum(1.0 - share, ROUNDING)
        values = np.where(has_share, odds * others / np.where(has_share, masses, 1.0), expected)
    return values * (expected.max() / values.max()) if values.max(initial=0.0) > 0.0 else expected
