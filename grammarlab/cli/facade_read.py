"""``grammarlab facade read`` and ``grammarlab facade show``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from grammarlab.cli.console import friendly_errors, print_json, print_result, say
from grammarlab.cli.file_kinds import BOXES, FACADE, RULES, expected_kind
from grammarlab.errors import UsageError

if TYPE_CHECKING:
    from grammarlab.runs.facade.read import ReadResult


def show(
    file: Annotated[Path, typer.Argument(help="Facade file.", exists=True, dir_okay=False)],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Drawing (.svg), picture (.png) or model (.glb, .obj, .ply).")
    ],
    pixels: Annotated[float, typer.Option("--pixels", help="Pixels per metre of a picture.", min=1.0)] = 50.0,
) -> None:
    """Write a facade as a drawing, a picture or a model."""
    with friendly_errors():
        from grammarlab.facade.file import load_facade
        from grammarlab.runs.facade.gallery import show_facade

        with expected_kind(file, FACADE):
            facade = load_facade(file)
        print_result(show_facade(facade, output, pixels))


def read(
    file: Annotated[
        Path,
        typer.Argument(
            help="Labelled boxes (.xml, .json, .csv, .txt of annotation tools), CityGML (.gml, .xml) or rules (.cga).",
            exists=True,
            dir_okay=False,
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="File to write. Default: NAME.facade.json.", dir_okay=False),
    ] = None,
    wall: Annotated[
        str,
        typer.Option(
            "--wall", help="Wall of a CityGML model, or image of an annotation with several. Default: list them."
        ),
    ] = "",
    width: Annotated[
        float | None, typer.Option("--width", help="Width in metres. Default: 20 if the file has no unit.")
    ] = None,
    height: Annotated[
        float | None,
        typer.Option("--height", help="Height in metres. Default: from the width and the aspect ratio of the picture."),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance",
            help="Largest distance of aligned sides, as a share of the shorter side. Default: 0.01, in metres 0.001.",
            min=0.0,
            max=0.1,
        ),
    ] = None,
    split: Annotated[bool, typer.Option("--split", help="Cut boxes that form a pinwheel instead of refusing them.")] = (
        False
    ),
    face: Annotated[
        str,
        typer.Option(
            "--face",
            help="Side of a rule file's model: front, right, back or left; front:1 is its second largest wall.",
        ),
    ] = "front",
    parts: Annotated[
        str,
        typer.Option(
            "--parts", help="Symbols of a rule file that become boxes, separated by commas. Default: all leaves."
        ),
    ] = "",
    start_rule: Annotated[str, typer.Option("--start", help="Start rule of a rule file.")] = "",
    seed: Annotated[int, typer.Option("--seed", help="Seed of a rule file's model.", min=0)] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the result.")] = False,
) -> None:
    """Read a facade from labelled boxes, a model or rules.

    A facade is a tree of rectangles in metres.
    """
    with friendly_errors():
        from grammarlab.runs.facade.read import read_facade, read_face

        _check_sizes({"--width": width, "--height": height})
        target = output or Path(f"{file.stem}.facade.json")
        if file.suffix.lower() == ".cga":
            _refuse_sizes(wall, width, height)
            symbols = [name.strip() for name in parts.split(",") if name.strip()]
            result = read_face(
                str(file),
                target,
                face,
                symbols,
                seed=seed,
                start_rule=start_rule or None,
                tolerance=tolerance,
                split=split,
            )
        else:
            with expected_kind(file, BOXES, RULES):
                result = read_facade(
                    file, target, wall=wall, width=width, height=height, tolerance=tolerance, split=split
                )
        for note in result.notes:
            say(note)
        values = _as_json(result)
        if as_json:
            print_json(values)
        else:
            say(f"{result.facade.width:.2f} x {result.facade.height:.2f} m, {values['leaves']} leaves")
            for grid in values["grids"]:
                say(f"grid {grid['name']}: {grid['columns']} columns x {grid['rows']} rows")
            say(f"boxes were moved by {result.snapped:.3f} m at most")
            print_result(result.file)


def _check_sizes(sizes: dict[str, float | None]) -> None:
    from grammarlab.facade.reading.assembling import LARGEST
    from grammarlab.facade.tree import SHORTEST

    for option, metres in sizes.items():
        if metres is not None and not SHORTEST <= metres <= LARGEST:
            raise UsageError(
                f"{option}: expected metres above 0, at least {SHORTEST:g} and at most {LARGEST:,.0f}, found "
                f"{metres:g}."
            )


def _refuse_sizes(wall: str, width: float | None, height: float | None) -> None:
    """Refuse options for sizes and walls: the rules define the size of their building."""
    if wall or width is not None or height is not None:
        raise UsageError("--wall, --width and --height are not for rule files: give --face and --parts.")


def _as_json(result: ReadResult) -> dict[str, Any]:
    leaves = len(result.facade.leaves)
    return {
        "file": str(result.file),
        "width": result.facade.width,
        "height": result.facade.height,
        "leaves": leaves,
        "inner_nodes": len(result.facade) - leaves,
        "grids": [
            {"name": grid.name, "rows": grid.num_rows, "columns": grid.num_columns} for grid in result.facade.grids
        ],
        "snapped": result.snapped,
        "notes": list(result.notes),
        "seconds": result.seconds,
    }
