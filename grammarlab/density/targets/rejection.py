"""Rejection sampling: a grammar's models, thinned until they follow a preference (section 4.6).

No new grammar comes out, and time is spent on models that nobody sees; in return the preference may be any function of
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
"""Models that are accepted to estimate the mean of the preference, and a bound where none is known."""
PILOT_PROPOSALS = 200_000
"""A pilot run looks at no more: of a preference for one model in 500, it has met 400 then."""


@dataclass(frozen=True)
class RejectionSampler(AbstractSampler):
    """A wanted density, sampled by rejection."""

    target: Target
    proposal: LearnedGrammar | None
    """What proposes models; None for the base of the target."""
    pilot: AcceptanceRate
    """What became of the models of a pilot run. Its mean weight divides the density, and so is an estimate there."""
    most_proposals: int = MOST_PROPOSALS
    """Models that are looked at before it gives up."""

    def sample(self, num_models: int, seed: int) -> Forest:
        return self.draw(num_models, seed)[0]

    def draw(self, num_models: int, seed: int) -> tuple[Forest, AcceptanceRate]:
        """Models, and what became of those that were proposed.

        Where no bound is known, the largest weight met here or in the pilot run takes its place: models with a larger
        one, should there be any, come too seldom.

        Args:
            num_models: how many.
            seed: 0 <= seed < 2**64; the same seed gives the same models.

        Raises:
            GrammarlabError: when too few are accepted.
        """
        least, most = self.pilot.bound, self.most_proposals
        found = _thinned(self.target, self.proposal, select_models, num_models, seed, least=least, most_proposals=most)
        forest = join_forests([select_models(models, rows) for models, rows in found.chunks])
        if forest.num_models < num_models:
            raise GrammarlabError(
                f"only {forest.num_models:,} models after {found.acceptance.proposals:,} proposals, {num_models:,} "
                "were wanted: what is liked is too rare for rejection. Try the method compile, which needs no samples"
            )
        return forest, found.acceptance

    @property
    def text(self) -> str:
        """Empty: no file samples like this."""
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
        """What the preference multiplies."""
        return self.target.base

    @property
    def rules_before(self) -> int:
        """Alternatives of the rules of the grammar."""
        return num_alternatives(self.target.grammar)

    @property
    def rules_after(self) -> int:
        """The same: no new grammar comes out."""
        return self.rules_before

    @property
    def findings(self) -> tuple[str, ...]:
        """What a person should know about how models are made."""
        return (str(self.pilot),)

    def log_density(self, forest: Forest) -> Floats:
        even = self.target.even
        own = forest.log_probability() if even is None else even.log_density(forest)
        with np.errstate(divide="ignore"):
            return own + np.log(self._by_base(forest))

    def ratio(self, forest: Forest) -> Floats:
        """Density [models] of models of the grammar by that under the grammar."""
        even = self.target.even
        return self._by_base(forest) * (1.0 if even is None else even.ratio(forest))

    def _by_base(self, forest: Forest) -> Floats:
        """The density by that of the base."""
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
    """A sampler of a wanted density by rejection.

    Args:
        target: the density.
        num_pilot: models to accept in the pilot run.
        proposal: a learned grammar that proposes models; must make all models that the target makes.
        seed: of the pilot run.
        most_proposals: models that are looked at before it gives up.
        on_progress: told about models that the pilot run accepts.

    Raises:
        GrammarlabError: when no model is accepted.
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
