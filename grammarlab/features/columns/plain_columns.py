"""Features of designs that are plain columns of numbers, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.features.patterns.operations import evaluate
from grammarlab.features.patterns.pattern import Draw, Feature, Formula, HalfSpace, Sum, Threshold

_MIN_POSITIVE = 1e-300
"""Smallest argument of a logarithm."""


def feature_values(columns: Mapping[str, Floats], feature: Feature) -> Floats:
    """[n] values of a feature of plain columns.

    Args:
        columns: columns [n] by name.
        feature: a draw, a bound on one, or a sum of draws or of their logarithms.

    >>> feature_values({"height": np.array([4.0, 9.0])}, Threshold("height", 5.0)).tolist()
    [1.0, 0.0]
    """
    match feature:
        case Draw(site, None):
            return columns[site]
        case Threshold(site, bound):
            return (columns[site] < bound).astype(np.float64)
        case HalfSpace(sites, weights, bound, logarithmic):
            inside = _total(columns, sites, weights, logarithmic) < bound
            if logarithmic:
                inside &= np.all([columns[site] > 0.0 for site in sites], axis=0)
            return inside.astype(np.float64)
        case Sum(terms, logarithmic):
            return _total(columns, [term.site for term in terms], [term.weight for term in terms], logarithmic)
        case Formula():
            inner = {read: feature_values(columns, read) for read in feature.features}
            return evaluate(feature.steps, inner, len(next(iter(columns.values()))))
        case _:
            raise UsageError(
                f"expected a number, a bound on one, or a sum of numbers, found {feature}: such designs have no parts."
            )


def _total(columns: Mapping[str, Floats], sites: Sequence[str], weights: Sequence[float], logarithmic: bool) -> Floats:
    values = np.column_stack([columns[site] for site in sites])
    return (np.log(np.maximum(values, _MIN_POSITIVE)) if logarithmic else values) @ np.array(weights)
