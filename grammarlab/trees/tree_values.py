"""Parameters and measures of trees as features, by name: what acceptance rules and learning read of a tree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import UsageError
from grammarlab.features.patterns.conditions import sites_of
from grammarlab.features.patterns.pattern import Draw, Feature, HalfSpace, Sum, Threshold
from grammarlab.trees.parameters import COLUMN

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
        case _:
            raise UsageError(f"trees have no parts to count: expected a parameter or a measure, found {feature}.")


def check_names(features: Sequence[Feature], names: Sequence[str]) -> None:
    """Check that features read only some names.

    Raises:
        UsageError: If a feature has another name, or counts parts of a derivation.
    """
    for feature in features:
        sites = sites_of(feature)
        if not sites or (isinstance(feature, Draw) and feature.branch is not None):
            raise UsageError(
                f"{feature}: trees have no symbols to count; expected a parameter or a measure, such as $ratio."
            )
        for site in sites:
            if site not in names:
                near = get_close_matches(site, names, n=3, cutoff=0.5)
                hint = f"did you mean {' or '.join(f'${name}' for name in near)}?" if near else "see the table of them."
                raise UsageError(f"${site} is neither a parameter nor a measure of trees; {hint}")


def parameters(rows: Floats) -> dict[str, Floats]:
    """The columns [n] of parameters [n, P] by name."""
    return {name: rows[:, index] for name, index in COLUMN.items()}


def _total(columns: Mapping[str, Floats], sites: Sequence[str], weights: Sequence[float], logarithmic: bool) -> Floats:
    values = np.column_stack([columns[site] for site in sites])
    return (np.log(np.maximum(values, _MIN_POSITIVE)) if logarithmic else values) @ np.array(weights)
