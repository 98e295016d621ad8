"""Rejection sampling: a grammar's models, thinned until they follow a preference (section 4.6).

There is no new grammar, and rejected models cost time; but the preference may be any function of
a model. A learned grammar can propose the models, so that fewer are rejected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Ints
from grammarlab.density.sampler import AbstractSampler
from grammarlab.density.splits.learned import LearnedGrammar, num_alternatives
from grammarlab.density.splits.splitting import Base
from grammarlab.density.targets.target import Target
from grammarlab.density.targets.thinning import MOST_PROPOSALS, AcceptanceRate, Progress, Thinned, silent, thin
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.selection import join_forests, select_models
from grammarlab.errors import GrammarlabError, UsageError

Floats = NDArray[np.float64]
K = TypeVar("K")

PILOT_MODELS = 2_000
"""Number of accepted models for estimating the mean of the preference, and its bound if unknown."""
PILOT_PROPOSALS = 200_000
"""Largest number of models of a pilot run: 400 accepted ones for a preference that likes one model in 500."""


@dataclass(frozen=True)
class RejectionSampler(AbstractSampler):
    """A target density, sampled by rejection."""

    target: Target
    proposal: LearnedGrammar | None
    """Sampler that proposes models; None for the base of the target."""
    pilot: AcceptanceRate
    """Acceptance of a pilot run. Its mean weight is the estimated divisor of the density."""
    most_proposals: int = MOST_PROPOSALS
    """Largest number of proposed models."""

    def sample(self, num_models: int, seed: int) -> Forest:
        return self.draw(num_models, seed)[0]

    def draw(self, num_models: int, seed: int) -> tuple[Forest, AcceptanceRate]:
        """Models, with the acceptance of the proposals.

        Without a known bound, the largest weight found here or in the pilot run is used: models with a larger
        weight, if any, are too rare in the samples.

        Args:
            num_models: number of models.
            seed: 0 <= seed < 2**64; the same seed gives the same models.

        Raises:
            GrammarlabError: If too few are accepted.
        """
        least, most = self.pilot.bound, self.most_proposals
        found = _thinned(self.target, self.proposal, select_models, num_models, seed, least=least, most_proposals=most)
        forest = join_forests([select_models(models, rows) for models, rows in found.chunks])
        if forest.num_models < num_models:
            raise GrammarlabError(
                f"only {forest.num_models:,} models after {found.acceptance.proposals:,} proposals, {num_models:,} "
                "were requested: liked models are too rare for rejection. Try the method compile: it needs no samples"
            )
        return forest, found.acceptance

    @property
    def text(self) -> str:
        """Empty, since no file samples by rejection."""
        return ""

    @property
    def method(self) -> str:
        """The name of the method."""
        return "rejection"

    @property
    def accept_rate(self) -> float:
        """Share of proposed models that are kept, in the pilot run."""
        return self.pilot.rate

    @property
    def base(self) -> Base:
        """The density that the preference multiplies."""
        return self.target.base

    @property
    def rules_before(self) -> int:
        """Branches of the rules of the grammar."""
        return num_alternatives(self.target.grammar)

    @property
    def rules_after(self) -> int:
        """The same, since there is no new grammar."""
        return self.rules_before

    @property
    def findings(self) -> tuple[str, ...]:
        """Remarks for the user about how models are made."""
        return (str(self.pilot),)

    def log_density(self, forest: Forest) -> Floats:
        even = self.target.even
        own = forest.log_probability() if even is None else even.log_density(forest)
        with np.errstate(divide="ignore"):
            return own + np.log(self._by_base(forest))

    def ratio(self, forest: Forest) -> Floats:
        """Density [models] of models of the grammar, divided by their density under the grammar."""
        even = self.target.even
        return self._by_base(forest) * (1.0 if even is None else even.ratio(forest))

    def _by_base(self, forest: Forest) -> Floats:
        """The density divided by that of the base."""
        return self.target.of_models(forest) / self.pilot.mean_weight


def reject(
    target: Target,
    *,
    num_pilot: int = PILOT_MODELS,
    proposal: LearnedGrammar | None = None,
    seed: int = 0,
    most_proposals: int = MOST_PROPOSALS,
    on_progress: Progress = silent,
) -> RejectionSampler:
    """A sampler of a target density by rejection.

    Args:
        target: the density.
        num_pilot: number of accepted models of the pilot run.
        proposal: a learned grammar that proposes models; must make all models that the target makes.
        seed: seed of the pilot run.
        most_proposals: largest number of proposed models.
        on_progress: called with the number of accepted models of the pilot run.

    Raises:
        GrammarlabError: If no model is accepted.
    """
    most = min(most_proposals, PILOT_PROPOSALS)
    found = _thinned(
        target, proposal, lambda forest, rows: None, num_pilot, seed, most_proposals=most, on_progress=on_progress
    )
    return RejectionSampler(target, proposal, found.acceptance, most_proposals)


def _thinned(
    target: Target,
    proposal: LearnedGrammar | None,
    keep: Callable[[Forest, Ints], K],
    num_models: int,
    seed: int,
    *,
    most_proposals: int,
    least: float = 0.0,
    on_progress: Progress = silent,
) -> Thinned[K]:
    if num_models < 1:
        raise UsageError(f"expected at least one model, found {num_models}")
    made_by = proposal or target.even
    program = compile_grammar(target.grammar if made_by is None else made_by.grammar)

    def propose(first: int, number: int) -> Forest:
        forest = derive(program, number, seed, first_model=first, assets=target.folder)
        return forest if made_by is None else made_by.as_original(forest)

    def weigh(forest: Forest) -> Floats:
        scores = target.of_models(forest)
        if proposal is None:
            return scores
        base = 1.0 if target.even is None else target.even.ratio(forest)
        return scores * base / proposal.ratio(forest)

    return thin(
        propose,
        weigh,
        keep,
        num_models,
        seed,
        bound=target.bound if proposal is None else None,
        least=least,
        most_proposals=most_proposals,
        chunk=target.chunk,
        on_progress=on_progress,
    )
