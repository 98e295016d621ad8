"""Symbols split by outside weights: the exact grammar before it becomes text.

A variant is a symbol with outside weights. Those of the start symbol are the preference itself; every rule passes
them to its successors, and each new combination of a symbol and outside weights becomes a variant. A symbol with
constant outside weights is not split. The weight of a variant is the sum, over all its trees, of probability times
outside weight: an inside weight. With these, the probability of an alternative is p(alternative) x weights of its
successors / weight of the variant.

The *outside weights* of a symbol are one number per state: the value, under the preference, of the rest of the tree.
Only proportions matter, so states with proportional outside weights everywhere are not distinguished. A node
whose children were read by a `Scan` has joint outside weights for all of them; `_decompose` writes these as a sum of
products with one factor per child, which a grammar can express: choose the summand, then derive each child with its
own outside weights.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import prod
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Floats, Ints
from grammarlab.density.exact.attributes import AttributeParts
from grammarlab.density.exact.automaton import Automaton, Scan, ScanStep
from grammarlab.density.grammar_skeleton import Alternative, Body, Cases, Chance, leaves
from grammarlab.errors import InexactError
from grammarlab.language.call_order import groups
from grammarlab.language.numbering import Branch, Successor, SymbolKey

Base: TypeAlias = Literal["grammar", "uniform"]
MAX_WAYS = 20_000
"""Largest number of alternatives of all variants, and of split symbols."""
PLAIN = -1
"""Marks the original symbol, instead of a variant."""
_DIGITS = 44
"""Binary digits that equal weights share: relative 6e-14."""
_MAX_COMPONENTS = 200
"""Largest number of branches of the start rule that depend on attributes."""


@dataclass(frozen=True, slots=True)
class Way:
    """An assignment of variants to the successors of an alternative."""

    weight: float
    children: Mapping[int, int]
    """Variant by index of the successor; others are `PLAIN`."""
    copies: Mapping[int, int] = field(default_factory=dict)
    """Number of times that these successors occur; others occur once."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A symbol with outside weights."""

    key: SymbolKey
    future: Floats
    """[S] outside weight of each state of the symbol; the largest is 1."""
    ways: Mapping[Branch | None, tuple[Way, ...]]
    """Assignments of each alternative; none if it is impossible."""


@dataclass(frozen=True, slots=True)
class Component:
    """A summand of the preference: weights of attributes with a variant of the start symbol."""

    weight: float
    attributes: tuple[Floats, ...]
    """Weights [parts] of each attribute; the largest is 1."""
    start: int
    """Variant of the start symbol."""


@dataclass(frozen=True, slots=True)
class Splitting:
    """All needed variants, and the starts of derivations."""

    automaton: Automaton
    attributes: tuple[AttributeParts, ...]
    base: Base
    variants: tuple[Variant, ...]
    components: tuple[Component, ...]


def split(
    automaton: Automaton,
    attributes: Sequence[AttributeParts],
    preference: Callable[[NDArray[np.int64], NDArray[np.int64]], Floats],
    base: Base = "grammar",
    max_ways: int = MAX_WAYS,
) -> Splitting:
    """Split the symbols of a grammar by a preference.

    Args:
        automaton: counts the patterns that the preference reads.
        attributes: the drawn attributes that the preference reads.
        preference: from counts of patterns [n, patterns] and of attribute features [n, attribute features] to values
            [n], finite and at least 0.
        base: the weights that the preference multiplies: the probabilities of the grammar, or 1 for every tree.
        max_ways: largest number of alternatives of the result.

    Raises:
        InexactError: If it would have more.
    """
    build = _Build(automaton, base, max_ways)
    components = tuple(build.components(attributes, preference))
    build.run()
    return Splitting(automaton, tuple(attributes), base, tuple(build.variants), components)


def snapped(weights: Floats) -> Floats:
    """Weights without the digits that rounding errors may change."""
    mantissa, exponent = np.frexp(weights)
    return np.ldexp(np.rint(np.ldexp(mantissa, _DIGITS)), exponent - _DIGITS)


class _Build:
    def __init__(self, automaton: Automaton, base: Base, max_ways: int) -> None:
        self.automaton = automaton
        self.tree = automaton.components.tree
        self.free = _uncounted(automaton) if base == "uniform" else frozenset(self.tree.reachable)
        """Symbols that are not split if their outside weights are constant."""
        self.max_ways = max_ways
        self.num_ways = 0
        self.numbers: dict[tuple[SymbolKey, bytes], int] = {}
        self.waiting: list[tuple[SymbolKey, Floats]] = []
        self.variants: list[Variant] = []

    def components(
        self,
        attributes: Sequence[AttributeParts],
        preference: Callable[[NDArray[np.int64], NDArray[np.int64]], Floats],
    ) -> list[Component]:
        """The preference as a sum of products of attribute weights and tree weights."""
        totals = self.automaton.totals
        sizes = [len(attribute.parts) for attribute in attributes]
        if float(np.prod([*sizes, float(len(totals))])) > self.max_ways * 50:
            raise InexactError("the preference distinguishes too many combinations of attributes and trees")
        combinations = np.indices([*sizes, len(totals)]).reshape(len(sizes) + 1, -1)
        drawn = [attribute.counts[index] for attribute, index in zip(attributes, combinations, strict=False)]
        none = np.zeros((combinations.shape[1], 0), dtype=np.int64)
        values = preference(totals[combinations[-1]], np.concatenate([none, *drawn], axis=1))
        products = _decompose(_side_by_side([*sizes, len(totals)]), values, _MAX_COMPONENTS)
        return [
            Component(product.weight, product.futures[:-1], self._variant(self.tree.start, product.futures[-1]))
            for product in products
        ]

    def run(self) -> None:
        """Split until no variant is missing."""
        while len(self.variants) < len(self.waiting):
            key, future = self.waiting[len(self.variants)]
            ways = {
                alternative.branch: self._ways(key, alternative.branch, alternative.successors, future)
                for alternative in leaves(self.tree.body(key))
            }
            self.variants.append(Variant(key, future, ways))

    def _variant(self, key: SymbolKey, future: Floats) -> int:
        if key in self.free and (snapped(future) == 1.0).all():
            return PLAIN
        address = key, snapped(future).tobytes()
        if address not in self.numbers:
            self.numbers[address] = len(self.waiting)
            self.waiting.append((key, future))
        return self.numbers[address]

    def _ways(
        self, key: SymbolKey, branch: Branch | None, successors: Sequence[Successor], future: Floats
    ) -> tuple[Way, ...]:
        scan = self._scan(key, branch)
        if scan is None:
            return ()
        read = {step.child for step in scan.steps}
        others = {
            child: variant
            for child, successor in enumerate(successors)
            if child not in read and (variant := self._unread(successor)) != PLAIN
        }
        copies = {child: count for child in others if (count := successors[child].copies or 1) != 1}
        ways: list[Way] = []
        for product in _decompose(scan, future, self.max_ways):
            children = {
                step.child: variant
                for step, outside in zip(scan.steps, product.futures, strict=True)
                if (variant := self._variant(step.key, outside)) != PLAIN
            }
            ways.append(Way(product.weight, {**others, **children}, copies))
        self.num_ways += len(ways)
        if self.num_ways > self.max_ways:
            raise InexactError(f"the grammar would have more than {self.max_ways:,} alternatives")
        return tuple(ways)

    def _scan(self, key: SymbolKey, branch: Branch | None) -> Scan | None:
        """Scan of the children of an alternative; None if no derivation of it ends."""
        if self.automaton.components.active[key]:
            return self.automaton.scans.get((key, branch))
        return Scan((), np.zeros(1, dtype=np.int64))

    def _unread(self, successor: Successor) -> int:
        """The variant of a successor that no state depends on."""
        if successor.key in self.free:
            return PLAIN
        return self._variant(successor.key, np.ones(len(self.automaton.states[successor.key])))


def _uncounted(automaton: Automaton) -> frozenset[SymbolKey]:
    """Symbols that a uniform base does not change: those with one tree, and those without a finite number of trees.

    The number of trees is undefined if a symbol is recursive, occurs a number of times that depends on sizes, or has
    different numbers of trees in different cases.
    """
    tree, active = automaton.components.tree, automaton.components.active
    calls = {key: tuple({s.key for a in tree.alternatives(key) for s in a.successors}) for key in tree.reachable}
    number: dict[SymbolKey, int] = {}
    for group in groups(calls):
        for key in group:
            if active[key] and key in tree.bodies:
                number[key] = 0
            elif len(group) > 1 or key in calls[key]:
                number[key] = 1
            else:
                number[key] = _num_trees(tree.body(key), number) or 1
    return frozenset(key for key, count in number.items() if count == 1)


def _num_trees(body: Body, number: Mapping[SymbolKey, int]) -> int | None:
    """Number of trees of a body, from those of its successors; None if it depends on sizes or conditions."""
    if isinstance(body, Alternative):
        if any(successor.copies is None and number[successor.key] > 1 for successor in body.successors):
            return None
        return prod(number[successor.key] ** (successor.copies or 0) for successor in body.successors)
    if isinstance(body, Chance) and body.probabilities is None:
        return None
    counts = [_num_trees(branch, number) for branch in body.branches]
    finite = [count for count in counts if count is not None]
    if len(finite) < len(counts) or (isinstance(body, Cases) and len(set(finite)) > 1):
        return None
    return finite[0] if isinstance(body, Cases) else sum(finite)


def _decompose(scan: Scan, future: Floats, max_products: int) -> list[_OutsideTerm]:
    """Joint outside weights of the children of a scan as a sum of products.

    A decision diagram over the children is built from the last child to the first; nodes whose branches are
    proportional are one. Each path from the top to the end is a product.

    Args:
        scan: computes the state of the parent from the states of the children.
        future: [S] outside weights of the parent.
        max_products: largest number of products.

    Raises:
        InexactError: If there are more products.
    """
    levels: list[tuple[Floats, Ints]] = []
    scale = future[scan.final]
    node = np.where(scale > 0.0, 0, -1)
    for step in reversed(scan.steps):
        weights, below = scale[step.next], node[step.next]
        scale = weights.max(axis=1, initial=0.0)
        weights = np.divide(weights, scale[:, None], out=np.zeros_like(weights), where=scale[:, None] > 0.0)
        first, node = _distinct(weights, below)
        node = np.where(scale > 0.0, node, -1)
        levels.append((weights[first], below[first]))
    products: list[_OutsideTerm] = []
    for product in _paths(levels[::-1], float(scale[0]), int(node[0])):
        products.append(product)
        if len(products) > max_products:
            raise InexactError(
                f"some rule would need more than {max_products:,} alternatives to keep its parts in step: too many "
                "for an exact grammar"
            )
    return products


@dataclass(frozen=True, slots=True)
class _OutsideTerm:
    """A summand: a weight times outside weights of each child of a scan."""

    weight: float
    futures: tuple[Floats, ...]
    """Outside weights [S] for each step of the scan; the largest is 1."""


def _distinct(weights: Floats, below: Ints) -> tuple[Ints, Ints]:
    """Classes of rows that are equal up to rounding: the first row of each [K], and the class of each row."""
    if len(weights) == 1:
        return np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64)
    rows = np.concatenate([snapped(weights), below.astype(np.float64)], axis=1)
    _, first, kind = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, kind.reshape(-1)


def _paths(levels: list[tuple[Floats, Ints]], scale: float, top: int) -> Iterator[_OutsideTerm]:
    """The paths of the diagram from a node, depth first."""
    if top < 0:
        return
    waiting: list[tuple[int, int, tuple[Floats, ...], float]] = [(0, top, (), scale)]
    while waiting:
        level, node, futures, weight = waiting.pop()
        if level == len(levels):
            yield _OutsideTerm(weight, futures)
            continue
        weights, below = levels[level][0][node], levels[level][1][node]
        for target in sorted({int(t) for t in below if t >= 0}, reverse=True):
            future = np.where(below == target, weights, 0.0)
            largest = float(future.max())
            waiting.append((level + 1, target, (*futures, future / largest), weight * largest))


def _side_by_side(sizes: Sequence[int]) -> Scan:
    """A scan whose state has the states of all children."""
    steps: list[ScanStep] = []
    num_states = 1
    for child, size in enumerate(sizes):
        steps.append(ScanStep(child, ("", 0), np.arange(num_states * size).reshape(num_states, size)))
        num_states *= size
    return Scan(tuple(steps), np.arange(num_states))
