"""``grammarlab facade synthesize``, with constraints on the labels of a new facade from options."""

from __future__ import annotations

import re
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grammarlab.cli.console import friendly_errors, print_json, print_result, say
from grammarlab.cli.facade_grammar import metres
from grammarlab.cli.file_kinds import MESH, Unit, UnitOption, Up, UpOption, expected_kind, kind_of
from grammarlab.cli.numbers import plain_number
from grammarlab.errors import UsageError

if TYPE_CHECKING:
    from grammarlab.synthesis.label_grid import Rows, Wishes

_ROWS: tuple[Rows, ...] = ("ground", "top", "between")


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
        from grammarlab.runs.facade.synthesize import SynthesisRequest, synthesize_buildings

        wishes = _wishes(
            count or (), only or (), fix or (), equal_corners=equal_corners, symmetric=symmetric, keep=keep
        )
        if len(example or ()) > len(buildings):
            raise UsageError(f"--example: expected at most {len(buildings)} files, one for each building; found more.")
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
        with expected_kind(next((file for file in buildings if kind_of(file) != MESH), buildings[0]), MESH):
            report = synthesize_buildings(buildings, output, task)
        if as_json:
            print_json(report)
            return
        for note in report["notes"]:
            say(note)
        for result in report["results"]:
            bound = "proven least" if result["proven"] else f"at least {result['bound']}"
            say(
                f"{result['rows']} x {result['columns']} units, energy {result['energy']} ({bound}), "
                f"{result['triangles']:,} triangles, {'closed' if result['watertight'] else 'open'}"
            )
            for note in result["notes"]:
                say(f"  {note}")
            print_result(result["files"]["glb"])
        if report["family"]:
            say(f"{report['family']['facades']:,.0f} buildings of other sizes:")
            print_result(report["family"]["file"])


def _wishes(
    counts: Sequence[str],
    only: Sequence[str],
    fixed: Sequence[str],
    *,
    equal_corners: bool,
    symmetric: bool,
    keep: bool,
) -> Wishes:
    """Constraints from the values of options.

    Args:
        counts: texts such as `door=1` or `shop=2:5`.
        only: texts such as `shop=ground`.
        fixed: texts such as `door=0,3`: row and column, from 0, at the bottom and at the left.
        equal_corners: value of `Wishes.equal_corners`.
        symmetric: value of `Wishes.symmetric`.
        keep: value of `Wishes.keep`.

    Raises:
        UsageError: If a value has another form.
    """
    from grammarlab.synthesis.label_grid import Count, Fixed, Only, Wishes

    return Wishes(
        counts=tuple(Count(*_count(text)) for text in counts),
        only=tuple(Only(*_only(text)) for text in only),
        fixed=tuple(Fixed(*_fixed(text)) for text in fixed),
        equal_corners=equal_corners,
        symmetric=symmetric,
        keep=keep,
    )


def _count(text: str) -> tuple[str, int, int]:
    """A label, and its least and largest number of occurrences."""
    label, value = _label_and_value(text, "--count", r"\d{1,6}(:\d{1,6})?", "door=1, or shop=2:5 for 2 to 5 of them")
    least, _, most = value.partition(":")
    return label, int(least), int(most or least)


def _label_and_value(text: str, option: str, pattern: str, example: str) -> tuple[str, str]:
    """The label before the last equals sign, and the value after it."""
    label, _, value = text.rpartition("=")
    if not label.strip() or not re.fullmatch(pattern, value.strip(), re.ASCII):
        raise UsageError(f"{option}: expected {example}; found {text!r:.80}.")
    return label.strip(), value.strip()


def _only(text: str) -> tuple[str, Rows]:
    """A label and its only rows."""
    label, value = _label_and_value(text, "--only", "|".join(_ROWS), "shop=ground, shop=top or shop=between")
    return label, next(rows for rows in _ROWS if rows == value)


def _fixed(text: str) -> tuple[int, int, str]:
    """Row and column of a label, and the label."""
    label, value = _label_and_value(
        text, "--fix", r"\d{1,6},\d{1,6}", "door=0,3: row and column, from 0 at the lower left"
    )
    row, column = value.split(",")
    return int(row), int(column), label


def _box(text: str) -> tuple[float | None, float | None, float | None]:
    if not text:
        return None, None, None
    try:
        width, depth, height = (plain_number(part) for part in text.lower().split("x"))
    except ValueError as error:
        raise UsageError(f"--box: expected WIDTHxDEPTHxHEIGHT in metres, such as 40x12x25, found {text!r}.") from error
    return width or None, height or None, depth or None
