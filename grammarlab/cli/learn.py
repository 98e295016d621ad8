"""``grammarlab learn``."""

from __future__ import annotations

from math import exp
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from grammarlab.cli.console import (
    Attributes,
    Library,
    NoFootprint,
    Scheduler,
    StartRule,
    StyleName,
    friendly_errors,
    print_json,
    say,
)
from grammarlab.cli.evaluate import PERSONS_HELP, complete_scenario
from grammarlab.cli.sample import choices_of, complete_grammar
from grammarlab.files import check_overwrites
from grammarlab.learning.targets.distance_words import divergence_share

if TYPE_CHECKING:
    from grammarlab.learning.targets.writers import Learned
    from grammarlab.runs.learn.from_examples import ExamplesResult
    from grammarlab.runs.learn.from_labels import LabelsResult
    from grammarlab.runs.learn.from_scenario import LearnResult
    from grammarlab.runs.learn.report import Report
    from grammarlab.runs.learn.scenario_measures import TrueDensity
    from grammarlab.runs.work.executors import AbstractExecutor


class _Summary(NamedTuple):
    """Description of a result."""

    values: dict[str, Any]
    """One JSON object, for programs."""
    lines: list[str]
    """Lines of text, for people."""
    page: Report


def learn(
    grammar: Annotated[
        str, typer.Argument(help="A .cga, .toml or .xml file, or a shipped name.", autocompletion=complete_grammar)
    ],
    scenario: Annotated[
        str,
        typer.Option(
            "--scenario",
            help="Exactly known preference: scenario file or shipped name. With labels or examples: only to compare.",
            autocompletion=complete_scenario,
        ),
    ] = "",
    labels: Annotated[
        Path | None, typer.Option("--labels", help="Scores: .csv, .tsv, .txt, .jsonl, .parquet, or a session (.db).")
    ] = None,
    examples: Annotated[
        Path | None,
        typer.Option("--examples", help="Good models: a folder that grammarlab sample wrote, or a Parquet file in it."),
    ] = None,
    models: Annotated[
        str,
        typer.Option("--models", help="With --examples: numbers of the good models of the run, as in 3,7,9-12."),
    ] = "",
    method: Annotated[
        str,
        typer.Option(
            "--method",
            help="One of compile, parameters, structure, tied, rejection; for species kinds, acceptance. Default: the "
            "first; for examples of grammars tied.",
        ),
    ] = "",
    samples: Annotated[
        int, typer.Option("--samples", help="Samples to learn from; not used by compile.", min=1)
    ] = 5_000,
    file: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="File to write. Default: named after the grammar and the labels.",
            dir_okay=False,
        ),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option("--report", help="Folder for a page with tables and pictures before and after.", file_okay=False),
    ] = None,
    base: Annotated[
        str,
        typer.Option(
            "--base",
            help="With labels, what scores multiply: how often the grammar makes a model, or uniform: all alike.",
        ),
    ] = ("grammar"),
    max_rules: Annotated[
        int | None,
        typer.Option(
            "--max-rules",
            help="With labels: largest number of branches of the rules, as grammarlab show counts them. If it is too "
            "small, an acceptance rule completes the original rules. Default: twice as many as the grammar has.",
            min=1,
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(
            "--seed", help="Seed of the models to learn from. Default: that of the session, or 0.", min=0, max=2**64 - 1
        ),
    ] = None,
    person: Annotated[
        str,
        typer.Option("--person", help="With labels and a scenario: person whose scores are the truth. " + PERSONS_HELP),
    ] = "exact",
    start_rule: StartRule = "",
    attributes: Attributes = None,
    style: StyleName = "",
    library: Library = None,
    _footprint: NoFootprint = None,
    scheduler: Scheduler = "",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the result.")] = False,
) -> None:
    """Make a grammar, or a species, that samples liked models.

    Its density is proportional to the scores. On a cluster the workers draw the pictures of --report.
    """
    with friendly_errors():
        from grammarlab.cli.progress import progress
        from grammarlab.errors import UsageError
        from grammarlab.evaluation.respondents import EXACT, RESPONDENTS
        from grammarlab.evaluation.scenario_values import chosen_one
        from grammarlab.runs.evaluate.request import find_scenario
        from grammarlab.runs.learn import density_pages
        from grammarlab.runs.sample.shipped import find_rules
        from grammarlab.runs.work.executor_choice import executor_of

        executor = executor_of(0, scheduler, say)
        if base not in ("grammar", "uniform"):
            raise UsageError(f"unknown base {base!r}; expected grammar or uniform")
        if labels is not None and examples is not None:
            raise UsageError("labels and examples exclude each other: give only one of --labels and --examples.")
        if labels is None and (base != "grammar" or max_rules is not None):
            raise UsageError("--base and --max-rules need --labels FILE; a scenario file has its own base.")
        if models and examples is None:
            raise UsageError("--models chooses examples: give the run with --examples FOLDER.")
        respondent = chosen_one(person, RESPONDENTS, "person")
        if respondent != EXACT and (labels is None or not scenario):
            raise UsageError("--person needs --labels FILE and --scenario FILE.")
        scenario_file = find_scenario(scenario) if scenario else None
        source = labels or examples or scenario_file
        if source is None:
            raise UsageError("nothing to learn from: give --labels FILE, --examples FOLDER or --scenario FILE.")
        target = file or Path(f"{Path(grammar).stem}_{source.stem}{find_rules(grammar).suffix}")
        choices = choices_of(grammar, start_rule, attributes, style, library)
        check_overwrites([target], filter(None, (Path(grammar), labels, scenario_file)))
        if labels is not None:
            from grammarlab.learning.targets.writers import Making
            from grammarlab.pages.record.label_exchange import read_labels_or_session
            from grammarlab.runs.learn.from_labels import learn_from_labels

            making = Making(method, base, samples, max_rules)
            table, pool = read_labels_or_session(labels)
            for note in table.notes:
                say(f"note: {labels}: {note}")
            options: dict[str, Any] = {
                "choices": choices,
                "scenario": scenario_file,
                "respondent": respondent,
                "pool": pool if seed is None else None,
                "seed": seed or 0,
            }
            with progress(as_json=as_json) as on_progress:
                result = learn_from_labels(
                    grammar, table, target, making, labels_from=labels.name, on_progress=on_progress, **options
                )
            summary = _Summary(_labels_as_json(result), _labels_as_lines(result), density_pages.page_of_labels(result))
        elif examples is not None:
            from grammarlab.runs.learn.from_examples import learn_from_files

            result_of_examples = learn_from_files(
                grammar,
                examples,
                target,
                choices=choices,
                method=method,
                seed=seed or 0,
                scenario=scenario_file,
                models=models,
            )
            summary = _Summary(
                _examples_as_json(result_of_examples),
                _examples_as_lines(result_of_examples),
                density_pages.page_of_examples(result_of_examples),
            )
        else:
            from grammarlab.runs.learn.from_scenario import learn_from_scenario

            with progress(as_json=as_json) as on_progress:
                exact = learn_from_scenario(grammar, source, method, target, samples, on_progress, choices)
            summary = _Summary(_as_json(exact), _as_lines(exact), density_pages.page_of_scenario(exact))
        _print_summary(summary, report, seed or 0, executor, as_json)


def _print_summary(
    summary: _Summary, report: Path | None, seed: int, executor: AbstractExecutor, as_json: bool
) -> None:
    if as_json:
        print_json(summary.values)
    else:
        for line in summary.lines:
            say(line)
    if report is not None:
        from grammarlab.runs.learn.report import write_report

        say(f"table and pictures: {write_report(summary.page, report, seed=seed, executor=executor)}")


def _size(learned: Learned[Any], file: Path | None) -> list[str]:
    if file is None:
        return ["note: no file is written, since rejection filters models of the original"]
    unit = learned.units[learned.rules_after != 1]
    return [f"{file}: {learned.rules_after} {unit}, {learned.rules_before} before"]


def _notes(learned: Learned[Any]) -> list[str]:
    return [f"note: {finding}" for finding in learned.findings]


def _truth_as_json(truth: TrueDensity | None) -> dict[str, Any]:
    if truth is None:
        return {}
    after, before = truth.after, truth.before
    values = {"name": truth.scenario, "js": after.js, "js_before": before.js, "correlation": after.correlation}
    return {"scenario": values}


def _differs(name: str, js: float, js_before: float) -> str:
    return f"differs from {name} by {divergence_share(js)}, the original by {divergence_share(js_before)}"


def _truth_as_lines(truth: TrueDensity | None) -> list[str]:
    if truth is None:
        return []
    after, before = truth.after.js, truth.before.js
    return [_differs(f"scenario {truth.scenario}", after, before)]


def _as_json(result: LearnResult) -> dict[str, Any]:
    return {
        "scenario": result.source.scenario.name,
        "method": result.learned.method,
        "js": result.js,
        "correlation": result.measured.after.correlation,
        "rules_before": result.learned.rules_before,
        "rules_after": result.learned.rules_after,
        **_rate_as_json(result.learned),
        "seconds": result.seconds,
        "findings": list(result.learned.findings),
    }


def _as_lines(result: LearnResult) -> list[str]:
    return [
        *_size(result.learned, result.file),
        _differs("the target", result.js, result.js_before),
        *_notes(result.learned),
    ]


def _labels_as_json(result: LabelsResult) -> dict[str, Any]:
    density = result.density
    measured = density.measured
    # A given scenario is a better truth than the density learned from the labels.
    best = measured if result.truth is None else result.truth.measured
    return {
        "labels": result.num_labels,
        "method": result.learned.method,
        "js": best.after.js,
        "js_before": best.before.js,
        "taught": {"js": measured.after.js, "js_before": measured.before.js},
        "steps": [{"name": step.name, "js": step.js} for step in density.steps],
        "features": [str(feature) for feature in density.features],
        "kept": {factor.name: factor.unexplained for factor in result.factors},
        "explained": {factor.name: factor.explained for factor in result.factors},
        "knowledge": list(density.predicted.words.knowledge),
        "likes": list(density.predicted.words.likes),
        "dislikes": list(density.predicted.words.dislikes),
        "expected_gain": result.gain,
        "effective_models": measured.effective_models,
        "acceptance": measured.acceptance,
        "rules_before": result.learned.rules_before,
        "rules_after": result.learned.rules_after,
        **_rate_as_json(result.learned),
        "seconds": result.seconds,
        "notes": list(result.notes),
        "findings": list(density.notes),
        **_truth_as_json(result.truth),
    }


def _rate_as_json(learned: Learned[Any]) -> dict[str, float]:
    return {} if learned.accept_rate is None else {"accept_rate": learned.accept_rate}


def _labels_as_lines(result: LabelsResult) -> list[str]:
    density = result.density
    after, before = density.measured.after.js, density.measured.before.js
    taught = f"differs from what {result.num_labels} labels taught by {divergence_share(after)}"
    return [
        *_size(result.learned, result.file),
        f"{taught}, the original by {divergence_share(before)} (100%: no model in common)",
        *(f"  {divergence_share(step.js)} {step.name}" for step in density.steps),
        *_truth_as_lines(result.truth),
        *density.predicted.words.lines,
        *(
            []
            if result.gain is None
            else [f"16 more scores are expected to change it by {divergence_share(result.gain)}"]
        ),
        *(f"note: factor {name} is left out: all its scores are 0" for name in result.left_out),
        *(f"note: {note}" for note in density.notes),
    ]


def _examples_as_json(result: ExamplesResult) -> dict[str, Any]:
    held_out = result.held_out
    return {
        "examples": result.num_examples,
        "method": result.learned.method,
        "js_before": result.measured.before.js,
        "components": result.num_components,
        "held_out": None
        if held_out is None
        else {"examples": held_out.num_models, "possible": held_out.possible, "gain": held_out.gain},
        "effective_models": result.measured.effective_models,
        "acceptance": result.measured.acceptance,
        "rules_before": result.learned.rules_before,
        "rules_after": result.learned.rules_after,
        "seconds": result.seconds,
        "findings": list(result.learned.findings),
        **_truth_as_json(result.truth),
    }


def _examples_as_lines(result: ExamplesResult) -> list[str]:
    held_out = result.held_out
    examples = "1 example" if result.num_examples == 1 else f"{result.num_examples:,} examples"
    moved = f"the original differs from what {examples} taught by"
    lines = [
        *_size(result.learned, result.file),
        f"{moved} {divergence_share(result.measured.before.js)}",
    ]
    if held_out is not None:
        lines.append(
            f"the new file can make {held_out.possible:,} of {held_out.num_models:,} held-out examples, on average "
            f"{exp(held_out.gain):.3g} times as often as the original"
        )
    return [*lines, *_truth_as_lines(result.truth), *_notes(result.learned)]
