"""Inside weights of variants: the sum over their trees of probability times outside weight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from grammarlab.arrays import MAX_STEPS, ROUNDING, Floats
from grammarlab.density.exact.splitting import PLAIN, Base, Splitting, Variant, Way
from grammarlab.density.grammar_skeleton import Alternative, Body, Chance, leaves
from grammarlab.errors import InexactError
from grammarlab.language.call_order import groups
from grammarlab.language.numbering import SymbolKey


class InsideWeights:
    """The inside weights of all variants of a splitting.

    Raises:
        InexactError: If the weight of a symbol depends on a condition, or is unbounded.
    """

    def __init__(self, splitting: Splitting) -> None:
        self._splitting = splitting
        self._tree = splitting.automaton.components.tree
        self.variant = np.zeros(len(splitting.variants))
        """[V] the weight of each variant."""
        calls = {i: _called(variant) for i, variant in enumerate(splitting.variants)}
        for group in groups(calls):
            if len(group) == 1 and group[0] not in calls[group[0]]:
                self.variant[group[0]] = self._evaluate(group[0])
            else:
                self._solve(group)

    def of(self, variant: int) -> float:
        """Weight of a variant, 1 for `PLAIN`."""
        return 1.0 if variant == PLAIN else float(self.variant[variant])

    def way(self, way: Way) -> float:
        """Weight of one assignment of variants to the successors of an alternative."""
        return float(way.weight * np.prod(self.variant[_factors(way)]))

    def body(self, variant: Variant, body: Body) -> float:
        """Weight of a rule's choices, or of a branch of them, in a variant.

        Raises:
            InexactError: If it depends on a condition.
        """
        if isinstance(body, Alternative):
            return sum(self.way(way) for way in variant.ways.get(body.branch, ()))
        weights = [self.body(variant, branch) for branch in body.branches]
        chances = branch_weights(body, self._splitting.base) if isinstance(body, Chance) else None
        if chances is not None:
            return sum(chance * weight for chance, weight in zip(chances, weights, strict=True))
        reached = [
            weight
            for weight, branch in zip(weights, body.branches, strict=True)
            if self._is_reached(variant.key, branch)
        ]
        if not reached:
            return 0.0  # cases inside one that no model of the sample reached
        if max(reached) - min(reached) > ROUNDING * max(reached):
            raise self._dependent(variant, body)
        return reached[0]

    def _is_reached(self, key: SymbolKey, body: Body) -> bool:
        """Whether a branch is ever taken in the sample."""
        counts = self._tree.sample_counts
        if not any(name == key and count for (name, _), count in counts.items()):
            return True
        return any(counts.get((key, end.branch), 0) for end in leaves(body) if end.branch is not None)

    def _evaluate(self, number: int) -> float:
        variant = self._splitting.variants[number]
        weight = self.body(variant, self._tree.body(variant.key))
        if not np.isfinite(weight):
            raise InexactError(f"{variant.key[0]} has too many different trees for an even base; try the base grammar")
        return weight

    def _solve(self, group: Sequence[int]) -> None:
        """The least solution of the equations of variants that call each other: Newton's method from 0, which climbs.

        Etessami and Yannakakis, Recursive Markov chains, stochastic grammars, and monotone systems of nonlinear
        equations, 2009.
        """
        index_of = {number: i for i, number in enumerate(group)}
        variants = [self._splitting.variants[number] for number in group]
        for _ in range(MAX_STEPS):
            before = self.variant[list(group)]
            values, slopes = np.zeros(len(group)), np.zeros((len(group), len(group)))
            for i, variant in enumerate(variants):
                values[i], slopes[i] = self._linear(variant, self._tree.body(variant.key), index_of)
            step = np.linalg.lstsq(np.eye(len(group)) - slopes, values - before, rcond=None)[0]
            after = before + np.maximum(step, 0.0)
            if not np.isfinite(after).all() or (after > 1e12).any():
                break
            self.variant[list(group)] = after
            if (after - before <= 1e-15 * after).all():
                if (values - before > ROUNDING * values).any():
                    # Newton's method does not converge: there is no solution.
                    break
                for variant in variants:
                    self.body(variant, self._tree.body(variant.key))
                return
        name = variants[0].key[0]
        raise InexactError(
            f"{name} calls itself so often that its weight has no bound: an even base needs a grammar with finitely "
            "many trees, and a preference must not grow faster than the grammar's probabilities fall. Try the base "
            "grammar, or a score with comparisons"
        )

    def _linear(self, variant: Variant, body: Body, index_of: Mapping[int, int]) -> tuple[float, Floats]:
        """Weight of a body, and its derivatives by the weights of the variants in ``index_of``."""
        slopes = np.zeros(len(index_of))
        if isinstance(body, Alternative):
            value = 0.0
            for way in variant.ways.get(body.branch, ()):
                value += self.way(way)
                children = _factors(way)
                for position, child in enumerate(children):
                    if child in index_of:
                        others = children[:position] + children[position + 1 :]
                        slopes[index_of[child]] += way.weight * np.prod(self.variant[others])
            return value, slopes
        parts = [self._linear(variant, branch, index_of) for branch in body.branches]
        chances = branch_weights(body, self._splitting.base) if isinstance(body, Chance) else None
        if chances is None:
            # All branches have equal weight at the solution; so their mean converges to it.
            used = [self._is_reached(variant.key, branch) for branch in body.branches]
            used = used if any(used) else [True] * len(used)
            chances = tuple(float(is_used) / sum(used) for is_used in used)
        for chance, (_, part) in zip(chances, parts, strict=True):
            slopes += chance * part
        return sum(chance * value for chance, (value, _) in zip(chances, parts, strict=True)), slopes

    def _dependent(self, variant: Variant, body: Body) -> InexactError:
        name = variant.key[0]
        what = "percentages that are not constant" if isinstance(body, Chance) else "a condition"
        return InexactError(
            f"{name} chooses by {what}, and the preference does not weigh its branches equally: how likely they are is "
            "not in the text, so no exact grammar can be computed"
        )


def branch_weights(chance: Chance, base: Base) -> tuple[float, ...] | None:
    """Weights of the branches of a choice: their probabilities, or 1 each; None if they are not constant."""
    even = base == "uniform" and chance.probabilities is not None
    return tuple(float(p > 0.0) for p in chance.probabilities or ()) if even else chance.probabilities


def _factors(way: Way) -> list[int]:
    """The variants of all successors, once for each copy."""
    return [variant for index, variant in way.children.items() for _ in range(way.copies.get(index, 1))]


def _called(variant: Variant) -> tuple[int, ...]:
    return tuple({child for ways in variant.ways.values() for way in ways for child in way.children.values()})
