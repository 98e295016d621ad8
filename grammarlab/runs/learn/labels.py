"""From labels to a learned grammar on disk: fit, simplify, compile, and say what each step did to the density."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from grammarlab.density import sampled
from grammarlab.density.exactness import Exactness
from grammarlab.density.learned import LearnedGrammar
from grammarlab.density.skeleton import ENOUGH_MODELS
from grammarlab.density.splitting import Base
from grammarlab.density.target import Target
from grammarlab.density.thinning import Progress, silent
from grammarlab.derivation.derive import derive
from grammarlab.errors import GrammarlabError
from grammarlab.evaluation.agreement import agreement
from grammarlab.evaluation.scenario import FeatureOptions
from grammarlab.features.pattern import Feature
from grammarlab.preference.base import MAX_SCORE, Relevance
from grammarlab.runs.derive_batch import compiled
from grammarlab.runs.examples import RuleSource, find_rules
from grammarlab.runs.learn.factors import LearnedFactor, Tables, answers_of, learn_factor, tables_of
from grammarlab.runs.learn.labelled_models import labelled_models
from grammarlab.runs.learn.measure import Learned, Measured, Truth, measured
from grammarlab.runs.learn.pool import Pool
from grammarlab.runs.learn.scenario import check_method, learn_target, origin_line, scenario_of, write_learned
from grammarlab.runs.scoring.labels import read_labels_or_session
from grammarlab.runs.workers import one_thread

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FEATURES = FeatureOptions(2, ("paths", "symbols", "thresholds"))
"""What is looked at unless somebody asks for something else."""


@dataclass(frozen=True, slots=True)
class Step:
    """What one step on the way to the grammar did to the density."""

    name: str
    js: float
    """Divergence in nats between the density before it and after it, on the pool."""


@dataclass(frozen=True)
class LabelsResult:
    """A grammar learned from labels, and what was learned."""

    learned: Learned
    file: Path | None
    """The new rule file; None where the method makes no grammar."""
    labels: Path
    source: RuleSource
    num_labels: int
    target: Target
    """The density that was learned, as a function of few features."""
    factors: tuple[LearnedFactor, ...]
    features: tuple[Feature, ...]
    """What the preference reads in the end: the relevant features."""
    feature_names: tuple[str, ...]
    """The same in words."""
    steps: tuple[Step, ...]
    measured: Measured
    """Beside the predicted density, on the pool."""
    seconds: float
    """From the label file to the text of the grammar."""
    truth: Truth | None = None
    """How near it comes to what a simulated person really wanted, where that is known."""

    @property
    def relevances(self) -> tuple[Relevance, ...]:
        """What the preference looks at, most relevant first; where there are several factors, each with its name."""
        several = len(self.factors) > 1
        found = [
            Relevance(f"{factor.name}: {entry.name}" if several else entry.name, entry.share, entry.level)
            for factor in self.factors
            for entry in factor.relevances
            if entry.level != "none"
        ]
        return tuple(sorted(found, key=lambda entry: -entry.share))


def learn_from_labels(
    grammar: str,
    labels: Path,
    file: Path,
    *,
    method: str = "compile",
    base: Base = "grammar",
    num_samples: int = sampled.NUM_SAMPLES,
    features: FeatureOptions | None = None,
    seed: int = 0,
    scenario: Path | None = None,
    on_progress: Progress = silent,
) -> LabelsResult:
    """Learns the grammar that samples in proportion to the scores of a label file.

    Args:
        grammar: a rule file or the name of a shipped grammar: that of the labels.
        labels: a label file (`grammarlab.preference.label_files`), or a session file (.db).
        file: where to write the new rule file; assets that it names are put beside it.
        method: of `grammarlab.runs.learn.scenario.METHODS`: how the grammar is made of what was learned.
        base: what the preference multiplies.
        num_samples: models to learn from, for the methods that need them.
        features: what may be relevant; by default what the scenario says, or else `FEATURES`.
        seed: of the fit, and of the models that the preference is looked at on.
        scenario: a scenario file to compare the result with; nothing is learned from it.
        on_progress: told about models to learn from, for the methods that need them.

    Raises:
        UsageError: for labels of another grammar, or labels that like nothing.
        AssetError: for a label file that cannot be read.
        GrammarlabError: when the density cannot be made.
    """
    check_method(method)
    begun = perf_counter()
    table = read_labels_or_session(labels)
    source = find_rules(grammar)
    parsed, program = compiled(source.text(), source.name)
    known = None if scenario is None else scenario_of(scenario, grammar, parsed)
    features = features or (FEATURES if known is None else known.feature_options)
    labelled = labelled_models(table, parsed, source.assets)
    answers = answers_of(table, labelled)
    pool = Pool.of(parsed, source.assets, seed)
    forest = derive(program, ENOUGH_MODELS, seed, assets=source.assets)
    exactness = Exactness(parsed, forest)
    tables = tables_of(labelled, pool, answers, features, lambda feature: not exactness.reason_against(feature))
    with one_thread():
        factors = tuple(learn_factor(factor, tables, pool.weights, seed=seed) for factor in answers)
        preference = _Product.of(factors, tables)
        target = Target(parsed, preference.reads, preference, base, preference.bound, source.assets)
        lines = [origin_line(source.name, parsed), f"Labels {labels.name}: {len(table)} scores"]
        learned = learn_target(target, method, forest, lines, seed, num_samples, on_progress)
    seconds = perf_counter() - begun
    if isinstance(learned, LearnedGrammar):
        write_learned(file, learned, source.assets)
    steps, found = _judged(learned, target, preference, tables, pool)
    return LabelsResult(
        learned,
        file if isinstance(learned, LearnedGrammar) else None,
        labels,
        source,
        len(table),
        target,
        factors,
        preference.reads,
        tuple(tables.pool.names[column] for column in preference.columns),
        steps,
        found,
        seconds,
        None if known is None else Truth.of(known, learned),
    )


@dataclass(frozen=True)
class _Product:
    """All factors together, as a function of the features that they need."""

    factors: tuple[LearnedFactor, ...]
    columns: Ints
    """[K] columns of the table."""
    reads: tuple[Feature, ...]
    """[K] the same as features."""
    scales: Floats
    """[K] what to divide their values by."""

    @classmethod
    def of(cls, factors: tuple[LearnedFactor, ...], tables: Tables) -> _Product:
        columns = np.array(
            list(dict.fromkeys(column for factor in factors for column in factor.simplified.columns.tolist())),
            dtype=np.int64,
        )
        reads = tuple(tables.pool.features[column] for column in columns)
        product = cls(factors, columns, reads, tables.pool.scales[columns])
        if not product.of_table(tables).any():
            raise GrammarlabError(
                "none of the models looked at is predicted to be liked: what is liked may be too rare. Score more "
                "models like those that you like."
            )
        return product

    def of_table(self, tables: Tables) -> Floats:
        """[m] the scores of the models of the pool."""
        return self(tables.pool.counts[:, self.columns].toarray())

    @property
    def bound(self) -> float:
        """No score is larger."""
        highest = [factor.simplified.levels.max(initial=0.0) or MAX_SCORE for factor in self.factors]
        return float(_product([np.array([level]) for level in highest])[0])

    def __call__(self, values: Floats) -> Floats:
        """The score [n] of values [n, K] of the features."""
        scaled = values / self.scales
        place = {column: i for i, column in enumerate(self.columns.tolist())}
        return _product(
            [
                factor.simplified(scaled[:, [place[column] for column in factor.simplified.columns.tolist()]])
                for factor in self.factors
            ]
        )


def _judged(
    learned: Learned, target: Target, preference: _Product, tables: Tables, pool: Pool
) -> tuple[tuple[Step, ...], Measured]:
    """What each step did to the density, and how near the result comes to the predicted one."""
    predicted = _product([factor.predicted for factor in preference.factors])
    drawn = _product([factor.drawn for factor in preference.factors])
    few = preference.of_table(tables)
    ratio = np.concatenate([learned.ratio(part) for part in pool.forests])
    base_ratio = _base_ratio(target, pool)
    weights = pool.weights * base_ratio
    relative = np.divide(ratio, base_ratio, out=np.zeros(len(ratio)), where=base_ratio > 0.0)
    steps = (
        Step("scores drawn to the levels that were given", agreement(predicted, drawn, weights).js),
        Step("features left out", agreement(drawn, few, weights).js),
        Step("made into a grammar", agreement(few, relative, weights).js),
    )
    return steps, measured(predicted * base_ratio, ratio, pool.weights)


def _product(scores: Sequence[Floats]) -> Floats:
    """[n] of factors one score, 0 to 100."""
    return MAX_SCORE * np.prod(np.minimum(np.array(scores), MAX_SCORE) / MAX_SCORE, axis=0)


def _base_ratio(target: Target, pool: Pool) -> Floats:
    """[m] the density that the preference multiplies by that of the original grammar."""
    if target.even is None:
        return np.ones(len(pool.weights))
    return np.concatenate([target.even.ratio(part) for part in pool.forests])
