"""Meanings of the columns of a table: the feature of a key, and its choice.

There are the keys of `paths` and `pairs`, and:

    ("symbol", symbol)          nodes of a symbol
    ("draw", name)              the mean of the draws of a name
    ("branch", name, number)    how often a random expression of a name drew a number
    ("extra", number)           an additional feature
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from grammarlab.features.patterns.node_labels import Key, NodeLabels
from grammarlab.features.patterns.pattern import Below, Draw, Feature, Pattern

Steps: TypeAlias = tuple[tuple[int, int], ...]
"""A path from its top: labels, each with the ``child`` through which the path continues; -1 at its end."""


class Meaning:
    """Keys of one table as paths of labels."""

    def __init__(self, labels: NodeLabels, keys: Sequence[Key], extra: Sequence[Feature]) -> None:
        self._labels = labels
        self._keys = keys
        self._extra = extra

    def steps(self, key: Key) -> Steps:
        """Path of a "rule" or "edge" key."""
        kind, above, last = key
        if kind == "edge":
            *before, (label, _) = self.steps(self._key(above))
            return (*before, (label, last))
        return (*self.context(above), (last, -1))

    def context(self, column: int) -> Steps:
        """Path of the "edge" key of a column; empty for -1."""
        return self.steps(self._key(column)) if column >= 0 else ()

    def feature(self, key: Key) -> Feature:
        """The feature of a column."""
        match key:
            case ("rule" | "edge", _, _):
                return self._path(self.steps(key))
            case ("far", rule, child, label):
                return self._path(((rule, child),), Below((self.node(label),), deep=True))
            case ("next", first, second):
                return Pattern(below=(Below((self.node(first), self.node(second))),))
            case ("symbol", symbol):
                return Pattern(self._labels.symbols[symbol])
            case ("draw", name):
                return Draw(name)
            case ("branch", name, number):
                return Draw(name, number)
            case _:
                return self._extra[key[1]]

    def group(self, key: Key) -> Key:
        """The choice to which a column belongs: equal for all alternatives of one choice in one context.

        Other columns have their own groups. So do pairs of siblings: a person who likes a cylinder above a box may be
        indifferent to all other pairs of blocks.
        """
        match key:
            case ("edge", above, _):
                return self.group(self._key(above))
            case ("rule", context, label):
                rule = self._labels.rules[label]
                return "rule", context, rule.symbol, rule.parameters
            case ("far", rule, child, label):
                return "far", rule, child, self._labels.symbol_of(label)
            case ("branch", name, _):
                return "draw", name
            case ("symbol", symbol) if self.is_alternative(key):
                return "either", self._labels.exchangeable[self._labels.symbols[symbol]]
            case _:
                return key

    def is_choice(self, key: Key) -> bool:
        """Whether a column counts a rule that is chosen at random."""
        return key[0] == "rule" and bool(self._labels.chosen[key[2]])

    def is_alternative(self, key: Key) -> bool:
        """Whether a column counts a symbol that is an alternative of a choice."""
        return key[0] == "symbol" and self._labels.symbols[key[1]] in self._labels.exchangeable

    def sort_key(self, key: Key) -> Key:
        """Sort key of a key among those of its kind: paths are ordered by their labels, from the top."""
        return self.steps(key) if key[0] in {"rule", "edge"} else key[1:]

    def _key(self, column: int) -> Key:
        return self._keys[column]

    def node(self, label: int, *below: Below) -> Pattern:
        """A node that a rule rewrote, with the number of parameters only if it distinguishes overloads."""
        rule = self._labels.rules[label]
        parameters = rule.parameters if self._labels.is_overloaded(rule.symbol) else None
        return Pattern(rule.symbol, parameters, rule.branch, below)

    def _path(self, steps: Steps, *end: Below) -> Pattern:
        """A path as a pattern, with conditions on the node at its end."""
        *before, (label, child) = steps
        last = Below((Pattern(below=end),), child)
        pattern = self.node(label, *([] if child < 0 else [last]))
        for label, child in reversed(before):
            pattern = self.node(label, Below((pattern,), child))
        return pattern
