"""``grammarlab check``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console.report import FAILURE, friendly_errors, print_json, print_result


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
        from grammarlab.runs.requests.checks import check_source
        from grammarlab.runs.requests.examples import find_rules

        source = find_rules(grammar, assets)
        file, checked = source.path, check_source(source)
        findings = [finding for one in checked for finding in one.findings]
        counts = {kind: sum(f.severity == kind for f in findings) for kind in ("error", "unsupported", "warning")}
        if as_json:
            print_json({"file": str(file), **counts, "findings": [finding.as_dict() for finding in findings]})
        else:
            for one in checked:
                lines = one.text.splitlines()
                for finding in one.findings:
                    print_result(finding.render(lines) + "\n")
            print_result(_summary(file, counts))
        if counts["error"]:
            raise typer.Exit(FAILURE)


def _summary(file: Path, counts: dict[str, int]) -> str:
    nouns = {"error": "error", "unsupported": "unsupported feature", "warning": "warning"}
    parts = [f"{count} {nouns[kind]}{'s' * (count != 1)}" for kind, count in counts.items() if count]
    return f"{file}: {', '.join(parts) or 'nothing to complain about'}"
