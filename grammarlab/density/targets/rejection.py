"""Rejection sampling: a grammar's models, thinned until they follow a preference (section 4.6).

There is no new grammar, and rejected models cost time; but the preference may be any function of
a model. A learned grammar can propose the models, so that fewer are rejected.

A model is accepted with the probability weight / bound, where its weight is the target density divided by the proposal
density, up to a constant. The bound must be above all weights. If it is unknown, it is the largest weight found so far;
when a larger one is found, the accepted models are thinned by the quotient.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from grammarlab.arrays import ROUNDING, Floats, Ints
from grammarlab.density.exact.learned import LearnedGrammar, num_alternatives
from grammarlab.density.exact.splitting import Base
from grammarlab.density.sampler import AbstractSampler
from grammarlab.density.targets.target import Target
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.selection import join_forests, select_models
from grammarlab.errors import GrammarlabError, UsageError
from grammarlab.randomness import fold, root_keys, uniforms

T = TypeVar("T")
K = TypeVar("K")
Progress: TypeAlias = Callable[[str, int, int], None]
"""Function called with the name of a task, the number of finished parts, and the number of all parts."""
MAX_PROPOSALS = 1_000_000
"""Largest number of proposed models."""
PILOT_MODELS = 2_000
"""Number of models for estimating the mean of a preference, its bound if unknown, or an acceptance rate."""
_PILOT_PROPOSALS = 200_000
"""Largest number of models of a pilot run: 400 accepted ones for a preference that likes one model in 500."""
_LANE = int.from_bytes(b"REJECT")
"""Separates the draws that accept models from those that made them."""
_FIRST_CHUNK = 256
"""Number of models proposed at first, which shows how many are accepted."""


@dataclass(frozen=True, slots=True)
class AcceptanceRate:
    """Statistics of the proposed models."""

    proposals: int
    accepted: int
    """Models that were accepted, of all proposed ones."""
    bound: float
    """Weight from which models are always accepted."""
    has_bound: bool
    """Whether the bound was given; otherwise it is the largest weight found, and the probability of a larger one is
    less than about 3 / proposals (at 95 %)."""
    mean_weight: float
    """Mean over all proposals."""
    truncated: float
    """Share of the target density above a given bound, among the proposals; this share is lost."""

    @property
    def rate(self) -> float:
        """Share of proposals that were accepted."""
        return self.accepted / max(1, self.proposals)

    def __str__(self) -> str:
        bound = "known" if self.has_bound else "the largest one met"
        lost = f", {self.truncated:.2%} of the density cut off" if self.truncated else ""
        return (
            f"accepted {self.accepted:,} of {self.proposals:,} models ({self.rate:.3%}); "
            f"bound {self.bound:.6g}, {bound}{lost}"
        )


@dataclass(frozen=True, slots=True)
class Thinned(Generic[K]):
    """Accepted models."""

    chunks: tuple[tuple[K, Ints], ...]
    """Kept data of proposed models, and the accepted ones of each chunk [k], ascending."""
    acceptance: AcceptanceRate


@dataclass(frozen=True)
class RejectionSampler(AbstractSampler):
    """A target density, sampled by rejection."""

    target: Target
    proposal: LearnedGrammar | None
    """Sampler that proposes models; None for the base of the target."""
    pilot: AcceptanceRate
    """Acceptance of a pilot run. Its mean weight is the estimated divisor of the density."""
    most_proposals: int = MAX_PROPOSALS
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
        thinned = _thinned(
            self.target, self.proposal, select_models, num_models, seed, least=least, most_proposals=most
        )
        forest = join_forests([select_models(models, rows) for models, rows in thinned.chunks])
        if forest.num_models < num_models:
            raise GrammarlabError(
                f"only {forest.num_models:,} models after {thinned.acceptance.proposals:,} proposals, {num_models:,} "
                "were requested: liked models are too rare for rejection. Try the method compile: it needs no samples"
            )
        return forest, thinned.acceptance

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
    def units(self) -> tuple[str, str]:
        """What its size counts: one, and several."""
        return "branch of rules", "branches of rules"

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
        log_base = forest.log_probability() if even is None else even.log_density(forest)
        with np.errstate(divide="ignore"):
            return log_base + np.log(self._by_base(forest))

    def ratio(self, forest: Forest) -> Floats:
        """Density [models] of models of the grammar, divided by their density under the grammar."""
        even = self.target.even
        return self._by_base(forest) * (1.0 if even is None else even.ratio(forest))

    def _by_base(self, forest: Forest) -> Floats:
        """The density divided by that of the base."""
        return self.target.of_models(forest) / self.pilot.mean_weight


def silent(what: str, done: int, total: int) -> None:
    """Ignore progress."""


def reject(
    target: Target,
    *,
    num_pilot: int = PILOT_MODELS,
    proposal: LearnedGrammar | None = None,
    seed: int = 0,
    most_proposals: int = MAX_PROPOSALS,
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
    most = min(most_proposals, _PILOT_PROPOSALS)
    pilot = _thinned(
        target, proposal, lambda forest, rows: None, num_pilot, seed, most_proposals=most, on_progress=on_progress
    )
    return RejectionSampler(target, proposal, pilot.acceptance, most_proposals)


def thin(
    propose: Callable[[int, int], T],
    weigh: Callable[[T], Floats],
    keep: Callable[[T, Ints], K],
    num_models: int,
    seed: int,
    *,
    bound: float | None = None,
    least: float = 0.0,
    most_proposals: int = MAX_PROPOSALS,
    chunk: int = 4_096,
    on_progress: Progress = silent,
) -> Thinned[K]:
    """Accept models until there are enough.

    Args:
        propose: from the index of the first model and a number to a chunk of models; each model depends on its index
            only.
        weigh: the weight [models] of each model of a chunk, finite and >= 0.
        keep: function that selects the data to keep of models [k] of a chunk.
        num_models: number of models to accept.
        seed: 0 <= seed < 2**64; with its index it decides on each model.
        bound: upper bound of all weights; None if unknown.
        least: without a bound, a lower bound of the largest weight.
        most_proposals: largest number of proposals; then it ends with fewer models.
        chunk: largest number of models proposed at once.
        on_progress: called with the number of accepted models.

    Raises:
        GrammarlabError: If none is accepted.
    """
    chunks: list[tuple[K, Floats]] = []
    """Chunks of candidates, and the largest bound under which each is accepted."""
    most = least if bound is None else bound
    proposals = accepted = 0
    total = cut = 0.0
    size = min(_FIRST_CHUNK, chunk)
    while accepted < num_models and proposals < most_proposals:
        size = min(size, most_proposals - proposals)
        models = propose(proposals, size)
        weights = _checked(weigh(models), size)
        if bound is None:
            most = max(most, float(weights.max(initial=0.0)))
        draws = uniforms(fold(root_keys(seed, np.arange(proposals, proposals + size, dtype=np.uint64)), _LANE), 0)
        # Accepted for all bounds up to this one.
        limit = np.divide(weights, draws, out=np.full(size, np.inf), where=draws > 0.0) * (weights > 0.0)
        rows = np.flatnonzero((limit >= most) & (weights > 0.0))
        if len(rows):
            chunks.append((keep(models, rows), limit[rows]))
        accepted = sum(int((limits >= most).sum()) for _, limits in chunks)
        proposals += size
        total += float(weights.sum())
        cut += float(np.maximum(weights - most, 0.0).sum())
        on_progress("models drawn", min(accepted, num_models), num_models)
        num_proposals = (num_models - accepted) * 1.1 / max(accepted / proposals, ROUNDING)
        size = int(min(chunk, max(_FIRST_CHUNK, num_proposals)))
    if not accepted:
        raise GrammarlabError(
            f"none of {proposals:,} models was accepted: liked models are too rare for rejection. "
            "Try the method compile, which needs no samples"
        )
    truncated = cut / total if total else 0.0
    acceptance = AcceptanceRate(proposals, accepted, most, bound is not None, total / proposals, truncated)
    return Thinned(tuple(_accepted(chunks, most, num_models)), acceptance)


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
    proposer = proposal or target.even
    program = compile_grammar(target.grammar if proposer is None else proposer.grammar)

    def propose(first: int, number: int) -> Forest:
        forest = derive(program, number, seed, first_model=first, assets=target.folder)
        return forest if proposer is None else proposer.as_original(forest)

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


def _checked(weights: Floats, size: int) -> Floats:
    if weights.shape != (size,) or not np.isfinite(weights).all() or (weights < 0.0).any():
        raise GrammarlabError(
            f"expected a weight for each of {size} models, finite and at least 0; found shape {weights.shape}"
            + (f" with {weights.min()} to {weights.max()}" if weights.size else "")
        )
    return weights


def _accepted(chunks: Sequence[tuple[K, Floats]], bound: float, num_models: int) -> Iterator[tuple[K, Ints]]:
    """The first models accepted under a bound, by chunk."""
    for models, limits in chunks:
        rows = np.flatnonzero(limits >= bound)[:num_models]
        num_models -= len(rows)
        if len(rows):
            yield models, rows
