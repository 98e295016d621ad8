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
from grammarlab.learning.designs.pool import MadePool
from grammarlab.learning.targets.divergence import agreement
from grammarlab.learning.targets.grammar_columns import GrammarColumns
from grammarlab.learning.targets.simplification import TOLERANCE, simpler
from grammarlab.preference.simplified import SimplifiedPreference

MOST_LEAVES = 128
"""Largest number of leaves of a tree that becomes a grammar."""
LONGEST = MAX_CHARACTERS // 2
"""Largest number of characters of the text of a function, so that a quotient of two functions can be parsed."""
_WAYS = 4
"""Ratio of alternatives before symbols are merged to allowed rules."""
_MANY_WAYS = 2_000
"""Smallest allowed number of alternatives."""
_STEPS = (0.05, 0.01, 0.001, 0.0001)
"""Candidate steps of percentages, roundest first."""
_MOVED = 1e-4
"""Largest loss in nats by round percentages."""


class Simple(NamedTuple):
    """A simple function, as a density."""

    preference: SimplifiedPreference
    js: float
    """Divergence in nats from the prediction, on the pool."""
    target: Target


@dataclass(frozen=True)
class Wanted:
    """A predicted density on a pool."""

    target: Target
    """The grammar and the base; its preference is not used."""
    columns: GrammarColumns
    made: MadePool[Forest]
    scores: Floats
    """[m] predicted scores, at least one above 0."""
    weights: Floats
    """[m] importance weight of each model of the pool under the base."""

    @classmethod
    def of(cls, target: Target, columns: GrammarColumns, made: MadePool[Forest], scores: Floats) -> Wanted:
        ratio = 1.0 if target.even is None else np.concatenate([target.even.ratio(f) for f in made.batches])
        return cls(target, columns, made, scores, made.weights * ratio)

    def simple(self, exact_only: bool, max_leaves: int = MOST_LEAVES) -> Iterator[Simple]:
        """Simple functions of the columns from `simpler`, without those whose text is too long."""
        columns, order = self.columns, self.columns.order
        order = order[columns.exact[order]] if exact_only else order
        for found in simpler(columns.rows, self.scores, self.weights, order, max_leaves):
            if len(columns.text(found.preference)) <= LONGEST:
                yield Simple(found.preference, found.js, self.as_target(found.preference))

    def simplest(self, exact_only: bool) -> Simple:
        """The first of them; with fewer leaves if all texts are too long."""
        sizes = (MOST_LEAVES >> halved for halved in range(MOST_LEAVES.bit_length()))
        return next(found for size in sizes for found in self.simple(exact_only, size))

    def as_target(self, preference: SimplifiedPreference) -> Target:
        """A function of the columns as a density."""
        score = Score.of_text(self.columns.text(preference))
        own = Target.of_score(self.target.grammar, score, self.target.base, self.target.assets)
        return replace(own, bound=max(preference.levels))


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
        return target.compiled(forest, header, max(_WAYS * most, _MANY_WAYS), step)
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
    wanted: Wanted, target: Target, forest: Forest, header: Sequence[str], exact: LearnedGrammar, others: Floats
) -> LearnedGrammar:
    """Grammar with the roundest percentages that hardly change its density; unchanged for the base uniform.

    Args:
        wanted: the predicted density.
        target: the density of the grammar.
        forest: see `compiled`.
        header: see `compiled`.
        exact: the grammar with exact percentages.
        others: [m] factors of an acceptance rule on the density of the grammar.
    """
    if target.base == "uniform":
        return exact
    own = others * np.concatenate([exact.ratio(models) for models in wanted.made.batches])
    for step in _STEPS:
        found = target.compiled(forest, header, step=step)
        ratio = others * np.concatenate([found.ratio(models) for models in wanted.made.batches])
        moved = agreement(own, ratio, wanted.made.weights).js
        if moved <= _MOVED and agreement(wanted.scores, ratio, wanted.made.weights).js <= TOLERANCE:
            return found
    return exact
