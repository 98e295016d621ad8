"""Readable names for columns, groups and found features: ``Tower (3 Block) › Block 3 → CylinderBlock``.

A branch of a rule is named after a successor that no other branch has, or after the number of a successor
if every branch has a different number; otherwise after its percentage, with the line if two percentages are equal, or
after the line alone if percentages differ between models: those of proposals are not those in the text.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from functools import cache

from grammarlab.features.columns.column_keys import Meaning, Steps
from grammarlab.features.patterns.node_labels import Key, NodeLabels
from grammarlab.features.patterns.pattern import Feature, Present


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
        if all(other.keys() != counter.keys() for other in elsewhere):
            return self._together(counter, elsewhere)
        line = f"line {labels.rules[label].line}"
        chance = self._percentage(label)
        if not chance or any(math.isnan(labels.chances[other]) for other in others):
            return line
        return chance if all(self._percentage(other) != chance for other in others) else f"{chance}, {line}"

    def _together(self, counter: Counter[str], elsewhere: list[Counter[str]]) -> str:
        """What a branch makes, if no other one makes just these symbols."""
        if not counter:
            return "nothing"
        only = "only " if any(counter.keys() < other.keys() for other in elsewhere) else ""
        return only + " and ".join(symbol.removesuffix(".") for symbol in counter)

    def _percentage(self, label: int) -> str:
        chance = self._labels.chances[label]
        return "" if math.isnan(chance) or chance >= 1.0 else f"{100.0 * chance:.3g}%"
