"""Rare branches of split symbols that a written grammar leaves out.

A branch of a learned rule is left out if it is rare there, and either all its trees are worth little in their place,
since its largest outside weight is a small share of the largest one of the symbol, or it is much rarer than in the
original rule. So a rare branch that an author wrote stays, unless it is disliked. The other branches of the rule share
the probability.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.density.exact.inside import InsideWeights, branch_weights
from grammarlab.density.exact.splitting import Splitting, Variant, Way
from grammarlab.density.grammar_skeleton import Alternative, Body, Chance
from grammarlab.language.numbering import Branch
from grammarlab.preference.base import LIKED_SHARE

_TINY = np.finfo(np.float64).tiny

Ways = Mapping[Branch | None, tuple[Way, ...]]


@dataclass(frozen=True, slots=True)
class Trimming:
    """Selects what a written grammar has of a splitting."""

    splitting: Splitting
    weights: InsideWeights
    min_share: float = 0.0
    """Smallest probability of a branch that may be left out, 0 to 1; 0 keeps all branches."""

    def ways(self, variant: Variant) -> Ways:
        """The assignments of each alternative that the rule of a variant has."""
        possible = {
            branch: tuple(way for way in ways if self.weights.way(way) > 0.0) for branch, ways in variant.ways.items()
        }
        if self.min_share == 0.0:
            return possible
        most = max((way.weight for ways in possible.values() for way in ways), default=0.0)
        body = self.splitting.automaton.components.tree.body(variant.key)
        rest = dict(self._rest(variant, body, possible, _Shares(LIKED_SHARE * most)))
        # A variant may be worth little everywhere, as a part of something rare.
        return rest if any(rest.values()) else possible

    def parts(self, probabilities: Floats, weights: Floats) -> Floats:
        """Probabilities [parts] of an attribute without its rare parts; the sum is 1.

        Args:
            probabilities: [parts] new probabilities, summing to 1.
            weights: [parts] outside weights; the largest is 1.
        """
        is_rare = (probabilities < self.min_share) & (weights < LIKED_SHARE * weights.max())
        kept = np.where(is_rare, 0.0, probabilities)
        return kept / kept.sum() if kept.any() else probabilities

    def _rest(
        self, variant: Variant, body: Body, possible: Ways, shares: _Shares
    ) -> Iterator[tuple[Branch | None, tuple[Way, ...]]]:
        """The alternatives of a part of the rule of a variant, with their remaining ways."""
        if isinstance(body, Alternative):
            ways = possible.get(body.branch, ())
            each = shares.new / max(sum(map(self.weights.way, ways)), _TINY)
            is_rarer = shares.new < LIKED_SHARE * shares.original
            yield (
                body.branch,
                tuple(
                    way
                    for way in ways
                    if each * self.weights.way(way) >= self.min_share or (way.weight >= shares.liked and not is_rarer)
                ),
            )
            return
        chances = branch_weights(body, self.splitting.base) if isinstance(body, Chance) else None
        old = np.ones(len(body.branches)) if chances is None else np.array(chances)
        new = old if chances is None else old * [self.weights.body(variant, branch) for branch in body.branches]
        total_old, total_new = (1.0, 1.0) if chances is None else (max(old.sum(), _TINY), max(new.sum(), _TINY))
        inner = [
            shares.of_branch(before / total_old, after / total_new)
            for before, after in zip(old.tolist(), new.tolist(), strict=True)
        ]
        parts = [
            dict(self._rest(variant, branch, possible, of_branch))
            for branch, of_branch in zip(body.branches, inner, strict=True)
        ]
        # A condition chooses among its branches, so each needs something, unless all are left out together.
        is_needed = chances is None and any(any(part.values()) for part in parts)
        for part in parts:
            is_kept = any(part.values()) or not is_needed
            yield from part.items() if is_kept else ((branch, possible[branch]) for branch in part)


class _Shares(NamedTuple):
    """Probabilities of a part of a rule."""

    liked: float
    """Weight from which ways are liked."""
    original: float = 1.0
    """Probability in the original rule."""
    new: float = 1.0
    """Probability in the rule of the variant."""

    def of_branch(self, original: float, new: float) -> _Shares:
        """Those of a branch with these probabilities in the part."""
        return self._replace(original=self.original * original, new=self.new * new)
