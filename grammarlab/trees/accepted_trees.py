"""Accepted trees of a species, and the density of the trees that it draws.

The acceptance rule of a species is an expression (`grammarlab.features.expression`) over its parameters and over
measures of a tree, ``choose($slenderness < 90, 1, 0.1)``. Its value, clipped to 0 to 1, is the probability with which a
tree is kept; a rejected one is drawn again. So the density of a species is that of its kinds times this value.

An accepted tree is the first one kept of a sequence of candidates, each with its own key: that of the first is the key
of the tree itself, and the others lie below it. So a tree is the same alone and in any batch.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Flags, Floats, Ints
from grammarlab.errors import GrammarlabError
from grammarlab.features.columns.plain_columns import feature_values
from grammarlab.features.expression import Expression
from grammarlab.features.patterns.conditions import sites_of
from grammarlab.randomness import Keys, fold, uniforms
from grammarlab.trees.parameters import COLUMN, COLUMNS, IS_INTEGER, IS_LOG
from grammarlab.trees.species import Kind, Species, drawn
from grammarlab.trees.tree_values import check_names, parameters

MAX_USUAL_TRIES = 1_000
"""Largest number of candidates of one tree, if one of them has a probability above 0."""
MAX_TRIES = 20_000
"""Largest number of candidates of one tree if all have probability 0."""
_MAX_CANDIDATES_AT_ONCE = 2_048
"""Number of candidates that are drawn at once."""
_CANDIDATES, _DECISIONS = 0x4143_4345_5054, 0x4445_4349_4445
"""Lanes below the key of a tree for its other candidates, and for the decision about it."""
_MAX_STEMS_AT_ONCE = 200_000
"""Approximate number of stems of skeletons that are measured at once."""
_MAX_TREES_AT_ONCE = 512
"""Number of trees that are measured at once."""


class AcceptedTrees(NamedTuple):
    """Trees that a species keeps."""

    rows: Floats
    """[n, P] their parameters."""
    kind: Ints
    """[n] index of the kind of each."""
    tries: Ints
    """[n] number of candidates of each."""
    is_accepted: Flags
    """[n] False if no candidate was accepted; the tree is then the nearest one."""
    keys: Keys
    """[n] keys below which their stems are drawn."""


class TreeRule:
    """Acceptance rule of a species."""

    def __init__(self, text: str) -> None:
        """A rule.

        Args:
            text: the expression.

        Raises:
            UsageError: If it is not an expression over parameters and measures.
        """
        self.expression = Expression.parse(text)
        sites = {site for feature in self.expression.features for site in sites_of(feature)}
        self.measures = tuple(sorted(sites - set(COLUMN)))
        """Names of the measures that it reads: without any, no tree has to grow."""
        names = [*COLUMNS]
        if self.measures:
            from grammarlab.trees.measures import MEASURES  # noqa: PLC0415  # few rules read measures

            names += MEASURES
        check_names(self.expression.features, names)

    def probabilities(self, rows: Floats, keys: Keys, measures: Floats | None = None) -> Floats:
        """[n] probability, 0 to 1, with which trees are kept.

        Args:
            rows: [n, P] parameters.
            keys: [n] keys of the trees.
            measures: [n, M] their measures, if they are known.
        """
        columns = parameters(rows)
        if self.measures:
            from grammarlab.trees.measures import MEASURES  # noqa: PLC0415  # few rules read measures

            known = measured(rows, keys) if measures is None else measures
            columns |= dict(zip(MEASURES, known.T, strict=True))
        values = [feature_values(columns, feature) for feature in self.expression.features]
        table = np.column_stack([np.zeros((len(rows), 0)), *values])
        return np.clip(self.expression.evaluate(table), 0.0, 1.0)


@lru_cache(maxsize=64)
def rule_of(text: str) -> TreeRule | None:
    """The rule of a text; None for an empty one, which keeps all trees.

    Raises:
        UsageError: If it is not an expression over parameters and measures.
    """
    return TreeRule(text) if text.strip() else None


def accepted_rows(species: Species, keys: Keys, enough_tries: int = MAX_USUAL_TRIES) -> AcceptedTrees:
    """The trees of a species with some keys.

    Args:
        species: the species.
        keys: [n] keys of the trees.
        enough_tries: largest number of candidates of one tree, if one of them has a probability above 0.

    Raises:
        GrammarlabError: If the rule keeps none of many candidates of a tree.
        UsageError: If the rule is not an expression over parameters and measures.
    """
    rule = rule_of(species.acceptance)
    if rule is None or not len(keys):
        rows, kind = drawn(species, keys)
        ones = np.ones(len(keys), dtype=np.int64)
        return AcceptedTrees(rows, kind, ones, ones > 0, keys)
    search = _Search(species, rule, keys)
    waiting = search.run(np.arange(len(keys)), 0, enough_tries)
    hopeless = waiting[search.nearest[waiting] <= 0.0]
    # If the rule has kept no tree at all, fewer are tried for each of many.
    most = MAX_TRIES if search.nearest.any() else max(enough_tries, MAX_TRIES // len(keys))
    search.run(hopeless, enough_tries, most)
    if (search.nearest <= 0.0).any():
        raise GrammarlabError(
            f"the acceptance rule of {species.name or 'the species'} keeps none of {most:,} candidates of a tree: "
            "expected a rule that keeps about one tree in 1,000 or more. Learn the file again, or change its rule "
            f"{species.acceptance[:80]!r}"
        )
    number = search.number
    chosen = _candidate_keys(keys, number)
    rows, kind = drawn(species, chosen)
    return AcceptedTrees(rows, kind, np.where(search.is_accepted, number + 1, search.tries), search.is_accepted, chosen)


def measured(rows: Floats, keys: Keys) -> Floats:
    """[n, M] measures of trees (`grammarlab.trees.measures`), grown in parts that fit into memory.

    Args:
        rows: [n, P] parameters.
        keys: [n] keys of the trees.
    """
    from grammarlab.trees.growth import grow  # noqa: PLC0415  # trees grow only for rules that read measures
    from grammarlab.trees.measures import MEASURES, measure  # noqa: PLC0415

    parts = [np.zeros((0, len(MEASURES)))]
    parts += [measure(grow(rows[part], keys[part])) for part in _parts(rows)]
    return np.concatenate(parts)


def log_density(species: Species, rows: Floats) -> Floats:
    """[n] log of the density of rows of parameters [n, P] under the kinds of a species, without its acceptance rule.

    The density is by the number of whole numbers, by the length of ranges, and 1 for a column that is constant. Where
    one kind has a constant and another one a range of the same column, trees with this constant are of the first kind.
    """
    kinds = np.stack([_log_of_kind(kind, rows) for kind in species.kinds])
    shares = np.log([kind.weight for kind in species.kinds]) - np.log(sum(kind.weight for kind in species.kinds))
    # Constants count as infinitely dense: only kinds with the most of them can have drawn a tree.
    exact = np.stack([_num_constants(kind, species.kinds, rows) for kind in species.kinds])
    exact = np.where(np.isfinite(kinds), exact, -1)
    kinds = np.where(exact == exact.max(axis=0), kinds, -np.inf) + shares[:, None]
    with np.errstate(divide="ignore"):
        return np.logaddexp.reduce(kinds, axis=0)


def _num_constants(kind: Kind, kinds: Sequence[Kind], rows: Floats) -> Ints:
    """[n] number of continuous columns that are constant in a kind and not in all of them."""
    constant = np.array([np.asarray(other.low == other.high) for other in kinds])
    mixed = constant.any(axis=0) & ~constant.all(axis=0) & ~IS_INTEGER & (kind.low == kind.high)
    return np.full(len(rows), np.count_nonzero(mixed))


def _log_of_kind(kind: Kind, rows: Floats) -> Floats:
    varying = np.flatnonzero(kind.low < kind.high)
    inside = np.all((rows >= kind.low) & (rows <= kind.high), axis=1)
    total = np.zeros(len(rows))
    for column in varying.tolist():
        low, high, values = float(kind.low[column]), float(kind.high[column]), rows[inside, column]
        if IS_INTEGER[column] and not (IS_LOG[column] and low > 0.0):
            total[inside] -= np.log(high + 1.0 - low)
        elif IS_INTEGER[column]:
            total[inside] += np.log(np.log((values + 1.0) / values)) - np.log(np.log((high + 1.0) / low))
        elif IS_LOG[column] and low > 0.0:
            total[inside] -= np.log(values) + np.log(np.log(high / low))
        else:
            total[inside] -= np.log(high - low)
    return np.where(inside, total, -np.inf)


def _candidate_keys(keys: Keys, number: Ints) -> Keys:
    """[n] keys of the candidates of these numbers [n] of trees."""
    return np.where(number == 0, keys, fold(fold(keys, _CANDIDATES), number))


def _parts(rows: Floats) -> list[Ints]:
    """Indices of parts of trees with about `_MAX_STEMS_AT_ONCE` stems each."""
    stems, total = np.ones(len(rows)), np.ones(len(rows))
    for level in range(1, 4):
        stems = stems * rows[:, COLUMN[f"branches_{level}"]] * (rows[:, COLUMN["levels"]] > level)
        total += stems
    part = np.floor(np.cumsum(np.minimum(total, _MAX_STEMS_AT_ONCE)) / _MAX_STEMS_AT_ONCE)
    part = np.maximum.accumulate(part + np.arange(len(rows)) // _MAX_TREES_AT_ONCE)
    return [np.flatnonzero(part == number) for number in np.unique(part).tolist()]


class _Search:
    """Search for accepted candidates."""

    def __init__(self, species: Species, rule: TreeRule, keys: Keys) -> None:
        self.species, self.rule, self.keys = species, rule, keys
        self.number = np.zeros(len(keys), dtype=np.int64)
        """Number of the accepted candidate of each tree, or of the nearest one."""
        self.tries = np.zeros(len(keys), dtype=np.int64)
        self.is_accepted = np.zeros(len(keys), dtype=bool)
        self.nearest = np.zeros(len(keys))
        """Probability of the nearest candidate, divided by its draw."""

    def run(self, waiting: Ints, first: int, end: int) -> Ints:
        """Try candidates ``first`` to ``end`` - 1 of trees; those without an accepted one."""
        num = 1
        while len(waiting) and first < end:
            num = min(num, end - first)
            for trees in np.array_split(waiting, -(-len(waiting) * num // _MAX_CANDIDATES_AT_ONCE)):
                self._try(trees, first, num)
            waiting = waiting[~self.is_accepted[waiting]]
            first += num
            self.tries[waiting] = first
            # The number doubles each time, as long as the candidates of a round fit into a few chunks.
            num = max(1, min(2 * num, _MAX_CANDIDATES_AT_ONCE // max(1, len(waiting))))
        return waiting

    def _try(self, trees: Ints, first: int, num: int) -> None:
        tree, number = np.tile(trees, num), np.repeat(np.arange(first, first + num), len(trees))
        keys = _candidate_keys(self.keys[tree], number)
        chances = self.rule.probabilities(drawn(self.species, keys)[0], keys)
        draws = uniforms(fold(keys, _DECISIONS), 0)
        chosen = np.flatnonzero(draws < chances)
        _, index = np.unique(tree[chosen], return_index=True)
        chosen = chosen[index]
        self.is_accepted[tree[chosen]] = True
        self._note(tree, number, chances / np.maximum(draws, 1e-300))
        self.number[tree[chosen]] = number[chosen]

    def _note(self, tree: Ints, number: Ints, near: Floats) -> None:
        """Record the candidates with the highest probability; of equal ones the first."""
        order = np.lexsort((number, -near, tree))
        best = order[np.unique(tree[order], return_index=True)[1]]
        better = best[near[best] > self.nearest[tree[best]]]
        self.nearest[tree[better]] = near[better]
        self.number[tree[better]] = number[better]
