"""Features of designs that are plain columns of numbers, by name."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.features.patterns.operations import evaluate
from grammarlab.features.patterns.pattern import Draw, Feature, Formula, Threshold


def feature_values(columns: Mapping[str, Floats], feature: Feature) -> Floats:
    """[n] values of a feature of plain columns.

    Args:
        columns: columns [n] by name.
        feature: a draw, a bound on one, or a formula of them.

    >>> feature_values({"height": np.array([4.0, 9.0])}, Threshold("height", 5.0)).tolist()
    [1.0, 0.0]
    """
    match feature:
        case Draw(site, None):
            return columns[site]
        case Threshold(site, bound):
            return (columns[site] < bound).astype(np.float64)
        case Formula():
            inner = {read: feature_values(columns, read) for read in feature.features}
            return evaluate(feature.steps, inner, len(next(iter(columns.values()))))
        case _:
            raise UsageError(
                f"expected a number, a bound on one, or a formula of them, found {feature}: such designs have no parts."
            )
