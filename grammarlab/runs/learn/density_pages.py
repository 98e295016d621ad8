"""Pages about learned densities, from a scenario, labels or examples."""

from __future__ import annotations

from collections.abc import Iterator
from math import exp
from pathlib import Path
from typing import Any

from grammarlab.learning.stopping import NUM_MORE
from grammarlab.learning.targets.writers import Learned
from grammarlab.runs.learn.from_examples import ExamplesResult
from grammarlab.runs.learn.from_labels import LabelsResult
from grammarlab.runs.learn.from_scenario import LearnResult
from grammarlab.runs.learn.report import Choice, Report, compared_rows, cost_facts, distance
from grammarlab.runs.learn.scenario_measures import TrueDensity
from grammarlab.scene.scene_pictures import with_pictures
from grammarlab.tables import markdown_table

Rows = tuple[tuple[str, str, str], ...]


def page_of_scenario(result: LearnResult) -> Report:
    """Page about an exactly known density."""
    scenario, learned = result.source.scenario, result.learned
    facts = (
        *cost_facts(learned, result.measured),
        ("method", f"{learned.method}, base {scenario.base}"),
        ("seconds", f"{result.seconds:.2f}"),
    )
    return Report(
        title=_title(result.file, learned),
        origin=f"Learned by `grammarlab learn` from {scenario.grammar} and scenario {scenario.name}: {scenario.title}.",
        compared=(*compared_rows("what is liked", result.measured), _size(learned)),
        facts=facts,
        sections=(),
        findings=learned.findings,
        before=result.source.space,
        after=learned,
    )


def page_of_labels(result: LabelsResult) -> Report:
    """Page about a density learned from scores."""
    learned, density = result.learned, result.density
    compared = (
        *compared_rows("what was learned", density.measured),
        *_truth(result.truth),
        _size(learned),
    )
    facts = (
        ("labels", f"{result.num_labels}"),
        *(() if result.gain is None else ((f"{NUM_MORE} more may change it by", distance(result.gain)),)),
        *cost_facts(learned, density.measured),
        ("method", f"{learned.method}, base {learned.base}"),
        ("seconds", f"{result.seconds:.1f}"),
    )
    return Report(
        title=_title(result.file, learned),
        origin=f"Learned by `grammarlab learn` from {result.source.file} and {result.labels_from}.",
        words=density.predicted.words.lines,
        compared=compared,
        facts=facts,
        sections=_label_sections(result),
        findings=density.notes,
        before=result.space,
        after=learned,
        choices=lambda: tuple(_choices(result)),
    )


def _choices(result: LabelsResult) -> Iterator[Choice]:
    """The choices of which the words speak; a choice without two models that differ in it alone is left out."""
    for words in result.density.predicted.words.contrasts:
        pairs = (result.space.contrast(address, words.feature) for address in words.examples)
        pair = next((pair for pair in pairs if pair is not None), None)
        if pair is not None:
            scene = with_pictures(pair.scene, result.source.assets)
            yield Choice(words.text, words.without, words.having, scene)


def _label_sections(result: LabelsResult) -> tuple[tuple[str, str], ...]:
    steps = markdown_table(("step", "changes it by"), [(step.name, distance(step.js)) for step in result.density.steps])
    factors = markdown_table(
        ("factor", "labels", "original kept"),
        [(factor.name, f"{factor.num_labels}", f"{factor.unexplained:.0%}") for factor in result.factors],
    )
    features = zip(result.density.names, result.density.features, strict=True)
    display = result.space.display_names.text
    listing = "\n".join(f"- {display(name)} (`{feature}`)" for name, feature in features)
    depend = "\n".join(f"- {entry}" for entry in result.relevances)
    return (
        ("Steps", steps),
        ("Factors", factors),
        ("What the file looks at", listing or "Nothing: all models are liked alike."),
        ("What the scores depend on", depend or "Nothing."),
    )


def page_of_examples(result: ExamplesResult) -> Report:
    """Page about a density learned from examples."""
    learned, held_out = result.learned, result.held_out
    moved = ("distance from what was learned", distance(result.measured.before.js), distance(result.measured.after.js))
    facts = [("examples", f"{result.num_examples:,}")]
    if held_out is not None:
        facts += [
            ("examples kept back that it can make", f"{held_out.possible:,} of {held_out.num_models:,}"),
            ("how many times as often as the original, on average", f"{exp(held_out.gain):.3g}"),
        ]
    facts += [
        *cost_facts(learned, result.measured),
        ("components", f"{result.num_components}"),
        ("method", f"{learned.method}"),
        ("seconds", f"{result.seconds:.1f}"),
    ]
    return Report(
        title=_title(result.file, learned),
        origin=f"Learned by `grammarlab learn` from {result.source.file} and the models in {result.examples.name}.",
        compared=(moved, *_truth(result.truth), _size(learned)),
        facts=tuple(facts),
        sections=(),
        findings=learned.findings,
        before=result.space,
        after=learned,
    )


def _title(file: Path | None, learned: Learned[Any]) -> str:
    return learned.method if file is None else file.name


def _size(learned: Learned[Any]) -> tuple[str, str, str]:
    return learned.units[1], f"{learned.rules_before}", f"{learned.rules_after}"


def _truth(truth: TrueDensity | None) -> Rows:
    return () if truth is None else compared_rows(f"scenario {truth.scenario}", truth.measured)
