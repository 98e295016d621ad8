"""A mixture of grammars as split symbols: one grammar that begins by choosing a component."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.density.exact.automaton import Automaton
from grammarlab.density.exact.naming import AbstractNames
from grammarlab.density.exact.splitting import PLAIN, Component, Splitting, Variant, Way, snapped
from grammarlab.density.exact.subtree_counts import PatternComponents
from grammarlab.density.exact.trimming import Ways
from grammarlab.density.grammar_skeleton import Alternative
from grammarlab.density.samples.choices import Choices
from grammarlab.density.samples.mixture import Mixture
from grammarlab.features.patterns.pattern import Below
from grammarlab.language.numbering import Branch


@dataclass(frozen=True, slots=True)
class ContextVariant(Variant):
    """A symbol in a context, with the percentages of one component."""

    context: Hashable = field(kw_only=True)
    component: int = field(kw_only=True)
    """First component in which the symbol has these percentages."""


class ContextNames(AbstractNames):
    """Names variants after their component and context."""

    @property
    def _mixed(self) -> bool:
        return len(self._splitting.components) > 1

    def suffixes(self, variant: Variant, ways: Ways) -> list[str]:
        above = _edges(variant)
        where = f"in_{above[-1][0][0]}" if above else "there" if _conditions(variant) else ""
        number = f"{variant.component + 1}" if self._mixed and isinstance(variant, ContextVariant) else ""
        return ["_".join(word for word in (where, number) if word) or "learned"]

    def condition(self, variant: Variant) -> str:
        words: list[str] = []
        if self._mixed and isinstance(variant, ContextVariant):
            words.append(f"of component {variant.component + 1}")
        words += [f"{position + 1}. in {_rule(key[0], branch)}" for key, branch, position in _edges(variant)[::-1]]
        if _conditions(variant):
            words.append("where " + " or ".join(_conditions(variant)) + " counts")
        return ", ".join(words) or "with other percentages"


def as_splitting(choices: Choices, mixture: Mixture) -> Splitting:
    """Variants of a mixture's components; equal ones are merged.

    Args:
        choices: the learned choices.
        mixture: probabilities of the choices.
    """
    tree = choices.contexts.tree
    automaton = Automaton(PatternComponents(tree, ()), {}, {})
    kinds = _Kinds(choices, mixture)
    indices = range(len(choices.attributes))
    components = tuple(
        Component(float(weight), tuple(kinds.attribute(number, index) for index in indices), kinds.of(number, 0))
        for number, weight in enumerate(mixture.weights)
    )
    return Splitting(automaton, choices.attributes, "grammar", kinds.variants(), components)


class _Kinds:
    """Classes of equal symbols: K components times S symbols of the contexts."""

    def __init__(self, choices: Choices, mixture: Mixture) -> None:
        self.choices = choices
        self.contexts = choices.contexts
        original = np.where(choices.original > 0.0, choices.original, 1.0)
        self.ratio = snapped(np.where(choices.original > 0.0, mixture.probabilities / original, 1.0))
        self.alternatives = [tuple(self.contexts.tree.alternatives(key)) for key, _ in self.contexts.symbols]
        self.cells = {
            (symbol, alternative.branch): choices.cells(symbol, alternative.branch or ())
            for symbol, alternatives in enumerate(self.alternatives)
            for alternative in alternatives
        }
        self.weights = [self._weights(number) for number in range(len(mixture.weights))]
        self.kind = self._refined()
        self.order: dict[int, tuple[int, int]] = {}
        """Component and symbol that represent a class, by the class; without the plain symbol."""
        self._reach()
        self.number = {kind: i for i, kind in enumerate(self.order)}

    def of(self, component: int, symbol: int) -> int:
        """The variant of a symbol in a component."""
        return self.number.get(self.kind[component][symbol], PLAIN)

    def attribute(self, component: int, index: int) -> Floats:
        """Weights of the parts of an attribute in a component."""
        first = self.choices.first_of_attribute[index]
        return self.ratio[component, first : first + len(self.choices.attributes[index].parts)]

    def variants(self) -> tuple[Variant, ...]:
        """One for each kind."""
        return tuple(self._variant(component, symbol) for component, symbol in self.order.values())

    def _weights(self, component: int) -> list[tuple[float, ...]]:
        """For each symbol the weight of each alternative."""
        ratio = self.ratio[component].tolist()
        result: list[tuple[float, ...]] = []
        for symbol, alternatives in enumerate(self.alternatives):
            weights: list[float] = []
            for alternative in alternatives:
                weight = 1.0
                for cell in self.cells[symbol, alternative.branch]:
                    weight *= ratio[cell]
                weights.append(weight)
            result.append(tuple(weights))
        return result

    def _refined(self) -> list[list[int]]:
        """[K][S] the coarsest kinds whose members have equal weights and successors of equal kinds; 0 is plain."""
        symbols = self.contexts.symbols
        kinds = [[0] * len(symbols) for _ in self.weights]
        size = 0
        while True:
            classes: dict[object, int] = {}
            kinds = [
                [self._signed(classes, self._signature(component, symbol, kinds)) for symbol in range(len(symbols))]
                for component in range(len(kinds))
            ]
            if len(classes) == size:
                return kinds
            size = len(classes)

    @staticmethod
    def _signed(classes: dict[object, int], signature: object) -> int:
        return 0 if signature is None else classes.setdefault(signature, len(classes) + 1)

    def _signature(self, component: int, symbol: int, kinds: list[list[int]]) -> object:
        """Weights of a symbol in a component; None if they are the original ones."""
        weights = self.weights[component][symbol]
        below: list[tuple[int, ...]] = []
        for weight, alternative in zip(weights, self.alternatives[symbol], strict=True):
            children = self.contexts.children[symbol, alternative.branch] if weight > 0.0 else ()
            below.append(tuple(kinds[component][child] for child in children))
        if all(weight == 1.0 for weight in weights) and not any(kind for children in below for kind in children):
            return None
        return self.contexts.symbols[symbol][0], weights, tuple(below)

    def _reach(self) -> None:
        waiting = [(component, 0) for component in range(len(self.weights))][::-1]
        while waiting:
            component, symbol = waiting.pop()
            kind = self.kind[component][symbol]
            if kind == 0 or kind in self.order:
                continue
            self.order[kind] = component, symbol
            for weight, alternative in zip(self.weights[component][symbol], self.alternatives[symbol], strict=True):
                if weight > 0.0:
                    below = self.contexts.children[symbol, alternative.branch]
                    waiting += [(component, child) for child in below[::-1]]

    def _variant(self, component: int, symbol: int) -> ContextVariant:
        key, context = self.contexts.symbols[symbol]
        ways: Mapping[Branch | None, tuple[Way, ...]] = {
            alternative.branch: (self._way(component, symbol, alternative, weight),) if weight > 0.0 else ()
            for weight, alternative in zip(self.weights[component][symbol], self.alternatives[symbol], strict=True)
        }
        split = self.contexts.num_contexts[key] > 1
        # A symbol without states has the outside weight 1.
        return ContextVariant(key, np.ones(1), ways, context=context if split else (), component=component)

    def _way(self, component: int, symbol: int, alternative: Alternative, weight: float) -> Way:
        below = self.contexts.children[symbol, alternative.branch]
        variants = {position: self.of(component, child) for position, child in enumerate(below)}
        return Way(weight, {position: variant for position, variant in variants.items() if variant != PLAIN})


def _edges(variant: Variant) -> tuple:
    context = variant.context if isinstance(variant, ContextVariant) else ()
    return context if isinstance(context, tuple) else ()


def _conditions(variant: Variant) -> list[str]:
    context = variant.context if isinstance(variant, ContextVariant) else ()
    return sorted(str(below) for below in context if isinstance(below, Below)) if isinstance(context, frozenset) else []


def _rule(symbol: str, branch: Branch | None) -> str:
    return f"{symbol}:{'.'.join(map(str, branch))}" if branch else symbol
