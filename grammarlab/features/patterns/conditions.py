"""Bounds on features as conditions of expressions."""

from __future__ import annotations

from grammarlab.features.patterns.pattern import Draw, Feature, HalfSpace, Pattern, Present, Threshold


def at_least(feature: Feature, bound: float) -> str:
    """The condition that a feature is a bound or more, as `grammarlab.features.rules.expression` reads it.

    >>> at_least(Pattern("Block", branch=(0,)), 2.0), at_least(Threshold("height", 3.5), 1.0)
    ('{Block:0} >= 2', '$height < 3.5')
    """
    if isinstance(feature, HalfSpace):
        return _inside(feature)
    if isinstance(feature, Threshold):
        # Of a name that is drawn once; where it is drawn several times, the mean of the draws is looked at.
        return f"${feature.site} < {_number(feature.bound)}"
    if isinstance(feature, Present):
        return f"{_read(feature.feature)} != 0"
    return f"{_read(feature)} >= {_number(bound)}"


def sum_at_least(space: HalfSpace, bound: float) -> str:
    """The condition that the weighted sum of a half-space is a bound or more, whatever its own bound is."""
    return f"{_sum(space)} >= {_number(bound)}"


def _read(feature: Pattern | Draw) -> str:
    if isinstance(feature, Pattern):
        return f"{{{feature}}}"
    return f"${feature.site}" if feature.branch is None else f"${feature.site}:{feature.branch}"


def _sum(space: HalfSpace) -> str:
    sites = [f"log(${site})" if space.logarithmic else f"${site}" for site in space.sites]
    return " + ".join(f"{_number(weight)} * {site}" for weight, site in zip(space.weights, sites, strict=True))


def _inside(space: HalfSpace) -> str:
    # The logarithm of what is not above 0 is no number, and such a draw is not inside.
    positive = [f"${site} > 0" for site in space.sites] if space.logarithmic else []
    return " and ".join([*positive, f"{_sum(space)} < {_number(space.bound)}"])


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")
