"""``grammarlab facade layers``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

from grammarlab.cli.console import friendly_errors, print_json, print_result, say
from grammarlab.cli.file_kinds import DESIGN, expected_kind
from grammarlab.cli.numbers import plain_number
from grammarlab.errors import UsageError

_MOST_SIZES = 50
"""Largest number of widths, and of heights, of one family: each costs a layout."""


def layers(
    file: Annotated[Path, typer.Argument(help="Design of layers (.toml).", exists=True, dir_okay=False)],
    output: Annotated[
        Path,
        typer.Option(
            "-o", "--output", help="Folder for 001.facade.json, .png, .svg, .glb, .obj, .cga, ...", file_okay=False
        ),
    ],
    width: Annotated[
        float | None, typer.Option("--width", help="Width of the canvas in metres. Default: that of the design.")
    ] = None,
    height: Annotated[
        float | None, typer.Option("--height", help="Height of the canvas in metres. Default: that of the design.")
    ] = None,
    number: Annotated[int, typer.Option("-n", "--number", help="Largest number of layouts.", min=1, max=100)] = 5,
    widths: Annotated[
        str,
        typer.Option(
            "--widths", help="Write family.cga for these widths in metres as well: 6:30, or 6:30:13 for 13 of them."
        ),
    ] = "",
    heights: Annotated[
        str, typer.Option("--heights", help="Write family.cga for these heights in metres as well: 9:18:4.")
    ] = "",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the layouts.")] = False,
) -> None:
    """Lay out overlaid patterns on a canvas of any size.

    All layers of the design fit each other.
    """
    with friendly_errors():
        from grammarlab.layers.design_notes import design_notes
        from grammarlab.layers.file import MAX_SIZE_M, MIN_SIZE_M, load_design
        from grammarlab.runs.facade.layer_files import FAMILY, family_of, save_layouts, solve_design

        for option, value in (("--width", width), ("--height", height)):
            if value is not None and not MIN_SIZE_M <= value <= MAX_SIZE_M:
                raise UsageError(
                    f"{option}: expected metres above 0, at least {MIN_SIZE_M:g} and at most {MAX_SIZE_M:,.0f}, "
                    f"found {value:g}."
                )
        across, up = (
            _sizes(option, text, MIN_SIZE_M, MAX_SIZE_M)
            for option, text in (("--widths", widths), ("--heights", heights))
        )
        with expected_kind(file, DESIGN):
            design = load_design(file)
        notes = design_notes(design)
        for note in notes:
            say(f"note: {note}")
        solved = solve_design(design, width, height, number)
        family = None
        if across or up:
            family = family_of(design, across or [width or design.width], up or [height or design.height], number)
        files = save_layouts(solved, output, file, family.text if family else "")
        values: dict[str, Any] = {
            "layouts": [{**solution.as_dict(), "files": paths} for solution, paths in zip(solved, files, strict=True)],
            "notes": list(notes),
        }
        if family is not None:
            values["family"] = {"file": str(output / FAMILY), "rules": family.rules, "rules_alone": family.alone}
        if as_json:
            print_json(values)
            return
        for solution, paths in zip(solved, files, strict=True):
            layout = solution.layout
            counters = ", ".join(f"{name} = {value}" for name, value in layout.candidate.counters.items())
            proof = "proven" if layout.proven else f"at least {layout.bound:.4g}"
            say(f"{counters or 'no counters'}: energy {layout.energy:.4g} ({proof})")
            print_result(paths["facade"])
        if family is not None:
            say(f"{family.rules} rules; separate grammars of the layouts would need {family.alone}")
            print_result(values["family"]["file"])


def _sizes(option: str, text: str, smallest: float, largest: float) -> list[float]:
    """Sizes in metres from a text such as 6:30:13: first, last, number of sizes; none for an empty text."""
    if not text:
        return []
    try:
        low, high, *rest = (plain_number(part) for part in text.split(":"))
        (num,) = rest or [5.0]
    except ValueError:
        low, high, num = math.nan, math.nan, math.nan
    if not (smallest <= low <= high <= largest and num in range(1, _MOST_SIZES + 1)):
        raise UsageError(
            f"{option}: expected metres from and to and at most {_MOST_SIZES} sizes, such as 6:30:13, found "
            f"{text[:60]!r}."
        )
    count = int(num) if high > low else 1
    return [round(low + (high - low) * index / max(count - 1, 1), 6) for index in range(count)]
