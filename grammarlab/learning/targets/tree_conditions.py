"""Regression trees over named numbers as expressions that a person reads: conditions joined by and and or."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammarlab.features.patterns.conditions import at_least
from grammarlab.features.patterns.pattern import Draw
from grammarlab.learning.targets.explanation import MAX_PARTS
from grammarlab.preference.simplified import SimplifiedPreference


def rule_text(preference: SimplifiedPreference, names: Sequence[str]) -> str:
    """A function of columns as an expression (`grammarlab.features.expression`).

    Args:
        preference: the function.
        names: [F] names of the columns.

    >>> from grammarlab.preference.regression_tree import Split
    >>> tree = (Split(0, 0, 2.0), Split(1, 1, 0.5), Split(1, 0, 8.0))
    >>> rule_text(SimplifiedPreference(tree, np.array([0.0, 1.0, 0.0, 0.0])), ["height", "lean"])
    '2 <= $height < 8 and $lean < 0.5'
    """
    preference = preference.pruned()
    cases = _cases(preference, names)
    if not 0 < len(cases) <= MAX_PARTS or any(not condition for condition, _ in cases):
        return preference.text(lambda column, bound: at_least(Draw(names[column]), bound))
    if all(value == 1.0 for _, value in cases):
        return " or ".join(condition for condition, _ in cases)
    return f"choose({', '.join(f'{condition}, {value:.5g}' for condition, value in cases)}, 0)"


def _cases(preference: SimplifiedPreference, names: Sequence[str]) -> list[tuple[str, float]]:
    """Conditions and values of the leaves with values above 0, largest first."""
    ranges: list[dict[int, tuple[float, float]]] = [{}]
    for split in preference.tree:
        low, high = ranges[split.leaf].get(split.column, (-np.inf, np.inf))
        ranges.append({**ranges[split.leaf], split.column: (max(low, split.bound), high)})
        ranges[split.leaf] = {**ranges[split.leaf], split.column: (low, min(high, split.bound))}
    order = np.argsort(-preference.scores, kind="stable").tolist()
    return [(_all_of(ranges[leaf], names), score) for leaf in order if (score := float(preference.scores[leaf])) > 0.0]


def _all_of(ranges: dict[int, tuple[float, float]], names: Sequence[str]) -> str:
    return " and ".join(_range(names[column], *ranges[column]) for column in sorted(ranges))


def _range(name: str, low: float, high: float) -> str:
    if not np.isfinite(low):
        return f"${name} < {_number(high)}"
    return f"${name} >= {_number(low)}" if not np.isfinite(high) else f"{_number(low)} <= ${name} < {_number(high)}"


def _number(value: float) -> str:
    return repr(float(value)).removesuffix(".0")
