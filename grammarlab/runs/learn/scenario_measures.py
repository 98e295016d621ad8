"""Comparison of a learned density with a scenario, on its labelled set."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.density.targets.target import Target
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.evaluation.preparation import Source, labelled_set, true_scores
from grammarlab.evaluation.respondents import EXACT, Respondent
from grammarlab.learning.targets.divergence import Agreement, Measured, measured
from grammarlab.learning.targets.writers import Learned
from grammarlab.preference.base import MAX_SCORE


@dataclass(frozen=True, slots=True)
class LabelledSet:
    """The labelled set of a scenario, with the target density."""

    source: Source
    target: Floats
    """[n] target density divided by that of the original grammar, up to a factor."""
    weights: Floats
    """[n] importance weight of each model under the original grammar."""
    forests: tuple[Forest, ...]

    @classmethod
    def of(cls, source: Source, respondent: Respondent = EXACT) -> LabelledSet:
        """Derive the models and score them.

        Args:
            source: the scenario and its grammar.
            respondent: the respondent whose exact scores are the target.

        Raises:
            UsageError: If no model is liked.
        """
        scenario = source.scenario
        even, space = Target.of_score(source.grammar, scenario.score, scenario.base, source.assets).even, source.space
        forests = labelled_set(source, space)
        scores = [respondent.truth(true_scores(scenario, forest)) for forest in forests]
        target = np.prod(np.concatenate(scores) / MAX_SCORE, axis=1)
        if even is not None:
            target *= np.concatenate([even.ratio(forest) for forest in forests])
        flat = scenario.draws == "flattened"
        log_weights = [space.log_ratio(forest) if flat else np.zeros(forest.num_models) for forest in forests]
        if not target.any():
            raise UsageError(
                f"scenario {scenario.name}: none of its {len(target):,} labelled models has a score above 0, so there "
                'is no density to compare with. Raise num_models, or set draws = "flattened".'
            )
        logs = np.concatenate(log_weights)
        return cls(source, target, np.exp(logs - logs.max()), forests)

    def measure(self, learned: Learned[Forest]) -> Measured:
        """Comparison of a learned density with the target density."""
        return measured(self.target, np.concatenate([learned.ratio(forest) for forest in self.forests]), self.weights)


@dataclass(frozen=True, slots=True)
class TrueDensity:
    """A learned density compared with a scenario, on its labelled set."""

    scenario: str
    measured: Measured

    @property
    def after(self) -> Agreement:
        """Agreement of the learned density with the target density."""
        return self.measured.after

    @property
    def before(self) -> Agreement:
        """Agreement of the original grammar with the target density."""
        return self.measured.before

    @classmethod
    def of(cls, source: Source, learned: Learned[Forest], respondent: Respondent = EXACT) -> TrueDensity:
        """Derive the labelled set and compare."""
        return cls(source.scenario.name, LabelledSet.of(source, respondent).measure(learned))
