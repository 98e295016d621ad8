"""`learn`: a grammar, or a species, learned from the scores of a function."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from grammarlab.arrays import Floats, Ints
from grammarlab.asset_roots import AssetRoot
from grammarlab.density.exact.splitting import Base
from grammarlab.derivation.forest import Forest
from grammarlab.errors import UsageError, check_type
from grammarlab.language.grammar import EXAMPLE, Grammar
from grammarlab.learning.designs.addresses import Address
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool
from grammarlab.learning.interview import interview
from grammarlab.learning.progress_line import WRITING, ProgressOption, shown_progress
from grammarlab.learning.round import Study, init
from grammarlab.learning.settings import Settings
from grammarlab.learning.targets.file_head import origin_line
from grammarlab.learning.targets.grammar_target import GrammarWriter
from grammarlab.learning.targets.writers import AbstractTargetWriter, LearnedDensity, Making
from grammarlab.preference.base import MAX_SCORE
from grammarlab.preference.labels import OVERALL
from grammarlab.scene.instances import Scene
from grammarlab.trees.species import Species

if TYPE_CHECKING:
    from grammarlab.learning.designs.tree_columns import TreeBatch


@overload
def learn(
    grammar: Grammar,
    score: Callable[[Forest], ArrayLike],
    budget: int = ...,
    *,
    sees: Literal["forest"] = ...,
    assets: AssetRoot | None = ...,
    pool: Pool | None = ...,
    settings: Settings | None = ...,
    base: Base = ...,
    max_rules: int | None = ...,
    seed: int = ...,
    progress: ProgressOption = ...,
) -> LearnedDensity[Forest]: ...
@overload
def learn(
    grammar: Grammar,
    score: Callable[[Scene], ArrayLike],
    budget: int = ...,
    *,
    sees: Literal["scene"],
    assets: AssetRoot | None = ...,
    pool: Pool | None = ...,
    settings: Settings | None = ...,
    base: Base = ...,
    max_rules: int | None = ...,
    seed: int = ...,
    progress: ProgressOption = ...,
) -> LearnedDensity[Forest]: ...
@overload
def learn(
    grammar: Species,
    score: Callable[[TreeBatch], ArrayLike],
    budget: int = ...,
    *,
    sees: Literal["trees"] = ...,
    assets: AssetRoot | None = ...,
    pool: Pool | None = ...,
    settings: Settings | None = ...,
    base: Base = ...,
    max_rules: int | None = ...,
    seed: int = ...,
    progress: ProgressOption = ...,
) -> LearnedDensity[TreeBatch]: ...
@overload
def learn(
    grammar: Species,
    score: Callable[[Scene], ArrayLike],
    budget: int = ...,
    *,
    sees: Literal["scene"],
    assets: AssetRoot | None = ...,
    pool: Pool | None = ...,
    settings: Settings | None = ...,
    base: Base = ...,
    max_rules: int | None = ...,
    seed: int = ...,
    progress: ProgressOption = ...,
) -> LearnedDensity[TreeBatch]: ...
def learn(
    grammar: Grammar | Species,
    score: Callable[..., ArrayLike],
    budget: int = 128,
    *,
    sees: Literal["", "forest", "trees", "scene"] = "",
    assets: AssetRoot | None = None,
    pool: Pool | None = None,
    settings: Settings | None = None,
    base: Base = "grammar",
    max_rules: int | None = None,
    seed: int = 0,
    progress: ProgressOption = "auto",
) -> LearnedDensity[Any]:
    """Grammar, or species of trees, that samples models in proportion to the scores of a function.

    The function is asked about a few models at a time, like a person in a scoring session.

    Args:
        grammar: the original grammar or species.
        score: function from models [k] to scores [k] from 0 (disliked) to 100, or to booleans: True is 100, False is 0.
        budget: number of scores to ask for, >= 1.
        sees: argument of the function: ``scene``, the meshes of the models; or, by default, ``forest``, the derivation
            trees and leaves of models of a grammar, or ``trees``, the parameters and measures of trees of a species.
        assets: folder of the meshes and images that are used, by default that of the grammar or species.
        pool: the models to ask about.
        settings: options of learning; by default those for a person.
        base: density that the scores multiply: the grammar's own, or the same for every tree.
        max_rules: largest number of branches of the rules, as `grammarlab show` counts them; by default twice as many
            as before. If it is too small, an acceptance rule completes the original rules.
        seed: seed of the choice of models, 0 <= seed < 2**64.
        progress: ``auto`` shows a line with a bar on a terminal or below the cell of a notebook; None shows nothing; a
            function is called with the name of a stage, how many of its parts are done, and how many there are (0 if
            unknown).

    Returns:
        The learned grammar (`LearnedDensity.learned`, whose `text` is a rule file and which can be sampled), its
        features, and its distance from the predicted scores.

    Raises:
        UsageError: If the budget is below 1, or scores have another number or range, or are NaN.
        GrammarlabError: If nothing is liked, or the density cannot be made.

    >>> import grammarlab as gl
    >>> grammar = gl.Grammar.parse("Lot --> 50% : extrude(3) Low else : extrude(9) High")
    >>> found = gl.learn(grammar, lambda forest: 100 * gl.count(forest, [gl.pattern("High")])[:, 0], 16)
    >>> found.learned.sample(50, seed=1).leaves.size[:, 1].min()
    np.float64(9.0)
    """
    check_type("grammar", grammar, (Grammar, Species), EXAMPLE)
    if not callable(score):
        raise UsageError(f"score: expected a function from models to scores, found {type(score).__name__}.")
    if budget < 1:
        raise UsageError(f"budget: expected at least 1 score to ask for, found {budget}.")
    space, writer, views = _subject(grammar, grammar.assets if assets is None else assets)
    if sees not in ("", *views):
        raise UsageError(f"sees: expected one of {', '.join(views)}, found {sees!r}.")
    view = views[sees or next(iter(views))]
    study = Study(space, pool or Pool.usual(space), settings)

    def person(addresses: Sequence[Address], _numbers: Ints) -> Floats:
        return _checked(score(view(addresses)), len(addresses))[:, None]

    # At these sizes several threads are slower than one.
    with threadpool_limits(1), shown_progress(progress) as on_progress:
        state = init(study)
        study.tables(state.wide, on_progress)
        on_progress("scores", 0, budget)
        for state in interview(study, (OVERALL,), person, budget=budget, seed=seed):
            on_progress("scores", state.num_answers, budget)
        if not state.liked:
            raise UsageError(
                f"none of the {state.num_answers} models that the function was asked about has a score above 0, so "
                "nothing is liked. Raise the budget, or give low scores to models that are nearly liked."
            )
        name = grammar.file if isinstance(grammar, Grammar) else grammar.name
        lines = [origin_line(name, space.hashes[0]), f"Function: {state.num_answers} scores"]
        on_progress(WRITING, 0, 0)
        return writer.learn(study, state, Making(base=base, max_rules=max_rules), lines, on_progress)


class _Subject(NamedTuple):
    """What is learned about."""

    space: AbstractDesignSpace[Any]
    writer: AbstractTargetWriter[Any]
    views: Mapping[str, Callable[[Sequence[Address]], Any]]
    """What a function may see of designs, the default first."""


def _subject(description: Grammar | Species, assets: AssetRoot | None) -> _Subject:
    if isinstance(description, Grammar):
        rules = GrammarSpace(description, assets)
        return _Subject(rules, GrammarWriter(rules), {"forest": rules.derive, "scene": _scene_of(rules)})
    # Grammars do without trees.
    from grammarlab.learning.designs.species_space import SpeciesSpace  # noqa: PLC0415
    from grammarlab.learning.targets.species_target import SpeciesWriter  # noqa: PLC0415
    from grammarlab.trees.species_file import write  # noqa: PLC0415

    trees = SpeciesSpace(description, write(description), assets)
    return _Subject(trees, SpeciesWriter(trees), {"trees": trees.make, "scene": _scene_of(trees)})


def _scene_of(space: AbstractDesignSpace[Any]) -> Callable[[Sequence[Address]], Scene]:
    return lambda addresses: space.realize(addresses).scene


def _checked(scores: ArrayLike, num: int) -> Floats:
    raw = np.asarray(scores)
    values = raw.astype(np.float64) * (MAX_SCORE if raw.dtype == np.bool_ else 1.0)
    if values.shape != (num,):
        raise UsageError(f"score: expected {num} numbers for {num} models, found an array of shape {values.shape}.")
    missing = np.flatnonzero(np.isnan(values))
    if len(missing):
        raise UsageError(
            f"score: {len(missing)} of {num} scores are not numbers (NaN), the first is of model {missing[0]}."
        )
    if not ((values >= 0.0) & (values <= MAX_SCORE)).all():
        raise UsageError(f"score: expected numbers from 0 to {MAX_SCORE:g}, found {values.min()} to {values.max()}.")
    return values
