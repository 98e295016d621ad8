"""Evidence of scores that nothing explains: any distribution of scores, learned from the scores themselves.

A set of scores that no column divides has some distribution. A Polya tree (Lavine 1992) is a prior over distributions
whose evidence is a product over the nodes of a tree of halves: at a node with a scores on one side and b on the other

    B(alpha + a, alpha + b) / B(alpha, alpha).

Scores of 0 and of 100 are split off first, since noise is clipped there; below are halves of the points 1 to 99. The
evidence depends on counts only, so it is the same in any order of the scores. Four priors have even odds: alpha is the
same at every depth, for a few repeated scores, or grows with the square of the depth, for smooth distributions; and
halves end at single points or at parts of a few points, in which all are equally likely, for scores that noise spreads.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.special import gammaln

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.person import VALUE_STEP

_ALPHA = 0.5
"""Alpha of a node, and for smooth distributions of the first nodes: Jeffreys' prior."""


class _Part(NamedTuple):
    """A node of the tree of halves: the scores from ``low`` to ``high``."""

    low: int
    high: int
    depth: int
    """Number of nodes above."""
    above: int
    """Number of points of the node above it; 0 if it has none."""


@dataclass(frozen=True, eq=False)
class UnexplainedScores:
    """Evidence of subsets of n scores."""

    members: Floats
    """[n, T] whether each score is in each part of the tree; parts with the same scores are one."""
    tables: Floats
    """[4, T, n + 1] what a part with each number of scores adds to the log-evidence, by each prior."""

    @classmethod
    def of(cls, scores: Floats) -> UnexplainedScores:
        """The evidence of subsets of scores [n], 0-100."""
        points, numbers = np.rint(scores), np.arange(len(scores) + 1)
        low, high, depth, above = (np.array(column) for column in zip(*_parts(), strict=True))
        inside, size = (points[:, None] >= low) & (points[:, None] <= high), high - low + 1
        depths = np.arange(depth.max() + 1)
        split = -_rising(2.0 * _alphas(depths), numbers)[:, depth]
        chosen = _rising(_alphas(depths - 1), numbers)[:, depth]
        even = -numbers * np.log(size)[:, None]
        tables = np.concatenate(
            [
                np.where((size > narrowest)[:, None], split, even * (above > narrowest)[:, None])
                + chosen * (above > narrowest)[:, None]
                for narrowest in (1, int(VALUE_STEP))
            ]
        )
        members, same = np.unique(inside, axis=1, return_inverse=True)
        one_of = (same.reshape(-1) == np.arange(members.shape[1])[:, None]).astype(np.float64)
        return cls(members.astype(np.float64), one_of @ tables)

    def log_evidence(self, counts: Floats | Ints) -> Floats:
        """[k] log-evidence of subsets with so many scores [k, T] in each part: sums of rows of `members`.

        >>> scores = UnexplainedScores.of(np.array([0.0, 0.0, 80.0]))
        >>> float(scores.log_evidence(scores.members[:2].sum(axis=0)[None])[0].round(3))
        -0.981
        """
        num_parts, num_counts = self.tables.shape[1:]
        index = np.rint(counts).astype(np.int64) + np.arange(num_parts) * num_counts
        by_prior = [np.take(table, index).sum(axis=1) for table in self.tables]
        return np.logaddexp.reduce(by_prior) - np.log(len(by_prior))


def log_evidence_of_nothing(scores: Floats, of_values: float) -> float:
    """Log-evidence of scores that nothing explains, in nats.

    With even odds, scores have any distribution, or values have one and the person errs. The first alone would be a
    straw man for scores of which noise makes many 0, and the second for exact ones, of which many are equal.

    Args:
        scores: [n] 0-100.
        of_values: evidence that one distribution of values explains the scores, in nats
            (`grammarlab.preference.unexplained`).
    """
    of_any = UnexplainedScores.of(scores)
    of_scores = float(of_any.log_evidence(of_any.members.sum(axis=0)[None])[0])
    return float(np.logaddexp(of_scores, of_values) - np.log(2.0))


def _alphas(depth: Ints) -> Floats:
    """[2, T] alpha of nodes at a depth, by both priors."""
    return _ALPHA * np.stack([np.ones(len(depth)), np.maximum(depth, 1) ** 2.0])


@cache
def _parts() -> tuple[_Part, ...]:
    """All parts of the tree."""
    last = int(MAX_SCORE)
    return (
        _Part(0, last, 0, 0),
        _Part(0, 0, 1, last + 1),
        _Part(1, last, 1, last + 1),
        _Part(last, last, 2, last),
        *_halves(1, last - 1, 2, last),
    )


def _halves(low: int, high: int, depth: int, above: int) -> Iterator[_Part]:
    """A part and all parts below it."""
    yield _Part(low, high, depth, above)
    if high > low:
        middle, size = (low + high) // 2, high - low + 1
        yield from _halves(low, middle, depth + 1, size)
        yield from _halves(middle + 1, high, depth + 1, size)


def _rising(alphas: Floats, numbers: Ints) -> Floats:
    """[2, T, N] log of Gamma(alpha + number) / Gamma(alpha)."""
    return gammaln(alphas[:, :, None] + numbers) - gammaln(alphas)[:, :, None]
