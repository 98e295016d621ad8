"""``grammarlab learn``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grammarlab.cli.report import friendly_errors, print_json, say
from grammarlab.cli.sample import complete_grammar

if TYPE_CHECKING:
    from grammarlab.runs.learn import LearnResult


def learn(
    grammar: Annotated[
        str, typer.Argument(help="A .cga file, or the name of a shipped grammar.", autocompletion=complete_grammar)
    ],
    scenario: Annotated[Path, typer.Option("--scenario", help="A scenario file: what is liked, known exactly.")],
    method: Annotated[str, typer.Option("--method", help="How to learn: compile.")] = "compile",
    file: Annotated[Path | None, typer.Option("-o", "--output", help="The new rule file.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the result.")] = False,
) -> None:
    """Make a grammar that samples models in proportion to how much they are liked."""
    with friendly_errors():
        from grammarlab.runs.learn import learn_from_scenario

        wanted = file or Path(f"{Path(grammar).stem}_{scenario.stem}.cga")
        result = learn_from_scenario(grammar, scenario, method, wanted)
        if as_json:
            print_json(_as_json(result))
        else:
            _tell(result)


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
    say(f"{result.file}: {learned.rules_after} rules, {learned.rules_before} before")
    say(f"divergence from what is liked: {result.js:.3g} nats, {result.js_before:.3g} before")
    for finding in learned.findings:
        say(f"note: {finding}")
