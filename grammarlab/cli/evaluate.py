"""``grammarlab evaluate``."""

from __future__ import annotations

from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grammarlab.cli.console import NoFootprint, Scheduler, Unfinished, friendly_errors, print_json, say

if TYPE_CHECKING:
    from grammarlab.runs.evaluate.plots import ScenarioResults
    from grammarlab.runs.evaluate.request import EvaluationRequest
    from grammarlab.runs.evaluate.run import EvaluationResult


_MOST_CHARACTERS = 100
"""Largest number of characters of the names of scenarios in the name of a folder; file systems allow about 255."""
PERSONS_HELP = (
    "How models are scored: exact, stars, sd5, sd10, sd20, blunders5, blunders10, changing, changing_sd10, two, "
    "two_sd10."
)


def complete_scenario(incomplete: str) -> list[str]:
    """Shipped scenarios whose names begin with a text, for shell completion."""
    from grammarlab.runs.evaluate.request import named_scenarios

    return [name for name in named_scenarios() if name.startswith(incomplete)]


def evaluate(
    scenarios: Annotated[
        str,
        typer.Argument(
            help="Scenario file, folder of them, or shipped names such as F1,B1.", autocompletion=complete_scenario
        ),
    ],
    methods: Annotated[
        str,
        typer.Option("--methods", help="Some of default,paper,kde,sklearn,lightgbm. Default: those in each scenario."),
    ] = "",
    person: Annotated[str, typer.Option("--person", help=PERSONS_HELP + " Separate several by commas.")] = "exact",
    seeds: Annotated[
        int, typer.Option("--seeds", help="Number of simulated persons per method.", min=1, max=1000)
    ] = 10,
    max_labels: Annotated[
        int, typer.Option("--max-labels", help="Scores per person; 0 for the number in the scenario.", min=0)
    ] = 256,
    batch: Annotated[
        int, typer.Option("--batch", help="Models per round; 0 for the default of each method.", min=0)
    ] = 0,
    figures: Annotated[str, typer.Option("--figures", help="Draw these experiments as well: 4.7a,4.9b, or all.")] = "",
    grids: Annotated[
        bool,
        typer.Option("--grids", help="Draw models with their scores, and samples before and after learning, as well."),
    ] = False,
    density: Annotated[
        bool, typer.Option("--density", help="Compare the ways to make a grammar from a known preference as well.")
    ] = False,
    grammar_labels: Annotated[
        str,
        typer.Option("--grammar-labels", help="Write a grammar after this many scores as well: 128, or F1=288,B1=160."),
    ] = "",
    folder: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="Folder for curves, tables and pictures. Default: out/evaluation/SCENARIOS.",
            file_okay=False,
        ),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(
            "--report",
            help="Write the page to this file as well, with its pictures in the same folder.",
            dir_okay=False,
        ),
    ] = None,
    cache: Annotated[
        Path | None,
        typer.Option(
            "--cache", help="Folder for counted features. Default: cache in the output folder.", file_okay=False
        ),
    ] = None,
    workers: Annotated[int, typer.Option("--workers", help="Number of processes; 0 for one per core.", min=0)] = 0,
    _footprint: NoFootprint = None,
    scheduler: Scheduler = "",
    resume: Annotated[
        bool, typer.Option("--resume/--fresh", help="Keep the curves in the folder, or start again.")
    ] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object with all curves.")] = False,
) -> None:
    """Measure how fast preferences are learned.

    Simulated persons score models of scenarios.
    """
    run = Unfinished(without="--fresh")
    with friendly_errors(run.advice):
        from grammarlab.cli.progress import progress
        from grammarlab.runs.evaluate.request import EvaluationRequest, find_scenarios
        from grammarlab.runs.evaluate.run import evaluate_run
        from grammarlab.runs.work.executor_choice import executor_of

        request = EvaluationRequest.of(
            find_scenarios(scenarios),
            methods=methods,
            persons=person,
            batch=batch or None,
            seeds=seeds,
            max_labels=max_labels,
            figures=figures,
            grids=grids,
            density=density,
            grammar_labels=grammar_labels,
        )
        executor = executor_of(workers, scheduler, say)
        with progress(run.note, as_json=as_json) as on_progress:
            result = evaluate_run(
                request,
                folder or _folder_of(scenarios),
                report=report,
                cache=cache,
                executor=executor,
                fresh=not resume,
                command=_command(scenarios, request),
                on_progress=on_progress,
            )
        _print_summary(result, as_json)


def _folder_of(scenarios: str) -> Path:
    """Default folder of the results: ``out/evaluation/F1+B1``; a hash stands for the names that are too many."""
    name = "+".join(Path(part).resolve().stem for part in scenarios.split(","))
    if len(name) > _MOST_CHARACTERS:
        name = f"{name[:_MOST_CHARACTERS]}-{sha256(name.encode()).hexdigest()[:8]}"
    return Path("out", "evaluation", name)


def _command(scenarios: str, request: EvaluationRequest) -> str:
    """The command that reproduces the numbers."""
    words = ["grammarlab evaluate", scenarios]
    words += [f"--methods {request.methods}"] if request.methods else []
    names = ",".join(person.name for person in request.persons)
    words += [f"--person {names}"] if names != "exact" else []
    words += [f"--seeds {request.seeds} --max-labels {request.max_labels}"]
    words += [f"--batch {request.batch}"] if request.batch else []
    words += [f"--figures {','.join(figure.name for figure in request.figures)}"] if request.figures else []
    words += ["--grids"] * request.grids + ["--density"] * request.density
    numbers = [f"{name}={number}" if name else f"{number}" for name, number in request.grammar_labels.items()]
    words += [f"--grammar-labels {','.join(numbers)}"] if numbers else []
    return " ".join(words)


def _print_summary(result: EvaluationResult, as_json: bool) -> None:
    if as_json:
        objects = [_as_json(results, result) for results in result.scenarios]
        print_json(objects[0] if len(objects) == 1 else {"scenarios": objects})
        return
    for results in result.scenarios:
        for method, records in results.by_method().items():
            js = results.scenario.target.js
            labels_to_goal = [curve.labels_to(js) for curve in results.counted(records)]
            label_counts = sorted(labels for labels in labels_to_goal if labels is not None)
            later = " from the first liked model on" * (results.scenario.target.since == "first liked")
            text = f"{label_counts[0]} to {label_counts[-1]} labels{later}" if label_counts else "never"
            say(
                f"{results.name} {method}: JS {results.js_original:.3f} at first; "
                f"at most {js:g} after {text} ({len(label_counts)} of {len(labels_to_goal)} seeds)"
            )
    for row in result.densities:
        size = f"{row.rules_after} branches of rules ({row.rules_before} before)"
        say(f"{row.scenario} {row.method}: JS {row.js:.3g}, {size}")
    for grammar in result.grammars:
        whose = f"{grammar.scenario}, person {grammar.person} {grammar.seed}, {grammar.labels} scores"
        say(f"{whose}: JS of the grammar {grammar.js:.3g}")
    say(f"tables and pictures: {result.page}")


def _as_json(results: ScenarioResults, result: EvaluationResult) -> dict[str, Any]:
    name = results.scenario.name
    grammars = [asdict(row) for row in result.grammars if (row.scenario, row.person) == (name, results.person)]
    return {
        "scenario": results.scenario.name,
        "grammar": results.scenario.grammar,
        "base": results.scenario.base,
        "person": results.person,
        "js_original": results.js_original,
        "curves": [
            {
                "method": record.method,
                "seed": record.seed,
                "js_original": record.js_original,
                "curve": [[point.labels, point.js] for point in record.curve.points],
                "correlations": [point.correlation for point in record.curve.points],
                "labels_to_0.01": record.curve.labels_to(),
                "labels_until_below_0.01": record.curve.labels_until_below(),
                "labels_before_first_liked": record.curve.labels_before_first_liked(),
                "labels_to_0.01_since_first_liked": record.curve.since_first_liked().labels_to(),
                "labels_until_below_0.01_since_first_liked": record.curve.since_first_liked().labels_until_below(),
            }
            for record in results.records
        ],
        **(
            {"densities": [asdict(row) for row in result.densities if row.scenario == name]} if result.densities else {}
        ),
        **({"grammars": grammars} if grammars else {}),
    }
