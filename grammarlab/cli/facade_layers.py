"""``grammarlab facade layers``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.report import friendly_errors, print_json, say
from grammarlab.errors import UsageError


def layers(
    file: Annotated[Path, typer.Argument(help="Design of layers (.toml).", exists=True, dir_okay=False)],
    output: Annotated[
        Path,
        typer.Option(
            "-o", "--output", help="Folder for 001.facade.json, .png, .svg, .glb, .obj, .cga, ...", file_okay=False
        ),
    ],
    width: Annotated[
        float | None, typer.Option("--width", help="Metres, of the canvas; the design's by default.")
    ] = None,
    height: Annotated[float | None, typer.Option("--height", help="Metres; likewise.")] = None,
    number: Annotated[int, typer.Option("-n", "--number", help="Layouts at most.", min=1, max=100)] = 5,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the layouts.")] = False,
) -> None:
    """Lay out a design of overlaid patterns on a canvas of any size, so that all layers fit each other."""
    with friendly_errors():
        from grammarlab.facade.layers.designs.file import LARGEST, load_design
        from grammarlab.runs.facade.layers import save_layouts, solve_design

        for option, value in (("--width", width), ("--height", height)):
            if value is not None and not (math.isfinite(value) and 0.0 < value <= LARGEST):
                raise UsageError(f"{option}: expected metres above 0 and at most {LARGEST:,.0f}, found {value:g}.")
        solved = solve_design(load_design(file), width, height, number)
        files = save_layouts(solved, output, file)
        if as_json:
            print_json(
                {"layouts": [{**each.as_dict(), "files": made} for each, made in zip(solved, files, strict=True)]}
            )
            return
        for each, made in zip(solved, files, strict=True):
            values = each.as_dict()
            counters = ", ".join(f"{name} = {value}" for name, value in values["counters"].items()) or "no counters"
            told = "the best" if values["proven"] else f"none is below {values['bound']:.4g}"
            say(f"{counters}: energy {values['energy']:.4g} ({told}), sizes off by {values['sizing_error']:.3g} m²")
            typer.echo(made["facade"])
