"""``grammarlab facade synthesize``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console.numbers import plain_number
from grammarlab.cli.console.report import friendly_errors, print_json, print_result, say
from grammarlab.cli.facade.file_kinds import MESH, kind_of, wanted
from grammarlab.cli.facade.frames import Unit, UnitOption, Up, UpOption
from grammarlab.cli.facade.grammar import metres
from grammarlab.errors import UsageError


class SynthesisMethod(StrEnum):
    """Methods of label synthesis."""

    exact = "exact"
    em = "em"


def synthesize(
    buildings: Annotated[
        list[Path],
        typer.Argument(
            metavar="BUILDING...",
            help="Mesh of a building: OBJ, PLY, GLB, glTF or OFF; further meshes add their units.",
            exists=True,
            dir_okay=False,
        ),
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
        SynthesisMethod, typer.Option("--method", help="exact has a proven bound; em is the method of the paper.")
    ] = SynthesisMethod.exact,
    up: UpOption = Up.auto,
    unit: UnitOption = Unit.m,
    example: Annotated[
        list[Path] | None,
        typer.Option(
            "--example",
            help="Corrected example.json of an earlier run or of facade open; one per building.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    regions: Annotated[
        Path | None,
        typer.Option(
            "--regions", help="Number of the example building of each part, as a JSON map.", exists=True, dir_okay=False
        ),
    ] = None,
    count: Annotated[
        list[str] | None, typer.Option("--count", help="Number of occurrences of a label: door=1, or shop=2:5.")
    ] = None,
    only: Annotated[
        list[str] | None, typer.Option("--only", help="The only rows of a label: shop=ground, top or between.")
    ] = None,
    fix: Annotated[
        list[str] | None, typer.Option("--fix", help="Row and column of a label, from 0 at the lower left: door=0,3.")
    ] = None,
    equal_corners: Annotated[
        bool, typer.Option("--equal-corners", help="Left and right corners of the lowest and highest row are equal.")
    ] = False,
    symmetric: Annotated[bool, typer.Option("--symmetric", help="Rows read the same from both sides.")] = False,
    keep: Annotated[
        bool,
        typer.Option(
            "--keep/--no-keep", help="Labels that occur once on the ground floor, such as a door, stay single."
        ),
    ] = True,
    widths: Annotated[
        str, typer.Option("--widths", help="Widths in metres of the main walls that family.cga samples, such as 10:40.")
    ] = "",
    heights: Annotated[str, typer.Option("--heights", help="Heights in metres of these walls, such as 8:30.")] = "",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the results.")] = False,
) -> None:
    """Make buildings of other sizes from one example.

    They have other numbers of rows and columns of its units, and are closed if the example is.
    """
    with friendly_errors():
        from grammarlab.cli.facade.wishes import wishes_of
        from grammarlab.runs.facade.synthesis.synthesize import SynthesisRequest, synthesize_buildings

        wishes = wishes_of(
            count or (), only or (), fix or (), equal_corners=equal_corners, symmetric=symmetric, keep=keep
        )
        task = SynthesisRequest(
            rows=rows,
            columns=columns,
            box=_box(box),
            method=method.value,
            wishes=wishes,
            regions=regions,
            seed=seed,
            count=number,
            up=up.axis,
            unit=unit.value,
            corrections=tuple(example or ()),
            widths=metres("--widths", widths),
            heights=metres("--heights", heights),
        )
        with wanted(next((each for each in buildings if kind_of(each) != MESH), buildings[0]), MESH):
            report = synthesize_buildings(buildings, output, task)
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
            print_result(each["files"]["glb"])
        if report["family"]:
            say(f"{report['family']['facades']:,.0f} buildings of other sizes:")
            print_result(report["family"]["file"])


def _box(text: str) -> tuple[float | None, float | None, float | None]:
    if not text:
        return None, None, None
    try:
        width, depth, height = (plain_number(each) for each in text.lower().split("x"))
    except ValueError as error:
        raise UsageError(f"--box: expected WIDTHxDEPTHxHEIGHT in metres, such as 40x12x25, found {text!r}.") from error
    return width or None, height or None, depth or None
