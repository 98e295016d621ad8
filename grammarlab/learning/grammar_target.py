"""From what was learned to a grammar that samples it: the target density, and the grammar that comes nearest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from grammarlab.density import sampled
from grammarlab.density.exactness import Exactness
from grammarlab.density.learned import LearnedGrammar
from grammarlab.density.nearest import compile_nearest
from grammarlab.density.rejection import RejectionSampler, reject
from grammarlab.density.skeleton import ENOUGH_MODELS
from grammarlab.density.splitting import Base
from grammarlab.density.target import Target
from grammarlab.density.thinning import Progress, silent
from grammarlab.derivation.derive import derive
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError
from grammarlab.learning.agreement import agreement
from grammarlab.learning.grammar_space import GrammarSpace
from grammarlab.learning.measure import Measured, measured
from grammarlab.learning.round import State, Study
from grammarlab.learning.simplification import SimplifiedProduct, product, simplify

Floats = NDArray[np.float64]
Learned = LearnedGrammar | RejectionSampler

METHODS = ("compile", *sampled.METHODS, "rejection")
"""Of these, rejection makes no grammar."""


@dataclass(frozen=True, slots=True)
class Step:
    """What one step on the way to the grammar did to the density."""

    name: str
    js: float
    """Divergence in nats between the density before it and after it, on the pool."""


@dataclass(frozen=True)
class LearnedDensity:
    """A grammar that samples what was learned."""

    learned: Learned
    target: Target
    """The density that was learned, as a function of few features."""
    preference: SimplifiedProduct
    steps: tuple[Step, ...]
    measured: Measured
    """Beside the predicted density, on the pool."""


def learn_grammar(
    study: Study[Forest],
    state: State,
    space: GrammarSpace,
    *,
    method: str = "compile",
    base: Base = "grammar",
    num_samples: int = sampled.NUM_SAMPLES,
    lines: Sequence[str] = (),
    on_progress: Progress = silent,
) -> LearnedDensity:
    """The grammar that samples in proportion to what a state predicts.

    Args:
        study: the pool, at whose seed models are drawn.
        state: what was learned; something is liked.
        space: the models, as `study.space`.
        method: of `METHODS`.
        base: what the preference multiplies.
        num_samples: models to learn from, for the methods that need them.
        lines: of a comment at the top of the new file.
        on_progress: told about these models.

    Raises:
        UsageError: for an unknown method.
        GrammarlabError: when the density cannot be made.
    """
    check_method(method)
    seed = study.pool.seed
    forest = derive(space.program, ENOUGH_MODELS, seed, assets=space.folder)
    exactness = Exactness(space.grammar, forest)
    preference = simplify(study, state, lambda feature: not exactness.reason_against(feature))
    target = Target(space.grammar, preference.features, preference, base, preference.bound, space.assets)
    learned = learn_target(target, method, forest, lines, seed, num_samples, on_progress)
    return LearnedDensity(learned, target, preference, *_judged(study, state, learned, target, preference))


def learn_target(
    target: Target,
    method: str,
    forest: Forest,
    lines: Sequence[str],
    seed: int,
    num_samples: int = sampled.NUM_SAMPLES,
    on_progress: Progress = silent,
) -> Learned:
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


def check_method(method: str, known: Sequence[str] = METHODS) -> None:
    """Makes sure that there is a method of this name.

    Raises:
        UsageError: when there is not.
    """
    if method not in known:
        raise UsageError(f"no method is called {method!r}; those there are: {', '.join(known)}")


def _judged(
    study: Study[Forest], state: State, learned: Learned, target: Target, preference: SimplifiedProduct
) -> tuple[tuple[Step, ...], Measured]:
    """What each step did to the density, and how near the result comes to the predicted one."""
    made, rows = study.tables(state.wide).made, study.table(state).rows
    predicted = product([factor.predicted for factor in preference.factors])
    drawn = product([factor.drawn for factor in preference.factors])
    few = preference.of_rows(rows[: len(made.pool), preference.columns])
    ratio = np.concatenate([learned.ratio(forest) for forest in made.batches])
    even = target.even
    base_ratio = np.ones(len(ratio)) if even is None else np.concatenate([even.ratio(f) for f in made.batches])
    weights = made.weights * base_ratio
    relative = np.divide(ratio, base_ratio, out=np.zeros(len(ratio)), where=base_ratio > 0.0)
    steps = (
        Step("scores drawn to the levels that were given", agreement(predicted, drawn, weights).js),
        Step("features left out", agreement(drawn, few, weights).js),
        Step("made into a grammar", agreement(few, relative, weights).js),
    )
    return steps, measured(predicted * base_ratio, ratio, made.weights)
