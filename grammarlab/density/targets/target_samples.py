"""Samples of a target density to learn from: from the exact grammar if there is one, otherwise by rejection."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.targets.rejection import MAX_PROPOSALS, Progress, silent, thin
from grammarlab.density.targets.target import Target
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.errors import InexactError
from grammarlab.features.patterns.counts import count

K = TypeVar("K")


class Candidates(NamedTuple):
    """Candidate models, as trees of the grammar of the target."""

    forest: Forest
    values: Floats
    """[n, features] values of the features of the target."""


@dataclass(frozen=True, slots=True)
class Drawn(Generic[K]):
    """Models of a density."""

    chunks: tuple[tuple[K, Ints], ...]
    """Kept data of candidates, and the drawn rows of each chunk."""
    num_models: int
    mean_preference: float
    """Mean over the models of the grammar; an estimate if models were rejected."""
    finding: str
    """Description of how they were drawn."""


def draw(
    target: Target,
    keep: Callable[[Candidates, Ints], K],
    num_models: int,
    seed: int,
    *,
    most_proposals: int = MAX_PROPOSALS,
    on_progress: Progress = silent,
) -> Drawn[K]:
    """Independent models of a target density, without leaves.

    Args:
        target: the density; its base is the grammar.
        keep: function that selects the data to keep of candidates [k].
        num_models: number of models.
        seed: 0 <= seed < 2**64; the same seed draws the same models.
        most_proposals: largest number of candidates; then it ends with fewer models.
        on_progress: called with the number of drawn models.

    Raises:
        GrammarlabError: If the preference is 0 for all models, or for all candidates.
    """
    exact = _exact(target)
    program = compile_grammar(target.grammar if exact is None else exact.grammar)

    def propose(first: int, number: int) -> Candidates:
        forest = derive(program, number, seed, first_model=first, assets=target.folder, leaves=False)
        forest = forest if exact is None else exact.as_original(forest)
        return Candidates(forest, count(forest, target.features))

    def weigh(models: Candidates) -> Floats:
        return target.scores(models.values) if exact is None else np.ones(len(models.values))

    thinned = thin(
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
    number = sum(len(rows) for _, rows in thinned.chunks)
    if exact is None:
        return Drawn(thinned.chunks, number, thinned.acceptance.mean_weight, str(thinned.acceptance))
    return Drawn(thinned.chunks, number, exact.mean_preference, f"{number:,} models drawn by the exact grammar")


def _exact(target: Target) -> LearnedGrammar | None:
    """Exact grammar of a density; None if there is none, or its models do not record all draws of a feature."""
    try:
        learned = target.compiled(target.first_look)
    except InexactError:
        return None
    return None if learned.attributes else learned
