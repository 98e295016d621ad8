"""What the rules of a written grammar have: remaining branches, their weights, and equal variants as one."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.density.exact.inside import InsideWeights, branch_weights
from grammarlab.density.exact.splitting import PLAIN, Splitting, Variant, Way
from grammarlab.density.exact.trimming import Trimming, Ways
from grammarlab.density.grammar_skeleton import Alternative, Body, Chance, leaves
from grammarlab.density.rounding import DIGITS
from grammarlab.language.numbering import Branch


@dataclass(frozen=True)
class WrittenRules:
    """Rules of the variants of a splitting."""

    splitting: Splitting
    weights: InsideWeights
    min_share: float = 0.0
    """Smallest probability of a branch that may be left out, 0 to 1; 0 keeps all branches."""

    @cached_property
    def trimming(self) -> Trimming:
        """Selects the branches."""
        return Trimming(self.splitting, self.weights, self.min_share)

    def of(self, number: int) -> int:
        """The variant whose rule is written for a variant: the first one with an equal rule."""
        return number if number == PLAIN else self._first[number]

    def ways(self, variant: Variant) -> Ways:
        """The ways of each alternative."""
        return self._ways[self._number[id(variant)]]

    def ways_of(self, variant: Variant, branch: Branch | None) -> tuple[Way, ...]:
        """The ways of one alternative."""
        return self.ways(variant).get(branch, ())

    def has(self, variant: Variant, body: Body) -> bool:
        """Whether a rule has a branch of a choice with percentages."""
        return any(self.ways_of(variant, alternative.branch) for alternative in leaves(body))

    def branch_weights(self, variant: Variant, chance: Chance) -> Floats:
        """[branches] weights of the branches of a choice, 0 for those left out."""
        return self._weights_of(variant, chance, self.ways(variant))

    @cached_property
    def _number(self) -> dict[int, int]:
        return {id(variant): number for number, variant in enumerate(self.splitting.variants)}

    @cached_property
    def _trimmed(self) -> list[Ways]:
        return [self.trimming.ways(variant) for variant in self.splitting.variants]

    @cached_property
    def _ways(self) -> list[Ways]:
        """The ways of each variant, with one variant of each kind below them."""
        if self.min_share == 0.0:
            return self._trimmed
        return [
            {branch: tuple(map(self._with_first, every)) for branch, every in ways.items()} for ways in self._trimmed
        ]

    def _with_first(self, way: Way) -> Way:
        return replace(way, children={index: self._first[child] for index, child in way.children.items()})

    @cached_property
    def _first(self) -> Sequence[int]:
        """The first variant of the kind of each: of the coarsest kinds with equal rules and successors of equal kinds.

        Without trimming, all variants differ.
        """
        variants = self.splitting.variants
        if self.min_share == 0.0:
            return range(len(variants))
        tree = self.splitting.automaton.components.tree
        kinds, size = [0] * len(variants), 0
        while True:
            known: dict[Hashable, int] = {}
            kinds = [
                known.setdefault(
                    (variant.key, self._signature(variant, tree.body(variant.key), ways, kinds)), len(known)
                )
                for variant, ways in zip(variants, self._trimmed, strict=True)
            ]
            if len(known) == size:
                break
            size = len(known)
        first: dict[int, int] = {}
        return [first.setdefault(kind, number) for number, kind in enumerate(kinds)]

    def _signature(self, variant: Variant, body: Body, ways: Ways, kinds: Sequence[int]) -> Hashable:
        """The probabilities of a part of a rule, and the kinds of its successors."""
        if isinstance(body, Alternative):
            weights = np.array([self.weights.way(way) for way in ways.get(body.branch, ())])
            shares = np.round(weights / weights.sum(), DIGITS).tolist() if len(weights) else []
            below = [
                tuple((index, kinds[child]) for index, child in sorted(way.children.items()))
                for way in ways.get(body.branch, ())
            ]
            return tuple(sorted(zip(below, shares, strict=True)))
        inner = [self._signature(variant, branch, ways, kinds) for branch in body.branches]
        if not isinstance(body, Chance) or body.probabilities is None:
            return tuple(inner)
        weights = self._weights_of(variant, body, ways)
        return tuple(np.round(weights / max(weights.sum(), np.finfo(np.float64).tiny), DIGITS).tolist()), tuple(inner)

    def _weights_of(self, variant: Variant, chance: Chance, ways: Ways) -> Floats:
        base_weights = branch_weights(chance, self.splitting.base) or (1.0,) * len(chance.branches)
        return np.array(
            [
                weight * self.weights.body(variant, branch)
                if any(ways.get(alternative.branch) for alternative in leaves(branch))
                else 0.0
                for weight, branch in zip(base_weights, chance.branches, strict=True)
            ]
        )
