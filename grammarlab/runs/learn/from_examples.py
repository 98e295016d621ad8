"""From example models to a learned file on disk, with the gain in likelihood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from grammarlab.arrays import Ints
from grammarlab.errors import UsageError
from grammarlab.language.presets import NO_CHOICES, RuleChoices
from grammarlab.learning.designs.design_space import AbstractDesignSpace
from grammarlab.learning.targets.divergence import Measured, measured
from grammarlab.learning.targets.file_head import origin_line
from grammarlab.learning.targets.writers import Learned, check_method
from grammarlab.runs.learn.example_learners import AbstractExampleLearner, example_learner
from grammarlab.runs.learn.from_scenario import scenario_of, write_learned
from grammarlab.runs.learn.scenario_measures import TrueDensity
from grammarlab.runs.sample.domains import opened
from grammarlab.runs.sample.manifest import MANIFEST, read_manifest
from grammarlab.runs.sample.records import DERIVATIONS
from grammarlab.runs.sample.request import read_model_numbers
from grammarlab.runs.sample.shipped import RuleSource, find_rules
from grammarlab.runs.work.workers import one_thread

HELD_OUT_STRIDE = 5
"""One example in 5 is held out, if there are at least `MIN_HELD_OUT_EXAMPLES`."""
MIN_HELD_OUT_EXAMPLES = 50
"""Smallest number of examples of which some are held out."""


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Evaluation of the file learned from the others on held-out examples."""

    num_models: int
    possible: int
    """Number of them that the learned file can make."""
    gain: float
    """Mean log-likelihood ratio of these to the original file, in nats."""


@dataclass(frozen=True, slots=True)
class ExamplesResult:
    """A file learned from example models."""

    space: AbstractDesignSpace[Any]
    """The space of the examples."""
    learned: Learned[Any]
    num_components: int
    """Components of the learned mixture."""
    file: Path
    examples: Path
    source: RuleSource
    num_examples: int
    held_out: HeldOut | None
    """Evaluation on held-out examples; None for few examples."""
    measured: Measured
    """Comparison of the original density with the learned one, on a pool of models."""
    seconds: float
    """Seconds from the examples to the text of the file."""
    truth: TrueDensity | None = None
    """Comparison with a scenario, if one is given."""


def learn_from_files(
    grammar: str,
    examples: Path,
    file: Path,
    *,
    choices: RuleChoices = NO_CHOICES,
    method: str = "",
    seed: int = 0,
    scenario: Path | None = None,
    models: str = "",
) -> ExamplesResult:
    """Learn the file near a given one that makes example models most likely.

    Args:
        grammar: a file that can make them, or the name of a shipped example.
        examples: folder or file that ``grammarlab sample`` wrote (`AbstractExampleLearner.read`).
        file: path of the new file, of the same kind; assets that it names are copied beside it.
        choices: choices of the user for a rule file.
        method: one of `AbstractExampleLearner.methods`; empty for the first one.
        seed: seed of the models for measuring the result.
        scenario: a scenario file to compare the result with; nothing is learned from it.
        models: numbers of the models of the run to learn from, as in ``3,7,9-12``; empty for all.

    Raises:
        UsageError: If there are no examples, a number is not one of a model, or they are not of the file.
        AssetError: If examples cannot be read.
    """
    source = find_rules(grammar, choices=choices)
    space = opened(source.suffix, source.text(), source.name, source.assets)
    learner = example_learner(source.suffix, space)
    method = method or learner.methods[0]
    check_method(method, learner.methods)
    true_source = None if scenario is None else scenario_of(scenario, grammar, space.hashes[0])
    begun = perf_counter()
    designs = learner.read(examples)
    if models:
        designs = learner.take(designs, _rows_of(models, learner.count(designs), examples))
    num = learner.count(designs)
    lines = [
        origin_line(source.file, space.hashes[0]),
        f"Examples {examples.name}: {num} model{'s' if num > 1 else ''}",
        f"Method {method} from examples",
    ]
    with one_thread():
        learned, num_components = learner.learn(designs, method, lines)
        seconds = perf_counter() - begun
        held_out = _held_out(learner, designs, method)
    write_learned(file, learned.text, space, source.assets)
    ratio, weights = learner.pool(learned, seed)
    return ExamplesResult(
        space=space,
        learned=learned,
        num_components=num_components,
        file=file,
        examples=examples,
        source=source,
        num_examples=learner.count(designs),
        held_out=held_out,
        measured=measured(ratio, ratio, weights),
        seconds=seconds,
        truth=None if true_source is None else TrueDensity.of(true_source, learned),
    )


def _rows_of(models: str, num_models: int, examples: Path) -> Ints:
    """The rows of models of a run by their numbers, ascending."""
    folder = examples / DERIVATIONS
    names = sorted(batch.name for batch in folder.glob("[0-9]*")) if folder.is_dir() else []
    if names != [f"{index:05d}" for index in range(len(names))]:
        raise UsageError(f"{examples}: a batch of models is missing; finish the run with sample --resume.")
    numbers = _numbers_of(examples, num_models)
    chosen = read_model_numbers(models, numbers[-1] + 1, str(examples))
    row = {number: index for index, number in enumerate(numbers)}
    if missing := [number for number in chosen if number not in row]:
        raise UsageError(
            f"models: {examples} has no model {missing[0]}, only some of its run: sample the others first."
        )
    return np.array([row[number] for number in chosen], dtype=np.int64)


def _numbers_of(examples: Path, num_models: int) -> Sequence[int]:
    """Numbers of the models of a run, in the order of its rows; a file of derivations alone has them from 0."""
    if not (examples / MANIFEST).is_file():
        return range(num_models)
    numbers = read_manifest(examples).request.model_numbers
    return numbers if len(numbers) == num_models else range(num_models)


def _held_out(learner: AbstractExampleLearner[Any], designs: Any, method: str) -> HeldOut | None:
    num = learner.count(designs)
    if num < MIN_HELD_OUT_EXAMPLES:
        return None
    is_held_out = np.arange(num) % HELD_OUT_STRIDE == HELD_OUT_STRIDE - 1
    learned, _ = learner.learn(learner.take(designs, np.flatnonzero(~is_held_out)), method, ())
    ratio = learner.ratio(learned, learner.take(designs, np.flatnonzero(is_held_out)))
    possible = ratio[ratio > 0.0]
    return HeldOut(len(ratio), len(possible), float(np.log(possible).mean()) if len(possible) else 0.0)
