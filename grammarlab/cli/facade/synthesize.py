"""``grammarlab facade synthesize``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console.report import friendly_errors, print_json, say
from grammarlab.errors import UsageError


class Method(StrEnum):
    """How labels are found."""

    exact = "exact"
    em = "em"


class Up(StrEnum):
    """Which axis of a file is up."""

    auto = "auto"
    y = "y"
    z = "z"


def synthesize(
    building: Annotated[
        Path, typer.Argument(help="Mesh of a building: OBJ, PLY, GLB, glTF or OFF.", exists=True, dir_okay=False)
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder for 001.glb, 001.facade.json, ...", file_okay=False)
    ],
    rows: Annotated[int, typer.Option("--rows", help="Rows of units of the main wall.")],
    columns: Annotated[int, typer.Option("--columns", help="Columns of units of the main wall.")],
    box: Annotated[
        str, typer.Option("--box", help="Width x depth x height in metres, such as 40x12x25; 0 leaves one free.")
    ] = "",
    seed: Annotated[
        int, typer.Option("--seed", help="Seed; other seeds choose other results of equal quality.", min=0)
    ] = 0,
    number: Annotated[int, typer.Option("-n", "--number", help="Largest number of results.", min=1, max=50)] = 1,
    method: Annotated[
        Method, typer.Option("--method", help="exact has a proven bound; em is the method of the paper.")
    ] = Method.exact,
    up: Annotated[Up, typer.Option("--up", help="Up axis of the file.")] = Up.auto,
    example: Annotated[
        Path | None,
        typer.Option("--example", help="Corrected example.json of an earlier run.", exists=True, dir_okay=False),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the results.")] = False,
) -> None:
    """Make buildings of other sizes after one example.

    They have other rows and columns of its units, and are closed as it is.
    """
    with friendly_errors():
        from grammarlab.runs.facade.synthesize import synthesize_buildings

        report = synthesize_buildings(
            building,
            output,
            rows=rows,
            columns=columns,
            box=_box(box),
            method=method.value,
            seed=seed,
            count=number,
            up="" if up is Up.auto else up.value,
            corrections=example,
        )
        if as_json:
            print_json(report)
            return
        for note in report["notes"]:
            say(note)
        for each in report["results"]:
            bound = "proven least" if each["proven"] else f"at least {each['bound']}"
            say(
                f"{each['rows']} x {each['columns']} units, energy {each['energy']} ({bound}), "
                f"{each['triangles']:,} triangles, {'closed' if each['watertight'] else 'open'}"
            )
            for note in each["notes"]:
                say(f"  {note}")
            typer.echo(each["files"]["glb"])


def _box(text: str) -> tuple[float | None, float | None, float | None]:
    if not text:
        return None, None, None
    try:
        width, depth, height = (float(each) for each in text.lower().split("x"))
    except ValueError as error:
        raise UsageError(f"--box: expected WIDTHxDEPTHxHEIGHT in metres, such as 40x12x25, found {text!r}.") from error
    return width or None, height or None, depth or None
