"""Evidence of the scores of a leaf: they have one value, or nothing explains them.

With even odds, all designs of a leaf have one value v, unknown but for a prior, so that scores differ by the errors of
the person only,

    log sum_v p(v) prod_i p(y_i | v),

or they have any distribution of values (`grammarlab.preference.judge.unexplained_scores`). Without the second case
every division looks proven that separates a few scores: one value contradicts all others.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.judge.unexplained_scores import UnexplainedScores
from grammarlab.preference.person import DISLIKED, log_likelihood, possible_values


@dataclass(frozen=True, eq=False)
class LeafEvidence:
    """Evidence of subsets of n scores for a person with known errors."""

    unexplained: UnexplainedScores
    log_likelihood: Floats
    """[n, G] log-likelihood of each score for each value."""

    @classmethod
    def of(cls, scores: Floats, unexplained: UnexplainedScores, noise: float, blunders: float) -> LeafEvidence:
        """Evidence for a person.

        Args:
            scores: [n] 0-100.
            unexplained: the evidence of the same scores without values.
            noise: standard deviation of the errors, in points.
            blunders: probability of a random score.
        """
        return cls(unexplained, log_likelihood(scores, possible_values(), noise, blunders).astype(np.float64))

    @cached_property
    def terms(self) -> Floats:
        """[n, G + T] columns whose sums over a subset give its evidence."""
        return np.concatenate([self.log_likelihood, self.unexplained.members], axis=1)

    def __call__(self, sums: Floats) -> Floats:
        """[...] log-evidence of subsets from the sums [..., G + T] of their terms; an empty one has 0."""
        flat = sums.reshape(-1, sums.shape[-1])
        size = self.log_likelihood.shape[1]
        of_values = flat[:, :size] + _log_prior()
        highest = of_values.max(axis=1)
        one_value = np.log(np.exp(of_values - highest[:, None]).sum(axis=1)) + highest
        any_value = self.unexplained.log_evidence(flat[:, size:])
        return (np.logaddexp(one_value, any_value) - np.log(2.0)).reshape(sums.shape[:-1])

    def of_labels(self, labels: Ints) -> float:
        """Log-evidence of the scores of some labels."""
        return float(self(self.terms[labels].sum(axis=0)))


def _log_prior() -> Floats:
    """[G] log of the prior of the values."""
    num = len(possible_values())
    prior = np.full(num, (1.0 - DISLIKED) / (num - 1))
    prior[0] = DISLIKED
    return np.log(prior)
