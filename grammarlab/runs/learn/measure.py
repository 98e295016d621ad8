"""How good a learned density is, on the labelled set of a scenario."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.density.targets.target import Target
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.evaluation.preparation import Source, labelled_set, true_scores
from grammarlab.evaluation.respondents import EXACT, Respondent
from grammarlab.learning.targets.agreement import Agreement
from grammarlab.learning.targets.measure import Measured, measured
from grammarlab.learning.targets.target import Learned
from grammarlab.preference.base import MAX_SCORE

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LabelledSet:
    """The labelled set of a scenario, with the density that is wanted."""

    source: Source
    wanted: Floats
    """[n] density by that of the original grammar, up to a factor."""
    weights: Floats
    """[n] what each model stands for under the original grammar."""
    forests: tuple[Forest, ...]

    @classmethod
    def of(cls, source: Source, respondent: Respondent = EXACT) -> LabelledSet:
        """Derives the models and scores them.

        Args:
            source: the scenario and its grammar.
            respondent: on whose scale; what such a person means is wanted.

        Raises:
            UsageError: when none is liked.
        """
        found = source.scenario
        even, space = Target.of_score(source.grammar, found.score, found.base, source.assets).even, source.space
        forests = labelled_set(source, space)
        scores = [respondent.truth(true_scores(found, forest)) for forest in forests]
        wanted = np.prod(np.concatenate(scores) / MAX_SCORE, axis=1)
        if even is not None:
            wanted *= np.concatenate([even.ratio(forest) for forest in forests])
        flat = found.draws == "flattened"
        log_weights = [space.log_ratio(forest) if flat else np.zeros(forest.num_models) for forest in forests]
        if not wanted.any():
            raise UsageError(
                f"scenario {found.name}: none of its {len(wanted):,} labelled models has a score above 0, so there is "
                'no density to compare with. Raise num_models, or set draws = "flattened".'
            )
        logs = np.concatenate(log_weights)
        return cls(source, wanted, np.exp(logs - logs.max()), forests)

    def measure(self, learned: Learned[Forest]) -> Measured:
        """How near a learned density comes to the wanted one."""
        return measured(self.wanted, np.concatenate([learned.ratio(forest) for forest in self.forests]), self.weights)


@dataclass(frozen=True, slots=True)
class TrueDensity:
    """A learned density compared with what a scenario likes, on its labelled set."""

    scenario: str
    measured: Measured

    @property
    def after(self) -> Agreement:
        """Of the learned density with the wanted one."""
        return self.measured.after

    @property
    def before(self) -> Agreement:
        """Of the original grammar with the wanted density."""
        return self.measured.before

    @classmethod
    def of(cls, source: Source, learned: Learned[Forest], respondent: Respondent = EXACT) -> TrueDensity:
        """Derives the labelled set and compares."""
        return cls(source.scenario.name, LabelledSet.of(source, respondent).measure(learned))
