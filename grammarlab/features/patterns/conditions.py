"""Bounds on features as conditions of expressions."""

from __future__ import annotations

from grammarlab.features.patterns.pattern import Draw, Feature, Formula, Pattern, Present, Threshold


def at_least(feature: Feature, bound: float) -> str:
    """Condition that a feature is at least a bound, in the syntax of `grammarlab.features.expression`.

    >>> at_least(Pattern("Block", branch=(0,)), 2.0), at_least(Threshold("height", 3.5), 1.0)
    ('{Block:0} >= 2', '$height < 3.5')
    """
    if isinstance(feature, Threshold):
        # For a name that is drawn once; if it is drawn several times, this is the mean of the draws.
        return f"${feature.site} < {_number(feature.bound)}"
    if isinstance(feature, Present):
        return f"{_read(feature.feature)} != 0"
    value = f"({feature})" if isinstance(feature, Formula) else _read(feature)
    return f"{value} >= {_number(bound)}"


def sites_of(feature: Feature) -> tuple[str, ...]:
    """Names of the draws that a feature reads; () for counts of patterns.

    >>> sites_of(Threshold("height", 3.5)), sites_of(Pattern("Block"))
    (('height',), ())
    """
    match feature:
        case Draw(site) | Threshold(site):
            return (site,)
        case Formula():
            return tuple(dict.fromkeys(site for read in feature.features for site in sites_of(read)))
        case _:
            return ()


def patterns_of(feature: Feature) -> tuple[Pattern, ...]:
    """Patterns that a feature counts alone, or as what a formula reads.

    >>> patterns_of(Formula.of("+", Pattern("Block"), Draw("height")))
    (Pattern(symbol='Block', parameters=None, branch=None, below=()),)
    """
    inner = feature.feature if isinstance(feature, Present) else feature
    reads = inner.features if isinstance(inner, Formula) else (inner,)
    return tuple(read for read in reads if isinstance(read, Pattern))


def _read(feature: Pattern | Draw) -> str:
    if isinstance(feature, Pattern):
        return f"{{{feature}}}"
    return f"${feature.site}" if feature.branch is None else f"${feature.site}:{feature.branch}"


def _number(value: float) -> str:
    return repr(value).removesuffix(".0")
