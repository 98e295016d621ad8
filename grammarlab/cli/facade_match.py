"""``grammarlab facade match`` and ``grammarlab facade scene``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console import friendly_errors, print_json, print_result, say
from grammarlab.cli.file_kinds import ELEMENTS, MESH, Unit, UnitOption, Up, UpOption, expected_kind
from grammarlab.files import check_overwrites
from grammarlab.option_names import with_options


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
        str, typer.Option("--method", help="One of default, paper, independent, kmeans; see docs/matching/index.md.")
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
        from grammarlab.matching.corrections import load_corrections
        from grammarlab.matching.library import templates_by_name
        from grammarlab.matching.scans.scan_files import load_elements
        from grammarlab.runs.facade.match_files import FILES, as_dict, match_elements, save_match

        check_overwrites((output / name for name in FILES), [elements, *filter(None, (boxes, corrections))])
        chosen = templates_by_name(templates)
        answers = load_corrections(corrections) if corrections else ()
        with expected_kind(elements, ELEMENTS, MESH):
            loaded = load_elements(elements, boxes, unit.value, up.axis)
        result = match_elements(loaded, chosen, method, seed, answers)
        values = as_dict(result, method, seed)
        values["notes"] = [with_options(note) for note in values["notes"]]
        files = save_match(result, values, output)
        if as_json:
            print_json(values)
            return
        for note in values["notes"]:
            say(note)
        for sentence in values["words"]:
            say(sentence)
        for element in values["elements"]:
            if element["uncertain"]:
                say(f"element {element['element']}: {element['kind']}, uncertain: {element['uncertain']}")
        print_result(files[0])


def scene(
    output: Annotated[Path, typer.Option("-o", "--output", help="File to write: .json or .npz.", dir_okay=False)],
    elements: Annotated[int, typer.Option("-n", "--elements", help="Number of rectangles.", min=1)] = 32,
    kinds: Annotated[
        int, typer.Option("--kinds", help="Number of different sizes; they share widths and heights.", min=1)
    ] = 5,
    noise: Annotated[
        float, typer.Option("--noise", help="Standard deviation of each coordinate in metres.", min=0.0, max=10.0)
    ] = 0.02,
    occluded: Annotated[
        float, typer.Option("--occluded", help="Share of the elements of which .1 to .6 is hidden.", min=0.0, max=1.0)
    ] = 0.3,
    points: Annotated[int, typer.Option("--points", help="Points per element.", min=1, max=100_000)] = 64,
    rows: Annotated[int, typer.Option("--rows", help="Rows of a facade; 0 for single elements.", min=0, max=1000)] = 0,
    tree: Annotated[bool, typer.Option("--tree", help="Hide neighbours behind a tree.")] = False,
    house: Annotated[bool, typer.Option("--house", help="Make the house of Figure 5.7 instead of rectangles.")] = False,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the scene.", min=0)] = 0,
) -> None:
    """Make a synthetic scene for `facade match`, with its truth."""
    with friendly_errors():
        from grammarlab.matching import scenes
        from grammarlab.matching.scans.element_files import save_elements

        options = scenes.SceneOptions(
            elements=elements, kinds=kinds, noise=noise, occluded=occluded, points=points, rows=rows, tree=tree
        )
        elements_of_scene = scenes.house(noise=noise, seed=seed) if house else scenes.rectangles(options, seed)
        output.parent.mkdir(parents=True, exist_ok=True)
        save_elements(elements_of_scene, output)
        print_result(output)
