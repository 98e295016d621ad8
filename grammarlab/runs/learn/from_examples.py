"""From example models to a learned grammar on disk, with the gain in likelihood."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import cast

import numpy as np

from grammarlab.density.exact.learned import LearnedGrammar
from grammarlab.density.samples.examples import EXAMPLE_METHODS, ExampleMethod, learn_from_examples
from grammarlab.derivation.forest import Forest
from grammarlab.derivation.selection import select_models
from grammarlab.language.grammar import Grammar
from grammarlab.learning.designs.grammar_space import GrammarSpace
from grammarlab.learning.designs.pool import Pool, PoolDesigns
from grammarlab.learning.targets.divergence import Measured, measured
from grammarlab.learning.targets.writers import check_method
from grammarlab.runs.learn.example_models import example_models
from grammarlab.runs.learn.from_scenario import origin_line, scenario_of, write_learned
from grammarlab.runs.learn.scenario_measures import TrueDensity
from grammarlab.runs.sample.records import compiled
from grammarlab.runs.sample.shipped import RuleSource, find_rules
from grammarlab.runs.work.workers import one_thread

HELD_OUT_STRIDE = 5
"""One example in 5 is held out, if there are at least `MIN_HELD_OUT_EXAMPLES`."""
MIN_HELD_OUT_EXAMPLES = 50
"""Smallest number of examples of which some are held out."""


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Evaluation of the grammar learned from the others on held-out examples."""

    num_models: int
    possible: int
    """Number of them that the learned grammar can make."""
    gain: float
    """Mean log-likelihood ratio of these to the original grammar, in nats."""


@dataclass(frozen=True, slots=True)
class ExamplesResult:
    """A grammar learned from example models."""

    learned: LearnedGrammar
    file: Path
    examples: Path
    source: RuleSource
    num_examples: int
    held_out: HeldOut | None
    """Evaluation on held-out examples; None for few examples."""
    measured: Measured
    """Comparison of the original density with the learned one, on a pool of models."""
    seconds: float
    """Seconds from the examples to the text of the grammar."""
    truth: TrueDensity | None = None
    """Comparison with a scenario, if one is given."""


def learn_from_files(
    grammar: str, examples: Path, file: Path, *, method: str = "tied", seed: int = 0, scenario: Path | None = None
) -> ExamplesResult:
    """Learn the maximum-likelihood grammar of example models.

    Args:
        grammar: a rule file or the name of a shipped grammar that can make them.
        examples: folder or file of derivations, as read by `example_models`.
        file: path of the new rule file; assets that it names are copied beside it.
        method: one of `EXAMPLE_METHODS`.
        seed: seed of the models for measuring the result.
        scenario: a scenario file to compare the result with; nothing is learned from it.

    Raises:
        UsageError: If there are no examples, or they are not of the grammar.
        AssetError: If examples cannot be read.
    """
    check_method(method, EXAMPLE_METHODS)
    chosen = cast(ExampleMethod, method)
    source = find_rules(grammar)
    parsed, _ = compiled(source.text(), source.name)
    true_source = None if scenario is None else scenario_of(scenario, grammar, parsed.hash)
    begun = perf_counter()
    forest = example_models(examples, parsed)
    header = [
        origin_line(source.file, parsed.hash),
        f"Examples {examples.name}: {forest.num_models} models",
        f"Method {method} from examples",
    ]
    with one_thread():
        learned = learn_from_examples(parsed, forest, chosen, header=header, assets=source.assets)
        seconds = perf_counter() - begun
        held_out = _held_out(parsed, forest, chosen)
    write_learned(file, learned.text, GrammarSpace(learned.original, source.assets), source.assets)
    pool_designs = PoolDesigns.of(GrammarSpace(parsed, source.assets), Pool(seed))
    ratio = np.concatenate([learned.ratio(forest) for forest in pool_designs.batches])
    return ExamplesResult(
        learned=learned,
        file=file,
        examples=examples,
        source=source,
        num_examples=forest.num_models,
        held_out=held_out,
        measured=measured(ratio, ratio, pool_designs.weights),
        seconds=seconds,
        truth=None if true_source is None else TrueDensity.of(true_source, learned),
    )


def _held_out(grammar: Grammar, forest: Forest, method: ExampleMethod) -> HeldOut | None:
    if forest.num_models < MIN_HELD_OUT_EXAMPLES:
        return None
    is_held_out = np.arange(forest.num_models) % HELD_OUT_STRIDE == HELD_OUT_STRIDE - 1
    learned = learn_from_examples(grammar, select_models(forest, np.flatnonzero(~is_held_out)), method)
    ratio = learned.ratio(select_models(forest, np.flatnonzero(is_held_out)))
    possible = ratio[ratio > 0.0]
    return HeldOut(len(ratio), len(possible), float(np.log(possible).mean()) if len(possible) else 0.0)
