"""How good a learned density is, on the labelled set of a scenario."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.density.target import Target
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.evaluation.preparation import Source, labelled_set
from grammarlab.learning.agreement import Agreement
from grammarlab.learning.measure import Measured, measured
from grammarlab.learning.target import Learned

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
    def of(cls, source: Source) -> LabelledSet:
        """Derives the models and scores them.

        Raises:
            UsageError: when none is liked.
        """
        found = source.scenario
        target = Target.of_score(source.grammar, found.score, found.base, source.assets)
        space = source.space
        forests = labelled_set(source, space)
        wanted = np.concatenate(list(_wanted(target, forests)))
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


def _wanted(target: Target, forests: Iterable[Forest]) -> Iterator[Floats]:
    for forest in forests:
        yield target.of_models(forest) * (1.0 if target.even is None else target.even.ratio(forest))


@dataclass(frozen=True, slots=True)
class Truth:
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
    def of(cls, source: Source, learned: Learned[Forest]) -> Truth:
        """Derives the labelled set and compares."""
        return cls(source.scenario.name, LabelledSet.of(source).measure(learned))
