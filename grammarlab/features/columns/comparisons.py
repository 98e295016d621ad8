"""Half-spaces of draws as comparisons in words: ``a > b``, ``a + b > 12.3``, ``a * b at most 12``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grammarlab.features.patterns.pattern import Draw, Feature, HalfSpace

Floats = NDArray[np.float64]

_NEGLIGIBLE = 0.01
"""Share of the range of a sum below which its bound is written as 0; bounds found by few scores are not more exact."""


def comparison(space: HalfSpace, spread: float = 0.0, *, holds: bool = True) -> str:
    """A half-space, or its complement, with the first draw on the left and rounded numbers.

    Args:
        space: the half-space.
        spread: range of the weighted sum (`spread_of`); 0 if it is unknown.
        holds: whether designs are in the half-space.

    >>> space = HalfSpace(("a", "b"), (-1.0, 1.0), -0.0013)
    >>> comparison(space, 20.0), comparison(space, 20.0, holds=False)
    ('a > b', 'a at most b')
    >>> comparison(HalfSpace(("a", "b"), (1.0, 0.5), 12.3014), 15.0)
    'a + 0.5 b < 12.3'
    """
    sign = float(np.sign(space.weights[0]))
    terms = [(site, sign * weight) for site, weight in zip(space.sites, space.weights, strict=True)]
    left = [(site, weight) for site, weight in terms if weight > 0.0]
    right = [(site, -weight) for site, weight in terms if weight < 0.0]
    bound = 0.0 if abs(space.bound) < _NEGLIGIBLE * spread else sign * space.bound
    side = _product if space.logarithmic else _sum
    relation = (("at least", "<") if sign > 0.0 else ("at most", ">"))[holds]
    return f"{side(left, 0.0)} {relation} {side(right, bound)}"


def spread_of(space: HalfSpace, features: Sequence[Feature], values: Floats) -> float:
    """Range of the weighted sum of a half-space over designs, as if its draws were independent.

    Args:
        space: the half-space.
        features: [F] features of the designs, such as its draws; other draws count 0.
        values: [n, F] their values.
    """
    columns = {feature.site: column for column, feature in enumerate(features) if isinstance(feature, Draw)}
    total = 0.0
    for site, weight in zip(space.sites, space.weights, strict=True):
        drawn = values[:, columns[site]] if site in columns else np.zeros(0)
        drawn = np.log(drawn[drawn > 0.0]) if space.logarithmic else drawn
        total += abs(weight) * float(np.ptp(drawn)) if len(drawn) else 0.0
    return total


def _sum(terms: Sequence[tuple[str, float]], constant: float) -> str:
    text = " + ".join(_with_number(site, weight, "{number} {site}") for site, weight in terms)
    if not text:
        return f"{constant:.3g}"
    return text if constant == 0.0 else f"{text} {'-' if constant < 0.0 else '+'} {abs(constant):.3g}"


def _product(terms: Sequence[tuple[str, float]], logarithm: float) -> str:
    """Product of powers, and of a factor that is given by its logarithm."""
    powers = [_with_number(site, weight, "{site}^{number}") for site, weight in terms]
    factor = [] if powers and logarithm == 0.0 else [f"{np.exp(logarithm):.3g}"]
    return " * ".join([*factor, *powers])


def _with_number(site: str, weight: float, form: str) -> str:
    number = f"{weight:.3g}"
    return site if number == "1" else form.format(number=number, site=site)
