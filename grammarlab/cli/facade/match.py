"""``grammarlab facade match``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console.report import friendly_errors, print_json, print_result, say
from grammarlab.cli.facade.file_kinds import ELEMENTS, MESH, wanted
from grammarlab.cli.facade.frames import Unit, UnitOption, Up, UpOption
from grammarlab.files import check_overwrites


def match(
    elements: Annotated[
        Path,
        typer.Argument(
            help="Elements (.json, .npz), or a scan or mesh of one facade (.ply, .las, .laz, .obj, .stl, .glb).",
            exists=True,
            dir_okay=False,
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for what is found.", file_okay=False)],
    templates: Annotated[
        str,
        typer.Option(
            "--templates", help="Template files or names of shipped templates, separated by commas; or basic, or all."
        ),
    ] = "basic",
    method: Annotated[
        str, typer.Option("--method", help="One of default, paper, independent, kmeans; see docs/facade-scans.md.")
    ] = "default",
    boxes: Annotated[
        Path | None,
        typer.Option(
            "--boxes",
            help="CSV file with left,bottom,right,top of the elements of a scan, in metres. Default: find the boxes.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    corrections: Annotated[
        Path | None,
        typer.Option(
            "--corrections",
            help="File of corrections, as saved by facade open.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    up: UpOption = Up.auto,
    unit: UnitOption = Unit.m,
    seed: Annotated[int, typer.Option("--seed", help="Seed of all random numbers.", min=0, max=2**64 - 1)] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about what was found.")] = False,
) -> None:
    """Match templates to the elements of a scan.

    Finds which elements are of one kind, and which sizes kinds share.
    """
    with friendly_errors():
        from grammarlab.facade.templates.kinds.corrections import load_corrections
        from grammarlab.facade.templates.library import named
        from grammarlab.facade.templates.reading.files import load_elements
        from grammarlab.runs.facade.match import FILES, as_dict, match_elements, save_match

        check_overwrites((output / name for name in FILES), [elements, *filter(None, (boxes, corrections))])
        chosen = named(templates)
        said = load_corrections(corrections) if corrections else ()
        with wanted(elements, ELEMENTS, MESH):
            loaded = load_elements(elements, boxes, unit.value, up.axis)
        found = match_elements(loaded, chosen, method, seed, said)
        values = as_dict(found, method, seed)
        files = save_match(found, values, output)
        if as_json:
            print_json(values)
            return
        for note in values["notes"]:
            say(note)
        for sentence in values["words"]:
            say(sentence)
        for each in values["elements"]:
            if each["uncertain"]:
                say(f"element {each['element']}: {each['kind']}, uncertain: {each['uncertain']}")
        print_result(files[0])
