"""Comparison of a learned density with a scenario, on its labelled set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.density.targets.target import Target
from grammarlab.errors import UsageError
from grammarlab.evaluation.preparation import Source, labelled_set, true_scores
from grammarlab.evaluation.respondents import EXACT, Respondent
from grammarlab.learning.designs.grammar_space import GrammarSpace
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
    batches: tuple[Any, ...]
    """The designs."""

    @classmethod
    def of(cls, source: Source, respondent: Respondent = EXACT) -> LabelledSet:
        """Derive the models and score them.

        Args:
            source: the scenario and its design space.
            respondent: the respondent whose exact scores are the target.

        Raises:
            UsageError: If no model is liked.
        """
        scenario, space = source.scenario, source.space
        batches = labelled_set(source)
        scores = [respondent.truth(respondent.taste(true_scores(source, designs))) for designs in batches]
        target = np.prod(np.concatenate(scores) / MAX_SCORE, axis=1)
        if scenario.base == "uniform":
            target *= _even_ratio(source, batches)
        flat = scenario.draws == "flattened"
        log_ratios = [space.log_ratio(designs) for designs in batches]
        log_weights = [ratio if flat else np.zeros_like(ratio) for ratio in log_ratios]
        if not target.any():
            raise UsageError(
                f"scenario {scenario.name}: none of its {len(target):,} labelled models has a score above 0, so there "
                'is nothing to compare with. Raise num_models, or set draws = "flattened".'
            )
        logs = np.concatenate(log_weights)
        return cls(source, target, np.exp(logs - logs.max()), batches)

    def measure(self, learned: Learned[Any]) -> Measured:
        """Comparison of a learned density with the target density."""
        return measured(self.target, np.concatenate([learned.ratio(designs) for designs in self.batches]), self.weights)


def _even_ratio(source: Source, batches: Sequence[Any]) -> Floats:
    """[n] even density of designs divided by that of the space, up to a factor."""
    if not isinstance(source.space, GrammarSpace):
        logs = -np.concatenate([source.space.log_density(designs) for designs in batches])
        return np.exp(logs - logs.max())
    scenario, space = source.scenario, source.grammar_space
    even = Target.of_score(space.grammar, scenario.score, scenario.base, space.assets).even
    return np.concatenate([np.ones(0) if even is None else even.ratio(forest) for forest in batches])


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
    def of(cls, source: Source, learned: Learned[Any], respondent: Respondent = EXACT) -> TrueDensity:
        """Derive the labelled set and compare."""
        return cls(source.scenario.name, LabelledSet.of(source, respondent).measure(learned))
