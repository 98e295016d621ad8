"""Models of a wanted density, to learn from: drawn by the exact grammar where there is one, else by rejection."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from grammarlab.arrays import Ints
from grammarlab.density.splits.learned import LearnedGrammar
from grammarlab.density.targets.target import Target
from grammarlab.density.targets.thinning import MOST_PROPOSALS, Progress, silent, thin
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.errors import InexactError
from grammarlab.features.counting.counts import count

Floats = NDArray[np.float64]
K = TypeVar("K")


class Candidates(NamedTuple):
    """Models that may be drawn, as trees of the grammar of the target."""

    forest: Forest
    values: Floats
    """[n, features] of the features of the target."""


@dataclass(frozen=True, slots=True)
class Drawn(Generic[K]):
    """Models of a density."""

    chunks: tuple[tuple[K, Ints], ...]
    """What was kept of candidates, and which rows of each chunk are drawn."""
    num_models: int
    mean_preference: float
    """Over the models of the grammar; an estimate, where models were rejected."""
    finding: str
    """How they were drawn, in words."""


def draw(
    target: Target,
    keep: Callable[[Candidates, Ints], K],
    num_models: int,
    seed: int,
    *,
    most_proposals: int = MOST_PROPOSALS,
    on_progress: Progress = silent,
) -> Drawn[K]:
    """Models of a wanted density, independent of each other.

    Args:
        target: the density; its base is the grammar.
        keep: what to keep of some candidates [k].
        num_models: how many.
        seed: 0 <= seed < 2**64; the same seed draws the same models.
        most_proposals: after so many candidates it ends, with as many models as there are.
        on_progress: told about models drawn.

    Raises:
        GrammarlabError: when the preference is 0 for all models, or for all that were looked at.
    """
    exact = _exact(target)
    program = compile_grammar(target.grammar if exact is None else exact.grammar)

    def propose(first: int, number: int) -> Candidates:
        forest = derive(program, number, seed, first_model=first, assets=target.folder)
        forest = forest if exact is None else exact.as_original(forest)
        return Candidates(forest, count(forest, target.features))

    def weigh(models: Candidates) -> Floats:
        return target.scores(models.values) if exact is None else np.ones(len(models.values))

    found = thin(
        propose,
        weigh,
        keep,
        num_models,
        seed,
        bound=target.bound if exact is None else 1.0,
        most_proposals=most_proposals,
        chunk=target.chunk,
        on_progress=on_progress,
    )
    number = sum(len(rows) for _, rows in found.chunks)
    if exact is None:
        return Drawn(found.chunks, number, found.acceptance.mean_weight, str(found.acceptance))
    return Drawn(found.chunks, number, exact.mean_preference, f"{number:,} models drawn by the exact grammar")


def _exact(target: Target) -> LearnedGrammar | None:
    """The exact grammar of a density; None where there is none, or its models do not tell all draws of a feature."""
    try:
        learned = target.compiled(target.first_look)
    except InexactError:
        return None
    return None if learned.attributes else learned
