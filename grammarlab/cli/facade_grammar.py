"""``grammarlab facade grammar``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console import friendly_errors, print_json, print_result, say
from grammarlab.cli.file_kinds import FACADE, expected_kind
from grammarlab.cli.numbers import plain_number
from grammarlab.errors import UsageError
from grammarlab.files import check_overwrites


def grammar(
    file: Annotated[Path, typer.Argument(help="Facade file.", exists=True, dir_okay=False)],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Rule file to write. Default: NAME.cga.", dir_okay=False)
    ] = None,
    widths: Annotated[
        str, typer.Option("--widths", help="Write the family of the facade for these widths in metres, such as 10:40.")
    ] = "",
    heights: Annotated[
        str, typer.Option("--heights", help="Write the family of the facade for these heights in metres, such as 8:30.")
    ] = "",
    stretch: Annotated[
        float,
        typer.Option("--stretch", help="Largest relative difference of sizes that count as equal.", min=0.0, max=0.5),
    ] = 0.05,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the grammar.")] = False,
) -> None:
    """Write the rules of a facade or of its family.

    With a range of sizes, the rules make other facades of the same columns and rows.
    """
    with friendly_errors():
        from grammarlab.facade.file import load_facade
        from grammarlab.runs.facade.grammar_file import grammar_of, save_grammar

        target = output or Path(f"{file.name.removesuffix('.json').removesuffix('.facade')}.cga")
        check_overwrites([target], [file])
        with expected_kind(file, FACADE):
            facade = load_facade(file)
        result = grammar_of(facade, metres("--widths", widths), metres("--heights", heights), stretch)
        save_grammar(result, facade, target)
        if as_json:
            print_json({"file": str(target), "rules": result.rules, "exact": result.exact, "choices": result.choices})
            return
        if not result.choices:
            say(f"{result.rules} rules; leaves are off by {result.exact:.2g} m at most")
        else:
            fewest, most = result.choices["columns"]
            narrowest, widest = result.choices["widths"]
            say(f"{result.rules} rules; {fewest} to {most} columns, {narrowest:.2f} to {widest:.2f} m wide")
            for name, (smallest, largest) in result.choices["rows"].items():
                say(f"{name}: {smallest} to {largest}")
            say(f"{result.choices['facades']:,.0f} different facades")
        print_result(target)


def metres(option: str, text: str) -> tuple[float, float] | None:
    """Two numbers separated by a colon; None for an empty text."""
    from grammarlab.facade.tree import LONGEST

    if not text:
        return None
    try:
        low, high = (plain_number(part) for part in text.split(":"))
    except ValueError:
        low = high = math.nan
    if not 0.0 <= low <= high <= LONGEST or high == 0.0:
        raise UsageError(f"{option}: expected metres from and to, such as 10:40, found {text[:60]!r}.")
    return low, high
