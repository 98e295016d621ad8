"""From a preference learned on trees to a species file: kinds with narrower ranges, and an acceptance rule.

If a function of parameters is near enough to the predictions, the learned species has its kinds, which sample it
exactly. What depends on measures no ranges can say: then an acceptance rule says it, and the kinds have the ranges in
which anything is liked, so that many candidates are kept.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from grammarlab.arrays import Floats, Ints
from grammarlab.asset_roots import AssetRoot
from grammarlab.density.exact.splitting import Base
from grammarlab.density.targets.rejection import Progress, silent
from grammarlab.errors import UsageError
from grammarlab.features.patterns.pattern import Draw, Feature
from grammarlab.learning.designs.design_tables import DesignTable
from grammarlab.learning.designs.species_space import SpeciesSpace
from grammarlab.learning.designs.tree_columns import TreeBatch, columns_of, words_of_name
from grammarlab.learning.round import State, Study
from grammarlab.learning.targets.distance_words import divergence_share
from grammarlab.learning.targets.file_head import head
from grammarlab.learning.targets.kinds_of_trees import Part, divisible, parts_of, with_parts
from grammarlab.learning.targets.simplification import (
    MIN_LEAF,
    TOLERANCE,
    Predicted,
    Simplified,
    predict,
    simplified,
    smallest,
)
from grammarlab.learning.targets.target_density import MAX_LEAVES
from grammarlab.learning.targets.tree_conditions import rule_text
from grammarlab.learning.targets.writers import AbstractTargetWriter, LearnedDensity, Making, judged
from grammarlab.preference.blended import BlendedPreference
from grammarlab.preference.growth.splits import Value
from grammarlab.preference.held_out_share import NUM_FOLDS
from grammarlab.preference.regression_tree import Split, grow, leaves_of
from grammarlab.preference.simplified import SimplifiedPreference
from grammarlab.scene.instances import Scene
from grammarlab.trees.accepted_trees import MAX_USUAL_TRIES, log_density, rule_of
from grammarlab.trees.parameters import COLUMN
from grammarlab.trees.species import Species
from grammarlab.trees.species_file import parse, write

METHODS = ("kinds", "acceptance")
"""Methods: kinds, with an acceptance rule where needed, or the original kinds with an acceptance rule only."""
_MAX_KINDS = 16
"""Usual largest number of kinds, unless the original has half as many."""
_MAX_KINDS_JS = 0.01
"""Largest divergence in nats from the predictions for kinds without a rule: they may use a measure where a parameter
says nearly the same, and a file that rejects no tree is worth more than the difference."""
_MAX_LOST = 0.02
"""Largest share of the liked designs outside of the kinds, on designs that these were not chosen by."""
_MIN_RATE_GAIN = 1.15
"""Smallest factor of the acceptance rate by which a further kind pays."""
_NUM_DIGITS = 4
"""Number of digits of bounds of cells, which lie anywhere between two scored trees."""


@dataclass(frozen=True)
class LearnedSpecies:
    """A learned species."""

    text: str
    method: str
    base: Base
    before: Species
    accept_rate: float | None
    """Share of candidates that the rule keeps, of the pool; None without a rule."""
    findings: tuple[str, ...]
    assets: AssetRoot | None = None

    @cached_property
    def space(self) -> SpeciesSpace:
        """Its trees."""
        return SpeciesSpace(parse(self.text, self.before.name), self.text, self.assets)

    @property
    def rules_before(self) -> int:
        return len(self.before.kinds)

    @property
    def units(self) -> tuple[str, str]:
        return "kind", "kinds"

    @property
    def rules_after(self) -> int:
        return len(self.space.species.kinds)

    def ratio(self, designs: TreeBatch, /) -> Floats:
        species = self.space.species
        ratio = np.exp(log_density(species, designs.rows) - log_density(self.before, designs.rows))
        after, before = (
            np.ones(len(designs))
            if (rule := rule_of(one.acceptance)) is None
            else rule.probabilities(designs.rows, designs.keys, designs.measures)
            for one in (species, self.before)
        )
        return ratio * np.divide(after, before, out=np.zeros(len(designs)), where=before > 0.0)

    def scene(self, num: int, seed: int, /) -> Scene:
        return self.space.scene(num, seed)


class _Pool(NamedTuple):
    """Predictions for the trees of a pool."""

    species: Species
    names: tuple[str, ...]
    """[F] names of columns: parameters first, then measures, each most relevant first."""
    rows: Floats
    """[m, F] their values."""
    scores: Floats
    """[m] >= 0, at least one above 0."""
    weights: Floats
    """[m] importance weights."""
    cells: tuple[Split, ...]
    """Splits of the most likely cells; () for preferences without cells, or with several factors."""

    @property
    def exact(self) -> Ints:
        """Columns whose ranges can be divided."""
        is_divisible = divisible(self.species)
        return np.array(
            [i for i, name in enumerate(self.names) if name in COLUMN and is_divisible[COLUMN[name]]], dtype=np.int64
        )

    def parts(self, preference: SimplifiedPreference) -> list[Part]:
        """The parts of the species with scores above 0."""
        return parts_of(self.species, preference, self.names)


@dataclass(frozen=True)
class SpeciesWriter(AbstractTargetWriter[TreeBatch]):
    """Makes species from preferences learned on a species."""

    space: SpeciesSpace

    @property
    def methods(self) -> tuple[str, ...]:
        return METHODS

    def learn(
        self,
        study: Study[TreeBatch],
        state: State,
        making: Making,
        lines: Sequence[str] = (),
        on_progress: Progress = silent,
    ) -> LearnedDensity[TreeBatch]:
        method = self.method(making.method)
        if making.base == "uniform":
            raise UsageError(
                "base uniform: trees of a species cannot all be equally likely, since their columns have "
                "scales of their own; use the base grammar, or widen the ranges of the species."
            )
        predicted = predict(study, state)
        pool = _pool_of(self.space, study, state, predicted)
        most = making.max_rules or max(_MAX_KINDS, 2 * len(self.space.species.kinds))
        result = _kinds_only(pool, most) if method == METHODS[0] else None
        result = result or _with_rule(pool, most if method == METHODS[0] else 0)
        header = [*head(lines, predicted, study.pool.seed), f"Method {method}, base {making.base}"]
        text = "".join(f"# {line}".rstrip() + "\n" for line in header) + "\n" + write(result.species)
        learned = LearnedSpecies(
            text=text,
            method=method,
            base=making.base,
            before=self.space.species,
            accept_rate=result.accept_rate,
            findings=result.findings,
            assets=self.space.assets,
        )
        features: dict[Feature, str] = {
            Draw(pool.names[column]): words_of_name(pool.names[column]) for column in result.columns.tolist()
        }
        return judged(study, state, learned, predicted, result.scores, features)


class _Result(NamedTuple):
    species: Species
    scores: Floats
    """[m] scores of the pool that the species follows."""
    columns: Ints
    """Columns that it reads."""
    accept_rate: float | None = None
    findings: tuple[str, ...] = ()


def _pool_of(space: SpeciesSpace, study: Study[TreeBatch], state: State, predicted: Predicted) -> _Pool:
    pool_designs = study.tables(state.wide).pool_designs
    table = study.table(state)
    share_of = {
        feature.site: share
        for feature, share in zip(table.features, predicted.shares.tolist(), strict=True)
        if isinstance(feature, Draw)
    }
    columns = columns_of(pool_designs.batches, space.names)
    names = [name for name in space.names if np.ptp(columns[name]) > 0.0]
    names.sort(key=lambda name: (name not in COLUMN, -share_of.get(name, 0.0)))
    rows = np.column_stack([np.zeros((len(predicted.scores), 0)), *(columns[name] for name in names)])
    cells = tuple(_splits_of_cells(table, state, names))
    return _Pool(space.species, tuple(names), rows, predicted.scores, pool_designs.weights, cells)


def _splits_of_cells(table: DesignTable, state: State, names: Sequence[str]) -> Iterator[Split]:
    """The splits of the most likely tree of the only liked factor, in the units of its columns."""
    preference = state.preferences[state.liked[0]] if len(state.liked) == 1 else None
    if not isinstance(preference, BlendedPreference):
        return
    number = 0
    waiting = [(preference.partition.trees[0], 0)]
    while waiting:
        node, leaf = waiting.pop()
        reading = None if node.split is None else node.split.reading
        # What is read otherwise, and further columns, end the tree.
        if node.split is None or not isinstance(reading, Value) or reading.column >= len(table.features):
            continue
        feature, leaves = table.features[reading.column], [leaf]
        if not isinstance(feature, Draw) or feature.site not in names:
            continue
        for bound in np.array(node.split.bounds) * float(table.scales[reading.column]):
            plain = np.exp(bound) if table.logarithmic is not None and table.logarithmic[reading.column] else bound
            number += 1
            yield Split(leaves[-1], names.index(feature.site), float(f"{plain:.{_NUM_DIGITS}g}"))
            leaves.append(number)
        waiting += [(branch, leaves[part]) for part, branch in node.parts]


def _simple(pool: _Pool, columns: Ints) -> Simplified:
    """The smallest function of some columns that is near enough: a regression tree, or the cells if these are nearer.

    The tree of a conjunction of many bounds follows few liked trees of a pool, and cells follow the scores.
    """
    tree = smallest(pool.rows, pool.scores, pool.weights, columns, MAX_LEAVES)
    if tree.js <= TOLERANCE or not pool.cells or not {split.column for split in pool.cells} <= set(columns.tolist()):
        return tree
    cells = simplified(pool.rows, pool.scores, pool.weights, pool.cells)
    return cells if cells.js < tree.js else tree


def _kinds_only(pool: _Pool, most: int) -> _Result | None:
    """The species that follows the predictions by kinds only; None if parameters do not explain them."""
    simple = _simple(pool, pool.exact)
    parts = pool.parts(simple.preference)
    if simple.js > _MAX_KINDS_JS or not 0 < len(parts) <= most:
        return None
    return _Result(with_parts(pool.species, parts), simple.preference(pool.rows), simple.preference.columns)


def _with_rule(pool: _Pool, most: int) -> _Result:
    """The species of kinds in which anything is liked, with an acceptance rule for the rest."""
    simple = _simple(pool, np.arange(len(pool.names)))
    values, highest = simple.preference(pool.rows), max(simple.preference.levels)
    region = _region(pool, values, most)
    parts = pool.parts(region)
    inside = pool.weights * region(pool.rows)
    rate = float(inside @ values / highest / inside.sum())
    rule = rule_text(simple.preference.scaled(1.0 / highest), pool.names)
    if pool.species.acceptance:
        rule = f"({pool.species.acceptance}) * ({rule})"
    findings = [
        f"no ranges of parameters alone say it, so the file keeps {rate:.2g} of its trees by an acceptance rule"
    ]
    if rate * MAX_USUAL_TRIES < 1.0:
        findings.append("this is slow, and may fail for some trees: more scores of liked trees narrow the ranges")
    if simple.js > TOLERANCE:
        findings.append(
            f"the predictions need more columns: without them the file differs by {divergence_share(simple.js)} from "
            "what was learned, which more scores may mend"
        )
    species = replace(with_parts(pool.species, parts), acceptance=rule)
    columns = np.union1d(simple.preference.columns, region.columns)
    return _Result(species, values * region(pool.rows), columns, min(rate, 1.0), tuple(findings))


def _region(pool: _Pool, values: Floats, most: int) -> SimplifiedPreference:
    """1 where a function of parameters says that something may be liked, otherwise 0.

    Trees grow on two thirds of the pool; the other third shows how much of what is liked a region would lose.

    Args:
        pool: the pool.
        values: [m] what is liked.
        most: largest number of kinds.
    """
    everywhere = SimplifiedPreference((), np.ones(1))
    liked = (values > 0.0).astype(np.float64)
    is_held_out = np.arange(len(liked)) % NUM_FOLDS == 0
    rows, weights = pool.rows[~is_held_out], pool.weights[~is_held_out]
    share = liked[~is_held_out] / max(float(weights @ liked[~is_held_out] / max(weights.sum(), 1e-300)), 1e-300)
    tree = grow(rows, liked[~is_held_out], weights * (1.0 + share), pool.exact, MAX_LEAVES, MIN_LEAF)
    best, worth = everywhere, 1.0
    lost_weights = (pool.weights * values)[is_held_out]
    for size in range(1, len(tree) + 1):
        leaf = leaves_of(tree[:size], rows)
        region = SimplifiedPreference(
            tree[:size], (np.bincount(leaf, liked[~is_held_out], size + 1) > 0.0).astype(np.float64)
        )
        lost = 1.0 - float(lost_weights @ region(pool.rows[is_held_out])) / max(float(lost_weights.sum()), 1e-300)
        if lost > _MAX_LOST:
            continue
        num, covered = len(pool.parts(region)), float(pool.weights @ region(pool.rows) / pool.weights.sum())
        gain = 1.0 / covered / _MIN_RATE_GAIN ** max(num - len(pool.species.kinds), 0)
        if 0 < num <= most and gain > worth:
            best, worth = region, gain
    return best
