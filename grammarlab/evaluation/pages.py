"""Models to show for each score of a scenario, as in appendix A of the paper."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from grammarlab.derivation.forest import Forest
from grammarlab.evaluation.preparation import Source
from grammarlab.evaluation.scenario import Scenario
from grammarlab.features.counting.counts import count
from grammarlab.features.rules.expression import Expression
from grammarlab.features.rules.score import Score

Floats = NDArray[np.float64]

OTHERS = "others"
"""Name of the models without a case."""
BANDS = (80.0, 60.0, 40.0, 20.0, 0.0)
"""Lower bounds of the groups of a continuous score."""


@dataclass(frozen=True, slots=True)
class LikedModels:
    """Models with equal scores for the same reason."""

    score: float
    """0 to 100; the lower bound of a band."""
    means: str
    """The reason in words."""
    models: tuple[int, ...]
    """The first ones of the labelled set; none if it has none."""


def models_for_scores(source: Source, num: int) -> tuple[LikedModels, ...]:
    """Models of the labelled set for every case of a scenario, the cases in their order and the others last.

    A product of factors has one group per score, an expression one per band of scores.

    Args:
        source: the scenario with its grammar.
        num: largest number of models per group.

    Raises:
        UsageError: If the preference does not fit the grammar.
        DerivationError: If a rule cannot be applied.
    """
    scenario, space = source.scenario, source.space
    scenario.check(space.program.symbols, space.program.rule_names, space.program.sites)
    labels, group_of = _grouping(scenario)
    found: list[list[int]] = [[] for _ in labels]
    for forest in space.sample(source.labelled_address.flat, scenario.num_models, scenario.seed):
        groups = group_of(forest)
        for group, models in enumerate(found):
            new = np.flatnonzero(groups == group)[: num - len(models)]
            models.extend(forest.lots.model[new].tolist())
        if all(len(models) == num for models in found):
            break
    return tuple(LikedModels(score, means, tuple(models)) for (score, means), models in zip(labels, found, strict=True))


def _grouping(scenario: Scenario) -> tuple[list[tuple[float, str]], Callable[[Forest], NDArray[np.intp]]]:
    """Score and meaning of the groups, and a function to the group of every model."""
    score = scenario.score
    if score.cases:
        decides = _deciding_case(score)
        labels = [*((case.value, case.means) for case in score.cases), (0.0, OTHERS)]
        return labels, lambda forest: decides.evaluate(count(forest, decides.features)).astype(np.intp)
    factors = [factor.score for factor in scenario.factors]
    if all(factor.levels for factor in factors):
        shares = product(*([level / 100 for level in factor.levels] for factor in factors))
        lowest = sorted({round(100 * float(np.prod(share)), 9) for share in shares}, reverse=True)
        labels = [(level, "") for level in lowest]
    else:
        lowest = list(BANDS)
        labels = [(low, f"{low:g} to {high:g}") for low, high in zip(BANDS, (100.0, *BANDS[:-1]), strict=True)]
    # Rounding may leave a score a little below its level.
    bounds = np.array(lowest[::-1]) - 1e-6

    def group_of(forest: Forest) -> NDArray[np.intp]:
        values = score.evaluate(count(forest, score.features))
        return len(bounds) - np.searchsorted(bounds, values, side="right")

    return labels, group_of


def _deciding_case(score: Score) -> Expression:
    """Index of the case, from 0, that holds for a model; their number if none does."""
    names = {f"case_{i}": case.when for i, case in enumerate(score.cases)}
    pairs = ", ".join(f"{name}, {i}" for i, name in enumerate(names))
    return Expression.parse(f"choose({pairs}, {len(names)})", names)
