"""How good a learned density is, on a set of models."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grammarlab.density.learned import LearnedGrammar
from grammarlab.density.rejection import RejectionSampler
from grammarlab.density.target import Target
from grammarlab.derivation.derive import derive_chunks
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.evaluation.agreement import Agreement, agreement
from grammarlab.evaluation.flattening import flattened
from grammarlab.evaluation.preparation import Source, labelled_program
from grammarlab.features.stripping import without_geometry

Floats = NDArray[np.float64]
Learned = LearnedGrammar | RejectionSampler


@dataclass(frozen=True, slots=True)
class Measured:
    """A learned density beside the wanted one."""

    after: Agreement
    before: Agreement
    """The same of the original grammar."""
    num_models: int
    """How many models they were compared on."""
    effective_models: float
    """Of how many of these the wanted density is made: (sum w)^2 / sum w^2."""
    acceptance: float
    """Share of the original grammar's models that rejection would accept, with the largest weight met as the bound."""


def measured(wanted: Floats, learned: Floats, weights: Floats) -> Measured:
    """Compares densities on a set of models.

    Args:
        wanted: [n] density by that of the original grammar, up to a factor, >= 0, one at least above 0.
        learned: [n] likewise.
        weights: [n] what each model stands for under the original grammar, >= 0.
    """
    liked = weights * wanted
    return Measured(
        agreement(wanted, learned, weights),
        agreement(wanted, np.ones(len(wanted)), weights),
        len(wanted),
        float(liked.sum() ** 2 / (liked**2).sum()),
        float(liked.sum() / weights.sum() / wanted[weights > 0.0].max()),
    )


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
        forests = tuple(without_geometry(forest) for forest in _derived(source))
        wanted = np.concatenate(list(_wanted(target, forests)))
        flat = found.draws == "flattened"
        log_weights = [flattened(source.grammar).log_ratio(f) if flat else np.zeros(f.num_models) for f in forests]
        if not wanted.any():
            raise UsageError(
                f"scenario {found.name}: none of its {len(wanted):,} labelled models has a score above 0, so there is "
                'no density to compare with. Raise num_models, or set draws = "flattened".'
            )
        logs = np.concatenate(log_weights)
        return cls(source, wanted, np.exp(logs - logs.max()), forests)

    def measure(self, learned: Learned) -> Measured:
        """How near a learned density comes to the wanted one."""
        return measured(self.wanted, np.concatenate([learned.ratio(forest) for forest in self.forests]), self.weights)


def _derived(source: Source) -> Iterator[Forest]:
    found = source.scenario
    yield from derive_chunks(labelled_program(source), found.num_models, found.seed, assets=source.assets)


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
    def of(cls, source: Source, learned: Learned) -> Truth:
        """Derives the labelled set and compares."""
        return cls(source.scenario.name, LabelledSet.of(source).measure(learned))
