"""Commands on rule files: ``list``, ``check`` and ``format``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console import FAILURE, friendly_errors, print_content, print_json, print_result, say, with_options
from grammarlab.errors import UsageError


def format_file(
    file: Annotated[Path, typer.Argument(help="A .cga file.")],
    check: Annotated[
        bool, typer.Option("--check", help="Exit with 1 if the file would change; write nothing.")
    ] = False,
    in_place: Annotated[bool, typer.Option("--in-place", "-i", help="Write the file instead of printing it.")] = False,
) -> None:
    """Print a rule file in the canonical style, comments included."""
    with friendly_errors():
        from grammarlab.files import rewrite_text
        from grammarlab.language.formatting import format_grammar
        from grammarlab.language.grammar import Grammar, read_text

        if check and in_place:
            raise UsageError("--check and --in-place exclude each other.")
        text = read_text(file)
        formatted = format_grammar(Grammar.parse(text, str(file)))
        changed = formatted != text
        if check:
            say(f"{file}: {'would change' if changed else 'is formatted'}")
            raise typer.Exit(FAILURE if changed else 0)
        if not in_place:
            print_content(formatted)
        elif changed:
            rewrite_text(file, formatted)
            say(f"{file}: formatted")


def list_examples(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """List the grammars that come with grammarlab."""
    from grammarlab.runs.sample.shipped import shipped_examples

    with friendly_errors():
        examples = shipped_examples()
        if as_json:
            print_json({"examples": [{"name": e.name, "description": e.description()} for e in examples]})
            return
        width = max((len(e.name) for e in examples), default=0)
        for example in examples:
            print_result(f"{example.name:<{width}}  {example.description()}")


def check(
    grammar: Annotated[str, typer.Argument(metavar="FILE", help="A .cga file, or the name of a shipped grammar.")],
    assets: Annotated[
        Path | None, typer.Option("--assets", help="Folder of assets. Default: the asset folder of the rules.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """List all findings about a rule file.

    Findings are errors, unsupported features and warnings. Imported files are included.

    The exit code is 1 if there is an error.
    """
    with friendly_errors():
        from grammarlab.runs.sample.checks import check_source
        from grammarlab.runs.sample.shipped import find_rules

        source = find_rules(grammar, assets)
        file, checked = source.path, check_source(source)
        findings = [finding for checked_file in checked for finding in checked_file.findings]
        counts = {kind: sum(f.severity == kind for f in findings) for kind in ("error", "unsupported", "warning")}
        if as_json:
            print_json({"file": str(file), **counts, "findings": [finding.as_dict() for finding in findings]})
        else:
            for checked_file in checked:
                lines = checked_file.text.splitlines()
                for finding in checked_file.findings:
                    print_result(with_options(finding.render(lines)) + "\n")
            print_result(_summary(file, counts))
        if counts["error"]:
            raise typer.Exit(FAILURE)


def _summary(file: Path, counts: dict[str, int]) -> str:
    nouns = {"error": "error", "unsupported": "unsupported feature", "warning": "warning"}
    parts = [f"{count} {nouns[kind]}{'s' * (count != 1)}" for kind, count in counts.items() if count]
    return f"{file}: {', '.join(parts) or 'nothing to complain about'}"
