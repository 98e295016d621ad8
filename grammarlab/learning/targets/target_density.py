"""Target densities: a predicted density, and simple functions near it as densities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints
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
from grammarlab.learning.targets.simplification import NEGLIGIBLE_JS, REST, SMALL_SHARES, TOLERANCE, simpler
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
    liked: Forest | None = None
    """Models that the person likes, which no file may leave out; None if there are none."""

    @classmethod
    def of(
        cls,
        target: Target,
        columns: GrammarColumns,
        pool_designs: PoolDesigns[Forest],
        scores: Floats,
        liked: Forest | None = None,
    ) -> PoolDensity:
        ratio = 1.0 if target.even is None else np.concatenate([target.even.ratio(f) for f in pool_designs.batches])
        return cls(target, columns, pool_designs, scores, pool_designs.weights * ratio, liked)

    def keeps_liked(self, exact: LearnedGrammar, trimmed: LearnedGrammar) -> bool:
        """Whether a grammar without some branches makes all liked models that the exact one makes."""
        if self.liked is None:
            return True
        return bool((trimmed.ratio(self.liked)[exact.ratio(self.liked) > 0.0] > 0.0).all())

    def column_sets(self, exact_only: bool) -> list[Ints]:
        """Columns for functions: those that matter to the preference, if there are any, then all."""
        order, relevant = self.columns.order, self.columns.relevant
        if exact_only:
            order, relevant = (columns[self.columns.exact[columns]] for columns in (order, relevant))
        return [relevant, order] if 0 < len(relevant) < len(order) else [order]

    def simple(self, columns: Ints, max_leaves: int = MAX_LEAVES) -> Iterator[Simple]:
        """Simple functions of some columns from `simpler`, without those whose text is too long."""
        for simplified in simpler(self.columns.rows, self.scores, self.weights, columns, max_leaves):
            if len(self.columns.text(simplified.preference)) <= MAX_TEXT:
                yield Simple(simplified.preference, simplified.js, self.as_target(simplified.preference))

    def simplest(self, exact_only: bool) -> Simple:
        """The first function that is near enough, of columns that matter if possible; if none is, the nearest one.

        It has fewer leaves if all texts are too long.
        """
        sizes = tuple(MAX_LEAVES >> halved for halved in range(MAX_LEAVES.bit_length()))
        first = [
            next(simple for size in sizes for simple in self.simple(columns, size))
            for columns in self.column_sets(exact_only)
        ]
        return next((simple for simple in first if simple.js <= TOLERANCE), min(first, key=lambda simple: simple.js))

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


def rules_if_few(learned: LearnedGrammar, most: int) -> int | None:
    """Number of branches of all rules of a grammar, or of the changed rules only if these have more than a limit.

    The others are known after parsing only, which takes long. None if the text is too large for a rule file.
    """
    if learned.rules_changed > most:
        return learned.rules_changed
    try:
        return learned.rules_after
    except LanguageError as error:
        if any(finding.code != "file-too-large" for finding in error.findings):
            raise
        return None


def rounded_off(
    density: PoolDensity, target: Target, forest: Forest, header: Sequence[str], exact: LearnedGrammar, others: Floats
) -> LearnedGrammar:
    """Grammar without rare branches that do not matter, with the roundest percentages that hardly change its density.

    For the base uniform it is unchanged.

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
    batches, weights = density.pool_designs.batches, density.pool_designs.weights

    def ratio_of(grammar: LearnedGrammar) -> Floats:
        return others * np.concatenate([grammar.ratio(models) for models in batches])

    best, ratio, min_share = exact, ratio_of(exact), 0.0
    most = agreement(density.scores, ratio, weights).js + REST
    for share in SMALL_SHARES:
        trimmed = target.compiled(forest, header, min_share=share)
        if trimmed.text == best.text:
            break  # so are those of the smaller shares
        trimmed_ratio = ratio_of(trimmed)
        change, loss = (agreement(before, trimmed_ratio, weights).js for before in (ratio, density.scores))
        if change <= REST and loss <= most and density.keeps_liked(exact, trimmed):
            best, ratio, min_share = trimmed, trimmed_ratio, share
            break
    for step in _PERCENTAGE_STEPS:
        rounded = target.compiled(forest, header, step=step, min_share=min_share)
        rounded_ratio = ratio_of(rounded)
        moved = agreement(ratio, rounded_ratio, weights).js
        if moved <= NEGLIGIBLE_JS and agreement(density.scores, rounded_ratio, weights).js <= most:
            return rounded
    return best
