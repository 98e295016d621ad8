"""Target densities: a predicted density, and simple functions near it as densities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.rounding import EXACT
from grammarlab.density.targets.target import Target
from grammarlab.derivation.forest import Forest
from grammarlab.errors import InexactError, LanguageError
from grammarlab.features.expression import MAX_CHARACTERS
from grammarlab.features.model_score import Score
from grammarlab.learning.designs.pool import PoolDesigns
from grammarlab.learning.targets.divergence import agreement
from grammarlab.learning.targets.grammar_columns import GrammarColumns
from grammarlab.learning.targets.simplification import TOLERANCE, simpler
from grammarlab.preference.simplified import SimplifiedPreference

MAX_LEAVES = 128
"""Largest number of leaves of a tree that becomes a grammar."""
MAX_TEXT = MAX_CHARACTERS // 2
"""Largest number of characters of the text of a function, so that a quotient of two functions can be parsed."""
_ALTERNATIVES_RATIO = 4
"""Ratio of alternatives before symbols are merged to allowed rules."""
_MIN_ALTERNATIVES = 2_000
"""Least limit of the number of alternatives before symbols are merged."""
_PERCENTAGE_STEPS = (0.05, 0.01, 0.001, 0.0001)
"""Candidate steps of percentages, roundest first."""
_MAX_ROUNDING_JS = 1e-4
"""Largest loss in nats by round percentages."""


class Simple(NamedTuple):
    """A simple function, as a density."""

    preference: SimplifiedPreference
    js: float
    """Divergence in nats from the prediction, on the pool."""
    target: Target


@dataclass(frozen=True)
class PoolDensity:
    """A predicted density on a pool."""

    target: Target
    """The grammar and the base; its preference is not used."""
    columns: GrammarColumns
    pool_designs: PoolDesigns[Forest]
    scores: Floats
    """[m] predicted scores, at least one above 0."""
    weights: Floats
    """[m] importance weight of each model of the pool under the base."""

    @classmethod
    def of(
        cls, target: Target, columns: GrammarColumns, pool_designs: PoolDesigns[Forest], scores: Floats
    ) -> PoolDensity:
        ratio = 1.0 if target.even is None else np.concatenate([target.even.ratio(f) for f in pool_designs.batches])
        return cls(target, columns, pool_designs, scores, pool_designs.weights * ratio)

    def simple(self, exact_only: bool, max_leaves: int = MAX_LEAVES) -> Iterator[Simple]:
        """Simple functions of the columns from `simpler`, without those whose text is too long."""
        columns, order = self.columns, self.columns.order
        order = order[columns.exact[order]] if exact_only else order
        for simplified in simpler(columns.rows, self.scores, self.weights, order, max_leaves):
            if len(columns.text(simplified.preference)) <= MAX_TEXT:
                yield Simple(simplified.preference, simplified.js, self.as_target(simplified.preference))

    def simplest(self, exact_only: bool) -> Simple:
        """The first of them; with fewer leaves if all texts are too long."""
        sizes = (MAX_LEAVES >> halved for halved in range(MAX_LEAVES.bit_length()))
        return next(simple for size in sizes for simple in self.simple(exact_only, size))

    def as_target(self, preference: SimplifiedPreference) -> Target:
        """A function of the columns as a density."""
        score = Score.of_text(self.columns.text(preference))
        density = Target.of_score(self.target.grammar, score, self.target.base, self.target.assets)
        return replace(density, bound=max(preference.levels))


def compiled(
    target: Target, forest: Forest, header: Sequence[str], most: int, step: float = EXACT
) -> LearnedGrammar | None:
    """Exact grammar of a density; None if there is none, or it is much too large.

    Args:
        target: the density.
        forest: derivations of the grammar that show how often successors inside blocks occur.
        header: comment lines at the top of the file.
        most: largest number of branches of the rules.
        step: probabilities are rounded to multiples of this.
    """
    try:
        return target.compiled(forest, header, max(_ALTERNATIVES_RATIO * most, _MIN_ALTERNATIVES), step)
    except InexactError:
        return None


def rules_if_few(learned: LearnedGrammar, most: int) -> int:
    """Number of branches of all rules of a grammar, or of the changed rules only if these have more than a limit.

    The others are known after parsing only, which takes long.
    """
    if learned.rules_changed > most:
        return learned.rules_changed
    try:
        return learned.rules_after
    except LanguageError:  # too many words for a rule file
        return most + 1


def rounded_off(
    density: PoolDensity, target: Target, forest: Forest, header: Sequence[str], exact: LearnedGrammar, others: Floats
) -> LearnedGrammar:
    """Grammar with the roundest percentages that hardly change its density; unchanged for the base uniform.

    Args:
        density: the predicted density.
        target: the density of the grammar.
        forest: derivations for `compiled`.
        header: comment lines for `compiled`.
        exact: the grammar with exact percentages.
        others: [m] factors of an acceptance rule on the density of the grammar.
    """
    if target.base == "uniform":
        return exact
    exact_ratio = others * np.concatenate([exact.ratio(models) for models in density.pool_designs.batches])
    for step in _PERCENTAGE_STEPS:
        rounded = target.compiled(forest, header, step=step)
        ratio = others * np.concatenate([rounded.ratio(models) for models in density.pool_designs.batches])
        moved = agreement(exact_ratio, ratio, density.pool_designs.weights).js
        if moved <= _MAX_ROUNDING_JS and agreement(density.scores, ratio, density.pool_designs.weights).js <= TOLERANCE:
            return rounded
    return exact
