"""Readable names for columns, groups and any other features: ``Tower (3 Block) › Block 3 → CylinderBlock``.

A branch of a rule is named after a successor that no other branch has, or after the number of a successor
if every branch has a different number; otherwise after its percentage, with the line if two percentages are equal, or
after the line alone if percentages differ between models: those of proposals are not those in the text. Branches on one
line are numbered.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import cache

from grammarlab.features.columns.column_keys import Meaning, Steps
from grammarlab.features.patterns.node_labels import Key, NodeLabels
from grammarlab.features.patterns.pattern import Below, Draw, Feature, Pattern, Present, Threshold

BESIDE = " beside "
"""What connects neighbours: ``Wall = Brick beside Wall = Glass``."""
_ANY = "any"
"""A node of any symbol below another one."""


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
            return self._before(steps) + self.successor(label, child)
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
        return self.successor(label, child)

    def successor(self, label: int, child: int) -> str:
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
        line = self._line(label)
        chance = self._percentage(label)
        if not chance or any(math.isnan(labels.chances[other]) for other in others):
            return line
        return chance if all(self._percentage(other) != chance for other in others) else f"{chance}, {line}"

    def _line(self, label: int) -> str:
        """The line of a branch, with its number if the line has several."""
        rules = self._labels.rules
        here = [other for other in self._labels.alternatives(label) if rules[other].line == rules[label].line]
        line = f"line {rules[label].line}"
        if len(here) == 1:
            return line
        branches = sorted(rules[other].branch for other in self._labels.alternatives(label))
        return f"{line} branch {branches.index(rules[label].branch) + 1}"

    def _together(self, counter: Counter[str], elsewhere: list[Counter[str]]) -> str:
        """What a branch makes, if no other one makes just these symbols."""
        if not counter:
            return "nothing"
        only = "only " if any(counter.keys() < other.keys() for other in elsewhere) else ""
        return only + " and ".join(symbol.removesuffix(".") for symbol in counter)

    def _percentage(self, label: int) -> str:
        chance = self._labels.chances[label]
        return "" if math.isnan(chance) or chance >= 1.0 else f"{100.0 * chance:.3g}%"


class FeatureNames:
    """Words for any features: names of the columns of a table, and names of the same form for what is not a column.

    >>> from grammarlab.derivation import derive
    >>> from grammarlab.language.grammar import Grammar
    >>> text = "Lot --> Tower Tower  Tower --> 30% : Brick else : Glass"
    >>> names = FeatureNames({}, NodeLabels.of([derive(Grammar.parse(text), 50, seed=1)]))
    >>> names[Pattern("Lot", below=(Below((Pattern("Tower", branch=(1,)),), child=1),))]
    'Lot › Tower 2 → Glass'
    >>> names[Pattern(below=(Below((Pattern("Tower", branch=(0,)), Pattern("Tower", branch=(1,)))),))]
    'Tower = Brick beside Tower = Glass'
    """

    def __init__(self, columns: Mapping[Feature, str] | None = None, labels: NodeLabels | None = None) -> None:
        """Words for features.

        Args:
            columns: names of the columns of a table.
            labels: labels of the nodes of its models; None if the models have no nodes.
        """
        self._columns = columns or {}
        self._labels = labels or NodeLabels.of(())
        self._names = ColumnNames(self._labels, Meaning(self._labels, (), ()))

    def __getitem__(self, feature: Feature) -> str:
        return self._columns.get(feature) or self._name(feature)

    def _name(self, feature: Feature) -> str:
        """Name of what is not a column; a formula has its text."""
        match feature:
            case Pattern(symbol=str(symbol), branch=None | (), below=()):
                return f"number of {symbol.removesuffix('.')}"
            case Pattern():
                return self._node(feature, (feature.symbol or "").removesuffix("."))
            case Draw(site, branch):
                return site if branch is None else f"{site} = {branch}"
            case Threshold():
                return threshold_words(feature)
            case Present(inner):
                return f"any {self[inner].removeprefix('number of ')}"
            case _:
                return str(feature)

    def place(self, pattern: Pattern) -> str:
        """The place of the lowest node of a pattern, without branches: ``Lot › Tower 2``."""
        words, above = [(pattern.symbol or "").removesuffix(".")], pattern
        while above.below:
            below = above.below[-1]
            words.append(self._successor(above, below))
            above = below.run[-1]
        place = " › ".join(filter(None, words))
        return "parts" if place in {"", _ANY} else place

    def _node(self, node: Pattern, place: str) -> str:
        """A node with all below it, after the words for its own place."""
        branch = self._branch(node)
        if not node.below:
            return f"{place or 'parts'} → {branch}" if branch else place or "parts"
        here = f"{place or 'parts'} ({branch})" if branch else place
        words = [self._below(node, below, here) for below in node.below]
        return words[0] if len(words) == 1 else " with ".join(map(_as_value, words))

    def _below(self, node: Pattern, below: Below, here: str) -> str:
        """Some nodes below a node, whose own words are ``here``."""
        *others, last = below.run
        if others:
            words = BESIDE.join(_as_value(self._node(each, each.symbol or _ANY)) for each in below.run)
            return f"{here} › {words}" if here else words
        successor = self._successor(node, below)
        place = (" ⋯ " if below.deep else " › ").join(filter(None, (here, successor)))
        # What is below any node is like any node.
        return self._node(last, "" if place == _ANY else place)

    def _branch(self, node: Pattern) -> str:
        """The branch that a node must have, empty for any."""
        if not node.branch:
            return ""
        labels = self._rules(node)
        if not labels:
            return f"alternative {'.'.join(str(number + 1) for number in node.branch)}"
        return " / ".join(dict.fromkeys(filter(None, map(self._names.branch, labels))))

    def _successor(self, above: Pattern, below: Below) -> str:
        """The last node of a run: its symbol, numbered if a rule makes several of it.

        Of any symbol, it is ``successor 1`` or ``any`` if a rule has to rewrite it, otherwise empty.
        """
        symbol, is_rewritten = below.run[-1].symbol, below.run[-1].branch is not None
        child = below.child if len(below.run) == 1 and not below.deep else None
        if child is None:
            return (symbol or (_ANY if is_rewritten else "")).removesuffix(".")
        made = [(self._labels.successors[label].get(child), label) for label in self._rules(above)]
        if symbol is None:
            symbols = {each for each, _ in made}
            symbol = symbols.pop() if len(symbols) == 1 else None
        if symbol is None:
            return f"successor {child + 1}" if is_rewritten else ""
        bare = symbol.removesuffix(".")
        names = [self._names.successor(label, child).replace(symbol, bare) for each, label in made if each == symbol]
        # With its number if any of the rules makes several of it.
        return max(names, key=len) if names else f"{bare} (successor {child + 1})"

    def _rules(self, node: Pattern) -> Sequence[int]:
        """Labels of the rules that may have rewritten a node."""
        branch = node.branch or ()
        return [
            label
            for label, rule in enumerate(self._labels.rules)
            if node.symbol in (None, rule.symbol)
            and node.parameters in (None, rule.parameters)
            and rule.branch[: len(branch)] == branch
        ]


def threshold_words(threshold: Threshold, is_below: bool = True) -> str:
    """A draw compared with a number; a bound that is the next one above a shorter number is for the number itself.

    Args:
        threshold: the draw and its bound.
        is_below: whether the draw is below the bound.

    >>> threshold_words(Threshold("h", 3.0)), threshold_words(Threshold("h", math.nextafter(3.0, math.inf)))
    ('h below 3', 'h at most 3')
    >>> threshold_words(Threshold("h", math.nextafter(0.0, math.inf)), is_below=False)
    'h above 0'
    """
    before = math.nextafter(threshold.bound, -math.inf)
    is_next = len(repr(before)) < len(repr(threshold.bound))
    below, above = ("at most", "above") if is_next else ("below", "at least")
    return f"{threshold.site} {below if is_below else above} {before if is_next else threshold.bound:.4g}"


def _as_value(name: str) -> str:
    """A choice in a sentence about several: ``Wall = Brick`` for ``Wall → Brick``."""
    return name.replace(" → ", " = ")
