"""``grammarlab facade infer``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console import friendly_errors, print_json, print_result, say
from grammarlab.cli.file_kinds import FACADE, expected_kind
from grammarlab.files import check_overwrites


def infer(
    file: Annotated[Path, typer.Argument(help="File of a facade.", exists=True, dir_okay=False)],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Design to write; NAME.toml when left out.", dir_okay=False),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance",
            help="Tolerance in metres for aligned sides and equal sizes. Default: that of the shortest description.",
            min=0.0,
            max=10.0,
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object about the design.")] = False,
) -> None:
    """Infer patterns and layers from a facade: a design that can be laid out at any size."""
    with friendly_errors():
        from grammarlab.facade.file import load_facade
        from grammarlab.runs.facade.layer_inference import infer_design, save_inferred

        name = file.name.removesuffix(".json").removesuffix(".facade")
        target = output or Path(f"{name}.toml")
        check_overwrites([target], [file])
        with expected_kind(file, FACADE):
            facade = load_facade(file)
        inferred = infer_design(facade, tolerance, name)
        target.parent.mkdir(parents=True, exist_ok=True)
        save_inferred(inferred, target)
        score, design = inferred.score, inferred.design
        if as_json:
            print_json(
                {
                    "design": str(target),
                    "score": score.area,
                    "iou": score.iou,
                    "quality": score.quality,
                    "elements": score.elements,
                    "found": score.other_elements,
                    "layers": len(design.layers),
                    "symbols": len(design.symbols),
                    "patterns": {key: pattern.text for key, pattern in design.patterns.items()},
                    "counters": dict(inferred.solved.layout.candidate.counters),
                    "letters": inferred.length,
                    "tolerance": inferred.tolerance,
                    "seconds": inferred.seconds,
                }
            )
            return
        say(f"{len(design.layers)} layers of {len(design.patterns)} patterns over {len(design.symbols)} symbols")
        say(
            f"{score.area:.2%} of the area, elements overlap by {score.iou:.2%}, "
            f"{score.other_elements} for {score.elements}"
        )
        print_result(target)
