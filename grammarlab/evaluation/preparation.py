"""From a scenario and its grammar to the material of the protocol.

The labelled set is derived at the scenario's own seed. The pool is derived at seeds that follow from it: samples
of the grammar and samples of the flattened grammar, since what is rare in the grammar would otherwise never be asked
about. Models are derived in chunks and dropped as soon as their features are counted.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from grammarlab import __version__
from grammarlab.derivation.compiler import compile_grammar
from grammarlab.derivation.derive import derive, derive_chunks
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.lots import Lots
from grammarlab.derivation.program import Program
from grammarlab.derivation.selection import join_forests, select_models
from grammarlab.errors import UsageError
from grammarlab.evaluation.flattening import Flattened, flattened
from grammarlab.evaluation.material import Bound, Columns, Ints, Material, Table
from grammarlab.evaluation.pool import pool_log_weights, pool_seeds, pool_sizes
from grammarlab.evaluation.scenario import FAMILIES, FeatureOptions, Scenario
from grammarlab.features.counting import count
from grammarlab.features.pattern import Feature
from grammarlab.features.stripping import without_geometry
from grammarlab.features.thresholds import margins
from grammarlab.features.vocabulary import Options, Vocabulary
from grammarlab.language.grammar import Grammar

Floats = NDArray[np.float64]
Arrays: TypeAlias = Mapping[str, NDArray]

_MOST_EXAMPLES = 4096
"""Derived models of the pool that are kept for later questions."""


@dataclass(frozen=True, slots=True)
class Source:
    """A scenario with what it takes to derive its models."""

    scenario: Scenario
    grammar: Grammar
    assets: Path
    """The folder that asset names in the rules are relative to."""
    families: tuple[str, ...] = FAMILIES
    """Kinds of features to count; where it is all there are, those that the scenario names."""
    wide: bool = False
    """Whether the pool is widened for rare models."""

    @property
    def feature_options(self) -> FeatureOptions:
        """What a learner looks at."""
        offered = self.scenario.features
        return offered if self.families == FAMILIES else replace(offered, families=self.families)

    @property
    def pool_sizes(self) -> tuple[int, int]:
        """How many models of the pool are samples of the grammar, and how many of the flattened grammar."""
        return pool_sizes(self.scenario.num_models, self.wide)

    @property
    def key(self) -> str:
        """SHA-256 of everything that decides the models and their scores."""
        preference = [(factor.name, factor.score) for factor in self.scenario.factors]
        return _digest(self.models, self.scenario.base, preference)

    @property
    def models(self) -> tuple[object, ...]:
        """Everything that decides which models there are."""
        scenario = self.scenario
        return (self.grammar.hash, scenario.num_models, scenario.seed, scenario.draws, self.pool_sizes)


def _digest(*values: object) -> str:
    return hashlib.sha256(repr((__version__, *values)).encode()).hexdigest()


Keep: TypeAlias = Callable[[str, Callable[[], Arrays]], Arrays]
"""Gives what was made for a key before, or else makes it and remembers it."""


def make_always(_key: str, make: Callable[[], Arrays]) -> Arrays:
    """Remembers nothing."""
    return make()


def prepare(source: Source, keep: Keep = make_always) -> Material:
    """The material of a scenario.

    Args:
        source: the scenario and its grammar.
        keep: may remember arrays between calls; keys change whenever what they stand for may change.

    Raises:
        UsageError: the preference does not fit the grammar, or no model of the labelled set is liked.
        DerivationError: a rule cannot be carried out.
    """
    arrays = keep(f"truth-{source.key}", lambda: _scores(source))
    factors = tuple(factor.name for factor in source.scenario.factors)
    tables = _Tables(source, keep)
    material = Material(
        factors,
        arrays["scores"],
        arrays["weights"],
        arrays["pool_scores"],
        arrays["pool_weights"],
        np.arange(sum(source.pool_sizes)) < source.pool_sizes[0],
        tables.table,
        tables.examples,
        tables.margins,
        None if source.wide else lru_cache(maxsize=1)(lambda: prepare(replace(source, wide=True), keep)),
    )
    if not (material.weights * material.target).any():
        raise UsageError(
            f"scenario {source.scenario.name}: none of its {source.scenario.num_models:,} labelled models has a score "
            'above 0, so there is no density to learn. Raise num_models, or set draws = "flattened".'
        )
    return material


def labelled_program(source: Source) -> Program:
    """What model i of the labelled set is derived from, under the address (scenario's seed, i)."""
    flat = source.scenario.draws == "flattened"
    return flattened(source.grammar).program if flat else compile_grammar(source.grammar)


def _scores(source: Source) -> Arrays:
    scenario = source.scenario
    flat = flattened(source.grammar)
    features = [factor.score.features for factor in scenario.factors]

    def score(forest: Forest) -> Floats:
        return np.column_stack(
            [
                factor.score.evaluate(count(forest, columns))
                for factor, columns in zip(scenario.factors, features, strict=True)
            ]
        )

    program = flat.program
    scenario.check(program.symbols, program.rule_names, program.sites)
    labelled = [(score(forest), _log_weight(scenario, flat, forest)) for forest in _labelled(source)]
    log_weights = np.concatenate([weights for _, weights in labelled])
    pool = [(score(forest), flat.log_ratio(forest)) for forest in _pool(source, flat)]
    ratios = np.concatenate([ratio for _, ratio in pool])
    return {
        "scores": np.concatenate([values for values, _ in labelled]),
        "weights": np.exp(log_weights - log_weights.max()),
        "pool_scores": np.concatenate([values for values, _ in pool]),
        "pool_weights": np.exp(pool_log_weights(ratios, source.pool_sizes)),
    }


def _log_weight(scenario: Scenario, flat: Flattened, forest: Forest) -> Floats:
    """[models] log of the density that the preference multiplies over the density the models are drawn from."""
    if scenario.base == "uniform":
        return -forest.log_probability()
    return flat.log_ratio(forest) if scenario.draws == "flattened" else np.zeros(forest.num_models)


def _labelled(source: Source) -> Iterator[Forest]:
    scenario = source.scenario
    yield from derive_chunks(labelled_program(source), scenario.num_models, scenario.seed, assets=source.assets)


def _pool(source: Source, flat: Flattened) -> Iterator[Forest]:
    yield from pool_models(source.grammar, flat, source.pool_sizes, source.scenario.seed, source.assets)


def pool_models(
    grammar: Grammar,
    flat: Flattened,
    sizes: tuple[int, int],
    seed: int,
    assets: Path | None,
    known: tuple[int, int] = (0, 0),
) -> Iterator[Forest]:
    """The models of a pool.

    Args:
        grammar: the grammar.
        flat: the same flattened.
        sizes: how many models of each.
        seed: 0 <= seed < 2**64, that the seeds of both parts follow from.
        assets: folder of meshes and images.
        known: how many models of each are left out, from the first.
    """
    programs = compile_grammar(grammar), flat.program
    for program, size, first, of_part in zip(programs, sizes, known, pool_seeds(seed), strict=True):
        yield from derive_chunks(program, size - first, of_part, first_model=first, assets=assets)


def pool_address(source: Source, index: int) -> tuple[bool, int, int]:
    """Of a model of the pool: whether it is from the flattened grammar, its seed, and its index under that seed."""
    from_grammar = source.pool_sizes[0]
    flat = index >= from_grammar
    return flat, pool_seeds(source.scenario.seed)[flat], index - from_grammar if flat else index


class _Tables:
    """Features of all models, worked out when they are first asked for."""

    def __init__(self, source: Source, keep: Keep) -> None:
        self._source = source
        self._keep = keep
        self._base = lru_cache(maxsize=4)(self._count_base)
        self._extra = lru_cache(maxsize=64)(self._count_extra)
        self._latest = lru_cache(maxsize=2)(self._join)
        self._examples: dict[int, Forest] = {}

    def table(self, columns: Columns) -> Table:
        return self._latest(columns)

    def examples(self, indices: Ints) -> tuple[Forest, ...]:
        wanted = [int(index) for index in indices]
        self._examples |= self._derive([index for index in wanted if index not in self._examples])
        found = [self._examples[index] for index in wanted]
        for index in list(self._examples)[:-_MOST_EXAMPLES]:
            del self._examples[index]
        return (join_forests(found),) if found else ()

    def margins(self, bound: Bound) -> Floats:
        return margins(self._forests[1], bound)

    def _join(self, columns: Columns) -> Table:
        base = self._base(columns.path_length)
        if not columns.extra:
            return base
        parts = [self._extra(feature) for feature in columns.extra]
        first = len(base.group_names)
        return Table(
            np.column_stack([base.labelled, *(labelled for labelled, _ in parts)]),
            np.column_stack([base.pool, *(pool for _, pool in parts)]),
            np.append(base.groups, np.arange(first, first + len(parts))),
            (*base.group_names, *(str(feature) for feature in columns.extra)),
        )

    def _count_base(self, length: int) -> Table:
        options = options_of(self._source.feature_options, length)
        key = f"table-{_digest(self._source.models, options)}"
        arrays = self._keep(key, lambda: _count(self._source, options))
        return Table(arrays["labelled"], arrays["pool"], arrays["groups"], tuple(arrays["group_names"].tolist()))

    def _count_extra(self, feature: Feature) -> tuple[Floats, Floats]:
        """[n] and [m] the feature of the labelled models and of the pool."""
        labelled, pool = (np.concatenate([count(f, [feature])[:, 0] for f in forests]) for forests in self._forests)
        return labelled, pool

    @cached_property
    def _forests(self) -> tuple[list[Forest], list[Forest]]:
        """The labelled set and the pool."""
        flat = flattened(self._source.grammar)
        labelled = [without_geometry(forest) for forest in _labelled(self._source)]
        return labelled, [without_geometry(forest) for forest in _pool(self._source, flat)]

    @cached_property
    def _programs(self) -> tuple[Program, Program]:
        return compile_grammar(self._source.grammar), flattened(self._source.grammar).program

    def _derive(self, indices: Sequence[int]) -> dict[int, Forest]:
        """Models of the pool, each as a forest of its own; those of one grammar are derived together."""
        addresses = {index: pool_address(self._source, index) for index in indices}
        found: dict[int, Forest] = {}
        for program, flat in zip(self._programs, (False, True), strict=True):
            chosen = [index for index in indices if addresses[index][0] == flat]
            lots = Lots.at([addresses[index][1] for index in chosen], [addresses[index][2] for index in chosen])
            forest = without_geometry(derive(program, lots, assets=self._source.assets))
            found |= {index: select_models(forest, np.array([row])) for row, index in enumerate(chosen)}
        return found


def options_of(features: FeatureOptions, length: int) -> Options:
    """Which columns there are for paths of some length, without those that are searched for."""
    families = features.families
    return Options(
        length,
        symbols="symbols" in families,
        draws="draws" in families,
        far_pairs="skips" in families,
        adjacent_pairs="siblings" in families,
    )


def _count(source: Source, options: Options) -> Arrays:
    """The rows of all models; the columns are those that tell models of the pool apart, since labels say nothing."""
    flat = flattened(source.grammar)
    pool = [without_geometry(forest) for forest in _pool(source, flat)]
    vocabulary = Vocabulary.find(pool, options)
    table = vocabulary.apply(pool)
    labelled = [vocabulary.apply(forest).rows() for forest in _labelled(source)]
    return {
        "labelled": np.concatenate(labelled),
        "pool": table.rows(),
        "groups": table.groups,
        "group_names": np.array(table.group_names),
    }
