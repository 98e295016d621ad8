"""Material of an evaluation: labelled models with true scores, and a simulated person with all other true scores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grammarlab.errors import UsageError
from grammarlab.evaluation.respondents import Respondent
from grammarlab.learning.asking.interview import Person
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.round import Study
from grammarlab.learning.targets.agreement import agreement

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Material:
    """n labelled models with the true scores of K factors, and a person with those of all others."""

    factors: tuple[str, ...]
    """Names of the K factors, K >= 1; the preference is their product."""
    scores: Floats
    """[n, K] true scores of the labelled set, 0 to 100."""
    weights: Floats
    """[n] > 0, importance weight of each labelled model (`agreement`)."""
    study: Study[Any]
    """The pool, with tables whose `Table.others` are the labelled set."""
    person: Person
    """True scores of any models."""
    meant: Callable[[Sequence[Address]], Floats]
    """True scores [k, K] of models by ascending address, 0 to 100."""

    def as_one_factor(self) -> Material:
        """The same models for a person who scores the product of all factors."""
        if len(self.factors) == 1:
            return self
        return replace(
            self,
            factors=(" x ".join(self.factors),),
            scores=_product(self.scores),
            person=lambda addresses, before: _product(self.person(addresses, before)),
            meant=lambda addresses: _product(self.meant(addresses)),
        )

    def answered_by(self, respondent: Respondent, seed: int) -> Material:
        """The same models for a respondent; its exact scores are the target.

        Args:
            respondent: the respondent.
            seed: seed of the person, 0 <= seed < 2**64.

        Raises:
            UsageError: If no model of the labelled set is liked on the person's scale.
        """
        answered = replace(
            self,
            scores=respondent.truth(self.scores),
            person=lambda addresses, before: respondent.answers(self.person(addresses, before), seed, before),
            meant=lambda addresses: respondent.truth(self.meant(addresses)),
        )
        if not (answered.weights * answered.target).any():
            raise UsageError(
                f"person {respondent.name}: none of the {len(self.scores):,} labelled models has a score above 0 on "
                f"the scale of this person, so there is no density to learn. Raise num_models, or give higher scores."
            )
        return answered

    @property
    def target(self) -> Floats:
        """[n] true preference: the product of the factors' scores, each as a share of 100."""
        return np.prod(self.scores / 100.0, axis=1)

    @property
    def js_original(self) -> float:
        """Divergence in nats of the original grammar."""
        return agreement(self.target, np.ones(len(self.weights)), self.weights).js


def _product(scores: Floats) -> Floats:
    """[n, 1] the scores of the product of K factors [n, K], 0 to 100."""
    return 100.0 * np.prod(scores / 100.0, axis=1, keepdims=True)
