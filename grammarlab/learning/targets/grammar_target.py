"""From a learned preference to a grammar: the target density, and the nearest grammar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from grammarlab.arrays import BATCH, Floats
from grammarlab.density.exact.compile import Exactness
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.grammar_skeleton import MAX_EXAMINED_MODELS
from grammarlab.density.samples import sampled
from grammarlab.density.samples.sampled import compile_nearest
from grammarlab.density.targets.rejection import Progress, RejectionSampler, reject, silent
from grammarlab.density.targets.target import Target
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.round import State, Study
from grammarlab.learning.targets.accepting_target import ReadableSampler, smallest
from grammarlab.learning.targets.file_head import head, without_earlier_head
from grammarlab.learning.targets.grammar_columns import GrammarColumns
from grammarlab.learning.targets.simplification import predict
from grammarlab.learning.targets.target_density import PoolDensity
from grammarlab.learning.targets.writers import AbstractTargetWriter, LearnedDensity, Making, judged
from grammarlab.preference.base import LIKED_SHARE

LearnedSampler = LearnedGrammar | RejectionSampler

METHODS = ("compile", *sampled.METHODS, "rejection")
"""Methods; rejection makes no grammar."""


@dataclass(frozen=True)
class GrammarWriter(AbstractTargetWriter[Forest]):
    """Makes grammars from preferences learned on a grammar."""

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
        forest = derive(space.program, MAX_EXAMINED_MODELS, seed, assets=space.folder, leaves=False)
        predicted = predict(study, state)
        target = Target(space.grammar, (), _alike, making.base, assets=space.assets)
        columns = GrammarColumns.of(space, study, state, predicted, Exactness(space.grammar, forest))
        header = head(lines, predicted, seed)
        density = PoolDensity.of(
            target, columns, study.tables(state.wide).pool_designs, predicted.scores, _liked(space, state)
        )
        if method != "compile" and space.acceptance is not None:
            raise UsageError(f"method {method!r} would lose the acceptance rule of this file: use compile.")
        if method == "compile":
            sampler = smallest(density, forest, making, header)
        else:
            simple = density.simplest(exact_only=method != "rejection")
            learned = learn_target(simple.target, method, forest, header, seed, making.num_samples, on_progress)
            sampler = ReadableSampler(learned, simple.preference, simple.target.even)
        features = {columns.features[c]: columns.names[c] for c in sampler.preference.columns.tolist()}
        base_ratio = None if sampler.even is None else sampler.even.ratio
        scores = sampler.preference(columns.rows)
        learned = sampler.learned
        # A rejection has no file, and a text that stays the same is not parsed again.
        if not isinstance(learned, RejectionSampler) and (text := without_earlier_head(learned.text)) != learned.text:
            learned = replace(learned, text=text)
        return judged(study, state, learned, predicted, scores, features, base_ratio)


def learn_target(
    target: Target,
    method: str,
    forest: Forest,
    lines: Sequence[str],
    seed: int,
    num_samples: int = sampled.NUM_SAMPLES,
    on_progress: Progress = silent,
) -> LearnedSampler:
    """Result of a method for a target density.

    Args:
        target: the density.
        method: one of `METHODS`.
        forest: derivations of the grammar.
        lines: comment lines at the top of the new file.
        seed: seed of the samples.
        num_samples: number of models to learn from.
        on_progress: called with the progress of these models.

    Raises:
        GrammarlabError: If the density cannot be made.
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


def _liked(space: GrammarSpace, state: State) -> Forest | None:
    """The models with the highest scores of a factor, if no other factor has given them a low one."""
    liked: dict[Address, bool] = {}
    for name in state.liked:
        answers = state.answers[name].scored
        low = LIKED_SHARE * answers.scores.max(initial=0.0)
        for design, score in zip(answers.designs, answers.scores.tolist(), strict=True):
            liked[design] = liked.get(design, True) and score >= low > 0.0
    designs = sorted(design for design, is_liked in liked.items() if is_liked)[:BATCH]
    return space.make(designs) if designs else None


def _alike(values: Floats) -> Floats:
    return np.ones(len(values))
