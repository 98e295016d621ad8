"""``grammarlab list``."""

from __future__ import annotations

from typing import Annotated

import typer

from grammarlab.cli.console.report import friendly_errors, print_json, print_result


def list_examples(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """List the grammars that come with grammarlab."""
    from grammarlab.runs.requests.examples import shipped_examples

    with friendly_errors():
        examples = shipped_examples()
        if as_json:
            print_json({"examples": [{"name": e.name, "description": e.description()} for e in examples]})
            return
        width = max((len(e.name) for e in examples), default=0)
        for example in examples:
            print_result(f"{example.name:<{width}}  {example.description()}")
