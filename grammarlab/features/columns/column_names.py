"""Readable names for columns, groups and found features: ``Tower (3 Block) › Block 3 → CylinderBlock``.

A branch of a rule is named after a successor that no other branch has, or after the number of a successor
if every branch has a different number; otherwise after its percentage, with the line if two percentages are equal, or
after the line alone if percentages differ between models: those of proposals are not those in the text.

Half-spaces of draws are comparisons (``a > b``, ``a + b > 12.3``, ``a * b at most 12``), and totals of equal choices
are equalities (``same choice at Tower > Block@0 and Tower > Block@1``).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.features.columns.column_keys import Meaning, Steps
from grammarlab.features.patterns.node_labels import Key, NodeLabels
from grammarlab.features.patterns.pattern import Below, Draw, Feature, HalfSpace, Pattern, Present, Total

_NEGLIGIBLE_SHARE = 0.01
"""Share of the range of a sum below which its bound is written as 0; bounds found by few scores are not more exact."""


class ColumnNames:
    """Words for the keys and groups of one table."""

    def __init__(self, labels: NodeLabels, meaning: Meaning) -> None:
        self._labels = labels
        self._meaning = meaning
        self.branch: Callable[[int], str] = cache(self._branch)

    def column(self, key: Key, feature: Feature) -> str:
        """Name of a column; not always unique."""
        text = self._key(key, feature)
        return f"any {text.removeprefix('number of ')}" if isinstance(feature, Present) else text

    def group(self, group: Key) -> str:
        """Name of a group of columns (`Meaning.group`)."""
        match group:
            case ("rule", column, symbol, _):
                context = self._meaning.context(column)
                return self._before(context) + self._end(context, symbol)
            case ("far", rule, child, symbol):
                return f"{self._steps(((rule, child),))} ⋯ {symbol}"
            case ("draw", name):
                return name
            case ("either", name):
                symbols = sorted(s for s, first in self._labels.exchangeable.items() if first == name)
                return f"number of {' / '.join(symbol.removesuffix('.') for symbol in symbols)}"
            case _:
                return self._key(group, self._meaning.feature(group))

    def _key(self, key: Key, feature: Feature) -> str:
        match key:
            case ("rule" | "edge", _, _):
                return self._steps(self._meaning.steps(key))
            case ("far", rule, child, label):
                return f"{self._steps(((rule, child),))} ⋯ {self._choice(label)}"
            case ("next", first, second):
                return f"{self._choice(first)} then {self._choice(second)}"
            case ("symbol", symbol):
                return f"number of {self._labels.symbols[symbol].removesuffix('.')}"
            case ("branch", name, number):
                return f"{name} = {number}"
            case _:
                return str(feature)

    def _steps(self, steps: Steps) -> str:
        *context, (label, child) = steps
        branch = self.branch(label)
        if child >= 0:
            return self._before(steps) + self._successor(label, child)
        end = self._end(tuple(context), self._labels.symbol_of(label))
        return self._before(tuple(context)) + end + (f" → {branch}" if branch else "")

    def _before(self, context: Steps) -> str:
        """The nodes of a context, each with its branch."""
        text = ""
        for depth, (label, _) in enumerate(context):
            branch = self.branch(label)
            node = self._end(context[:depth], self._labels.symbol_of(label))
            text += f"{node} ({branch}) › " if branch else f"{node} › "
        return text

    def _end(self, context: Steps, symbol: str) -> str:
        """The node at the end of a context."""
        if not context:
            return symbol
        label, child = context[-1]
        return self._successor(label, child)

    def _successor(self, label: int, child: int) -> str:
        """Name of a successor of a rule: its symbol, numbered if the rule makes several of it."""
        successors = self._labels.successors[label]
        same = [index for index, symbol in successors.items() if symbol == successors.get(child)]
        if child not in successors:
            return f"successor {child + 1}"
        return successors[child] + (f" {same.index(child) + 1}" if len(same) > 1 else "")

    def _choice(self, label: int) -> str:
        return f"{self._labels.symbol_of(label)} → {self.branch(label)}"

    def _branch(self, label: int) -> str:
        """The name of a branch; empty for a rule without others."""
        labels = self._labels
        others = [other for other in labels.alternatives(label) if other != label]
        if not others:
            return ""
        counter = Counter(labels.successors[label].values())
        elsewhere = [Counter(labels.successors[other].values()) for other in others]
        unique = [symbol for symbol in counter if not any(symbol in other for other in elsewhere)]
        if unique:
            return unique[0].removesuffix(".")
        for symbol in dict.fromkeys(symbol for counts in (counter, *elsewhere) for symbol in counts):
            numbers = [counts[symbol] for counts in (counter, *elsewhere)]
            if len(set(numbers)) == len(numbers):
                return f"{counter[symbol]} {symbol}" if counter[symbol] else f"no {symbol}"
        line = f"line {labels.rules[label].line}"
        chance = self._percentage(label)
        if not chance or any(math.isnan(labels.chances[other]) for other in others):
            return line
        return chance if all(self._percentage(other) != chance for other in others) else f"{chance}, {line}"

    def _percentage(self, label: int) -> str:
        chance = self._labels.chances[label]
        return "" if math.isnan(chance) or chance >= 1.0 else f"{100.0 * chance:.3g}%"


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
    left_terms = [(site, weight) for site, weight in terms if weight > 0.0]
    right_terms = [(site, -weight) for site, weight in terms if weight < 0.0]
    bound = 0.0 if abs(space.bound) < _NEGLIGIBLE_SHARE * spread else sign * space.bound
    side = _product if space.logarithmic else _sum
    relation = (("at least", "<") if sign > 0.0 else ("at most", ">"))[holds]
    return f"{side(left_terms, 0.0)} {relation} {side(right_terms, bound)}"


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


def equality(total: Total) -> str:
    """What a total says that counts choices made alike; empty for other totals.

    >>> from grammarlab.features.patterns.pattern_text import parse
    >>> equality(Total(((parse("Tower[Block@0:0, Block@1:0]"), 1), (parse("Tower[Block@0:1, Block@1:1]"), 1))))
    'same choice at Tower > Block@0 and Tower > Block@1'
    >>> equality(Total(((parse("*[Block > A:0 + Block > A:0]"), 1), (parse("*[Block > A:2 + Block > A:2]"), 1))))
    'adjacent Block with the same choice at A'
    >>> equality(Total(((parse("Tower:0"), 1), (parse("Tower:1"), 1))))
    ''
    """
    patterns = [feature for feature, weight in total.terms if isinstance(feature, Pattern) and weight == 1]
    bare = {_without_branch(pattern) for pattern in patterns}
    if len(patterns) < max(len(total.terms), 2) or len(bare) != 1:
        return ""
    pattern = bare.pop()
    match pattern.below:
        case (Below(run=(_,)) as first, Below(run=(_,)) as second):
            return f"same choice at {_location(pattern, first)} and {_location(pattern, second)}"
        case (Below(run=(first, second)),) if first == second:
            inner = f" at {first.below[0].run_text()}" if first.below else ""
            return f"adjacent {first.symbol or 'parts'} with the same choice{inner}"
        case _:
            return ""


def _product(terms: Sequence[tuple[str, float]], logarithm: float) -> str:
    """Product of powers, and of a factor that is given by its logarithm."""
    powers = [_with_number(site, weight, "{site}^{number}") for site, weight in terms]
    factor = [] if powers and logarithm == 0.0 else [f"{np.exp(logarithm):.3g}"]
    return " * ".join([*factor, *powers])


def _with_number(site: str, weight: float, form: str) -> str:
    number = f"{weight:.3g}"
    return site if number == "1" else form.format(number=number, site=site)


def _sum(terms: Sequence[tuple[str, float]], constant: float) -> str:
    text = " + ".join(_with_number(site, weight, "{number} {site}") for site, weight in terms)
    if not text:
        return f"{constant:.3g}"
    return text if constant == 0.0 else f"{text} {'-' if constant < 0.0 else '+'} {abs(constant):.3g}"


def _without_branch(pattern: Pattern) -> Pattern:
    """A pattern without the branch of its lowest nodes."""
    below = tuple(replace(condition, run=tuple(map(_without_branch, condition.run))) for condition in pattern.below)
    return replace(pattern, below=below, branch=pattern.branch if below else None)


def _location(top: Pattern, below: Below) -> str:
    return below.run_text() if below.deep else str(replace(top, below=(below,)))
