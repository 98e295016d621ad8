"""``grammarlab learn``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grammarlab.cli.report import friendly_errors, print_json, say
from grammarlab.cli.sample import complete_grammar

if TYPE_CHECKING:
    from grammarlab.runs.learn.labels import LabelsResult
    from grammarlab.runs.learn.scenario import LearnResult


def learn(
    grammar: Annotated[
        str, typer.Argument(help="A .cga file, or the name of a shipped grammar.", autocompletion=complete_grammar)
    ],
    scenario: Annotated[
        Path | None,
        typer.Option("--scenario", help="A scenario file: what is liked, known exactly; with labels, to compare with."),
    ] = None,
    labels: Annotated[Path | None, typer.Option("--labels", help="Scores of models: .csv, .jsonl or .parquet.")] = None,
    method: Annotated[
        str, typer.Option("--method", help="compile, parameters, structure, tied or rejection.")
    ] = "compile",
    samples: Annotated[int, typer.Option("--samples", help="Models to learn from; compile needs none.")] = 5_000,
    file: Annotated[Path | None, typer.Option("-o", "--output", help="The new rule file.")] = None,
    report: Annotated[
        Path | None, typer.Option("--report", help="With labels: folder for a page with tables and pictures.")
    ] = None,
    base: Annotated[str, typer.Option("--base", help="With labels: what scores multiply, grammar or uniform.")] = (
        "grammar"
    ),
    seed: Annotated[int, typer.Option("--seed", help="With labels: of fits and of the models looked at.", min=0)] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the result.")] = False,
) -> None:
    """Make a grammar that samples models in proportion to how much they are liked."""
    with friendly_errors():
        from grammarlab.errors import UsageError
        from grammarlab.runs.learn.scenario import learn_from_scenario

        liked = labels or scenario
        if liked is None:
            raise UsageError("learn from what? Give --labels FILE, or --scenario FILE.")
        wanted = file or Path(f"{Path(grammar).stem}_{liked.stem}.cga")
        if labels is not None:
            from_labels = _from_labels(grammar, labels, wanted, scenario=scenario, base=base, seed=seed, report=report)
            if as_json:
                print_json(_labels_as_json(from_labels))
            else:
                _tell_labels(from_labels)
            return
        result = learn_from_scenario(grammar, liked, method, wanted, samples)
        if as_json:
            print_json(_as_json(result))
        else:
            _tell(result)


def _from_labels(
    grammar: str, labels: Path, file: Path, *, scenario: Path | None, base: str, seed: int, report: Path | None
) -> LabelsResult:
    from grammarlab.errors import UsageError
    from grammarlab.runs.learn.labels import learn_from_labels

    if base not in ("grammar", "uniform"):
        raise UsageError(f"no base is called {base!r}; those there are: grammar, uniform")
    result = learn_from_labels(grammar, labels, file, base=base, seed=seed, scenario=scenario)
    if report is not None:
        from grammarlab.runs.learn.report import write_report
        from grammarlab.runs.workers import available_cores

        say(f"table and pictures: {write_report(result, report, seed=seed, jobs=available_cores())}")
    return result


def _labels_as_json(result: LabelsResult) -> dict[str, Any]:
    values: dict[str, Any] = {
        "labels": result.num_labels,
        "method": result.learned.method,
        "js": result.js,
        "js_before": result.js_before,
        "steps": [{"name": step.name, "js": step.js} for step in result.steps],
        "features": [str(feature) for feature in result.features],
        "effective_models": result.effective_models,
        "rules_before": result.learned.rules_before,
        "rules_after": result.learned.rules_after,
        "seconds": result.seconds,
        "findings": list(result.learned.findings),
    }
    if result.truth is not None:
        values["scenario"] = {
            "name": result.truth.scenario,
            "js": result.truth.after.js,
            "js_before": result.truth.before.js,
            "correlation": result.truth.after.correlation,
        }
    return values


def _tell_labels(result: LabelsResult) -> None:
    learned = result.learned
    say(f"{result.file}: {learned.rules_after} rules, {learned.rules_before} before; from {result.num_labels} labels")
    say(f"divergence from what was learned: {result.js:.3g} nats, {result.js_before:.3g} before")
    for step in result.steps:
        say(f"  {step.js:.3g} {step.name}")
    if result.truth is not None:
        after, before = result.truth.after.js, result.truth.before.js
        say(f"divergence from scenario {result.truth.scenario}: {after:.3g} nats, {before:.3g} before")
    say(f"looked at: {', '.join(result.feature_names) or 'nothing: all models are liked alike'}")
    for finding in learned.findings:
        say(f"note: {finding}")


def _as_json(result: LearnResult) -> dict[str, Any]:
    return {
        "scenario": result.scenario,
        "method": result.learned.method,
        "js": result.js,
        "correlation": result.correlation,
        "rules_before": result.learned.rules_before,
        "rules_after": result.learned.rules_after,
        "seconds": result.seconds,
    }


def _tell(result: LearnResult) -> None:
    learned = result.learned
    if result.file is not None:
        say(f"{result.file}: {learned.rules_after} rules, {learned.rules_before} before")
    say(f"divergence from what is liked: {result.js:.3g} nats, {result.js_before:.3g} before")
    for finding in learned.findings:
        say(f"note: {finding}")
