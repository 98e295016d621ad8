"""A predicted density, and simple functions that come near it, as densities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grammarlab.density.rounding import EXACT
from grammarlab.density.splits.learned import LearnedGrammar
from grammarlab.density.targets.target import Target
from grammarlab.derivation.forest import Forest
from grammarlab.errors import InexactError, LanguageError
from grammarlab.features.rules.expression import MAX_CHARACTERS
from grammarlab.features.rules.score import Score
from grammarlab.learning.designs.made import MadePool
from grammarlab.learning.targets.agreement import agreement
from grammarlab.learning.targets.grammar_columns import GrammarColumns
from grammarlab.learning.targets.simplification import TOLERANCE, simpler
from grammarlab.preference.simple.simplified import SimplifiedPreference

Floats = NDArray[np.float64]

MOST_LEAVES = 128
"""Of a tree that becomes a grammar."""
LONGEST = MAX_CHARACTERS // 2
"""Characters of the text of a function: that of a quotient of two can be read as well."""
_WAYS = 4
"""Times as many alternatives as rules are allowed are made before symbols are joined."""
_MANY_WAYS = 2_000
"""So many are made at least."""
_STEPS = (0.05, 0.01, 0.001, 0.0001)
"""What percentages are multiples of, roundest first."""
_MOVED = 1e-4
"""Nats that round percentages may cost."""


class Simple(NamedTuple):
    """A simple function, as a density."""

    preference: SimplifiedPreference
    js: float
    """Nats from what was predicted, on the pool."""
    target: Target


@dataclass(frozen=True)
class Wanted:
    """A predicted density on a pool."""

    target: Target
    """The grammar and the base; its preference is not looked at."""
    columns: GrammarColumns
    made: MadePool[Forest]
    scores: Floats
    """[m] predicted, one at least above 0."""
    weights: Floats
    """[m] what each model of the pool stands for under the base."""

    @classmethod
    def of(cls, target: Target, columns: GrammarColumns, made: MadePool[Forest], scores: Floats) -> Wanted:
        ratio = 1.0 if target.even is None else np.concatenate([target.even.ratio(f) for f in made.batches])
        return cls(target, columns, made, scores, made.weights * ratio)

    def simple(self, exact_only: bool, max_leaves: int = MOST_LEAVES) -> Iterator[Simple]:
        """Simple functions of the columns, as `simpler` gives them, without those whose text is too long."""
        columns, order = self.columns, self.columns.order
        order = order[columns.exact[order]] if exact_only else order
        for found in simpler(columns.rows, self.scores, self.weights, order, max_leaves):
            if len(columns.text(found.preference)) <= LONGEST:
                yield Simple(found.preference, found.js, self.as_target(found.preference))

    def simplest(self, exact_only: bool) -> Simple:
        """The first of them; with fewer leaves where all texts are too long."""
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
    """The exact grammar of a density; None where there is none, or it is by far too large.

    Args:
        target: the density.
        forest: derivations of the grammar that show how often successors inside blocks occur.
        header: lines of a comment at the top of the file.
        most: rules that are allowed.
        step: what probabilities are rounded to multiples of.
    """
    try:
        return target.compiled(forest, header, max(_WAYS * most, _MANY_WAYS), step)
    except InexactError:
        return None


def rules_if_few(learned: LearnedGrammar, most: int) -> int:
    """The rules of a grammar; where those that changed are more than so many, these alone, since reading takes long."""
    if learned.rules_changed > most:
        return learned.rules_changed
    try:
        return learned.rules_after
    except LanguageError:  # too many words for a rule file
        return most + 1


def rounded_off(
    wanted: Wanted, target: Target, forest: Forest, header: Sequence[str], exact: LearnedGrammar, others: Floats
) -> LearnedGrammar:
    """A grammar with the roundest percentages that leave its density nearly as it is; where it is to be even, as it is.

    Args:
        wanted: the density that was predicted.
        target: that of the grammar.
        forest: as for `compiled`.
        header: as for `compiled`.
        exact: the grammar with exact percentages.
        others: [m] what the density of the grammar is multiplied by, by an acceptance rule.
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
