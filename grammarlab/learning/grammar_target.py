"""From what was learned to a grammar that samples it: the target density, and the grammar that comes nearest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

from grammarlab.density import sampled
from grammarlab.density.exactness import Exactness
from grammarlab.density.learned import LearnedGrammar
from grammarlab.density.nearest import compile_nearest
from grammarlab.density.rejection import RejectionSampler, reject
from grammarlab.density.skeleton import ENOUGH_MODELS
from grammarlab.density.target import Target
from grammarlab.density.thinning import Progress, silent
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.learning.grammar_space import GrammarSpace
from grammarlab.learning.round import State, Study
from grammarlab.learning.simplification import simplify
from grammarlab.learning.target import AbstractTargetWriter, LearnedDensity, Making, judged

LearnedSampler = LearnedGrammar | RejectionSampler

METHODS = ("compile", *sampled.METHODS, "rejection")
"""Of these, rejection makes no grammar."""


@dataclass(frozen=True)
class GrammarWriter(AbstractTargetWriter[Forest]):
    """Makes grammars of what was learned about a grammar."""

    space: GrammarSpace

    @property
    def methods(self) -> tuple[str, ...]:
        return METHODS

    def learn(
        self,
        study: Study[Forest],
        state: State,
        making: Making,
        lines: Sequence[str] = (),
        on_progress: Progress = silent,
    ) -> LearnedDensity[Forest]:
        space, seed, method = self.space, study.pool.seed, self.method(making.method)
        forest = derive(space.program, ENOUGH_MODELS, seed, assets=space.folder)
        exactness = Exactness(space.grammar, forest)
        preference = simplify(study, state, lambda feature: not exactness.reason_against(feature))
        target = Target(space.grammar, preference.features, preference, making.base, preference.bound, space.assets)
        learned = learn_target(target, method, forest, lines, seed, making.num_samples, on_progress)
        return judged(study, state, learned, preference, None if target.even is None else target.even.ratio)


def learn_target(
    target: Target,
    method: str,
    forest: Forest,
    lines: Sequence[str],
    seed: int,
    num_samples: int = sampled.NUM_SAMPLES,
    on_progress: Progress = silent,
) -> LearnedSampler:
    """What a method makes of a wanted density.

    Args:
        target: the density.
        method: of `METHODS`.
        forest: derivations of the grammar.
        lines: of a comment at the top of the new file.
        seed: of samples.
        num_samples: models to learn from.
        on_progress: told about these models.

    Raises:
        GrammarlabError: when the density cannot be made.
    """
    options: dict[str, Any] = {"seed": seed, "on_progress": on_progress}

    def header(made_by: str) -> list[str]:
        return [*lines, f"Method {made_by}, base {target.base}"]

    if method == "compile":
        return compile_nearest(target, forest, header, num_samples=num_samples, **options)
    if method == "rejection":
        return reject(target, num_pilot=num_samples, **options)
    chosen = cast(sampled.Method, method)
    return sampled.learn(target, chosen, num_samples=num_samples, header=header(method), **options)
