"""Evidence of the scores of a leaf: they have one value, or nothing explains them.

With even odds, all designs of a leaf have one value v, unknown but for a prior, so that scores differ by the errors of
the person only,

    log sum_v p(v) prod_i p(y_i | v),

or they have any distribution of values (`grammarlab.preference.judge.unexplained_scores`). Without the second case
every division looks proven that separates a few scores: one value contradicts all others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.preference.judge.unexplained_scores import UnexplainedScores
from grammarlab.preference.person import Person, log_likelihood, possible_values, prior_of_values


@dataclass(frozen=True, eq=False)
class LeafEvidence:
    """Evidence of parts of n scores for a person with known errors."""

    scores: Floats
    """[n] 0-100."""
    unexplained: UnexplainedScores
    """The evidence of the same scores without values."""
    person: Person

    @classmethod
    def of(cls, scores: Floats, person: Person) -> LeafEvidence:
        """Evidence of scores [n], 0-100."""
        return cls(scores, UnexplainedScores.of(scores), person)

    def for_person(self, person: Person) -> LeafEvidence:
        """Evidence of the same scores for another person."""
        return replace(self, person=person)

    @cached_property
    def log_likelihood(self) -> Floats:
        """[n, G] log-likelihood of each score for each value."""
        return log_likelihood(self.scores, possible_values(), *self.person).astype(np.float64)

    @property
    def terms(self) -> Floats:
        """[n, G + T] columns whose sums over a part give its evidence."""
        return self._terms

    @cached_property
    def _terms(self) -> Floats:
        return np.concatenate([self.log_likelihood, self.unexplained.members], axis=1)

    def of_sums(self, sums: Floats) -> Floats:
        """[...] log-evidence of parts from the sums [..., G + T] of their terms; an empty one has 0."""
        flat = sums.reshape(-1, sums.shape[-1])
        size = self.log_likelihood.shape[1]
        of_values = flat[:, :size] + np.log(prior_of_values())
        highest = of_values.max(axis=1)
        one_value = np.log(np.exp(of_values - highest[:, None]).sum(axis=1)) + highest
        any_value = self.unexplained.log_evidence(flat[:, size:])
        return (np.logaddexp(one_value, any_value) - np.log(2.0)).reshape(sums.shape[:-1])

    def of_labels(self, labels: Ints) -> float:
        """Log-evidence of the scores of some labels."""
        return float(self.of_sums(self.terms[labels].sum(axis=0)))

    def best_possible(self, labels: Ints) -> float:
        """Upper bound on the evidence of divisions of some labels: probabilities are at most 1."""
        return 0.0
