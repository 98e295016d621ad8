"""Rejection: models of one density, thinned until they follow another (section 4.6).

A model is accepted with the probability weight / bound, where its weight is the wanted density by the one it comes
from, up to a constant. The bound must be above all weights. Where it is not known it is the largest weight met so far;
whenever a larger one turns up, what was accepted before is thinned by the quotient.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Ints
from grammarlab.errors import GrammarlabError
from grammarlab.randomness import fold, root_keys, uniforms

Floats = NDArray[np.float64]
T = TypeVar("T")
K = TypeVar("K")
Progress: TypeAlias = Callable[[str, int, int], None]
"""Is told what is being done, how much of it is finished, and how much there is."""

MOST_PROPOSALS = 1_000_000
"""After so many models it is time to give up."""
_LANE = 0x5245_4A45_4354
"""Tells the draws that decide on models from those that made them."""
_FIRST_CHUNK = 256


def silent(what: str, done: int, total: int) -> None:
    """Tells nobody about progress."""


@dataclass(frozen=True, slots=True)
class AcceptanceRate:
    """What became of the proposed models."""

    proposals: int
    accepted: int
    """Models that were accepted, of all proposed ones."""
    bound: float
    """Weight from which on models are always accepted."""
    known: bool
    """Whether the bound was given; else it is the largest weight met, and a larger one is met with a probability of
    less than about 3 / proposals (at 95 %)."""
    mean_weight: float
    """Over all proposals."""
    truncated: float
    """Share of the wanted density that lies above a given bound, among the proposals: so much is missing."""

    @property
    def rate(self) -> float:
        """Share of proposals that were accepted."""
        return self.accepted / max(1, self.proposals)

    def __str__(self) -> str:
        bound = "known" if self.known else "the largest one met"
        lost = f", {self.truncated:.2%} of the density cut off" if self.truncated else ""
        return (
            f"accepted {self.accepted:,} of {self.proposals:,} models ({self.rate:.3%}); "
            f"bound {self.bound:.6g}, {bound}{lost}"
        )


@dataclass(frozen=True, slots=True)
class Thinned(Generic[K]):
    """Accepted models."""

    chunks: tuple[tuple[K, Ints], ...]
    """What was kept of proposed models, and which of each chunk [k] are accepted, ascending."""
    acceptance: AcceptanceRate


def thin(
    propose: Callable[[int, int], T],
    weigh: Callable[[T], Floats],
    keep: Callable[[T, Ints], K],
    num_models: int,
    seed: int,
    *,
    bound: float | None = None,
    least: float = 0.0,
    most_proposals: int = MOST_PROPOSALS,
    chunk: int = 4_096,
    on_progress: Progress = silent,
) -> Thinned[K]:
    """Accepts models until there are enough.

    Args:
        propose: from the index of the first model and a number to a chunk of models; each model depends on its index
            only.
        weigh: the weight [models] of each model of a chunk, finite and >= 0.
        keep: what to keep of some models [k] of a chunk.
        num_models: how many to accept.
        seed: 0 <= seed < 2**64; decides, with its index, on each model.
        bound: no weight is larger; None where that is not known.
        least: without a bound, what the largest weight is at least.
        most_proposals: after so many it ends, with as many as there are.
        chunk: most models proposed at once.
        on_progress: told about accepted models.

    Raises:
        GrammarlabError: when none is accepted.
    """
    kept: list[tuple[K, Floats]] = []
    """Chunks of what may be accepted, and the bound below which each model is."""
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
            kept.append((keep(models, rows), limit[rows]))
        accepted = sum(int((limits >= most).sum()) for _, limits in kept)
        proposals += size
        total += float(weights.sum())
        cut += float(np.maximum(weights - most, 0.0).sum())
        on_progress("models drawn", min(accepted, num_models), num_models)
        wanted = (num_models - accepted) * 1.1 / max(accepted / proposals, 1e-9)
        size = int(min(chunk, max(_FIRST_CHUNK, wanted)))
    if not accepted:
        raise GrammarlabError(
            f"none of {proposals:,} models was accepted: what is liked is too rare for rejection. "
            "Try the method compile, which needs no samples"
        )
    truncated = cut / total if total else 0.0
    acceptance = AcceptanceRate(proposals, accepted, most, bound is not None, total / proposals, truncated)
    return Thinned(tuple(_accepted(kept, most, num_models)), acceptance)


def _accepted(kept: Sequence[tuple[K, Floats]], bound: float, num_models: int) -> Iterator[tuple[K, Ints]]:
    """The first models that are accepted for a bound: of each chunk that has some, which."""
    for models, limits in kept:
        rows = np.flatnonzero(limits >= bound)[:num_models]
        num_models -= len(rows)
        if len(rows):
            yield models, rows


def _checked(weights: Floats, size: int) -> Floats:
    if weights.shape != (size,) or not np.isfinite(weights).all() or (weights < 0.0).any():
        raise GrammarlabError(
            f"expected a weight for each of {size} models, finite and at least 0; found shape {weights.shape}"
            + (f" with {weights.min()} to {weights.max()}" if weights.size else "")
        )
    return weights
