"""``grammarlab facade show``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console.report import friendly_errors, print_result
from grammarlab.cli.facade.file_kinds import FACADE, wanted


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
        from grammarlab.runs.facade.show import show_facade

        with wanted(file, FACADE):
            facade = load_facade(file)
        print_result(show_facade(facade, output, pixels))
