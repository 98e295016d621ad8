"""``grammarlab facade open``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grammarlab.cli.console.report import friendly_errors, say

if TYPE_CHECKING:
    from grammarlab.runs.serving.server import Page, Served


def open_facade(
    file: Annotated[
        Path,
        typer.Argument(
            help="File of a facade, or the mesh of a building to synthesize from.", exists=True, dir_okay=False
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="File to save to; NAME.edited.facade.json, or NAME.example.json of a mesh, when left out.",
            dir_okay=False,
        ),
    ] = None,
    port: Annotated[int, typer.Option("--port", help="Port of the page; 0 for any free one.", min=0, max=65535)] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser, or only print its address.")
    ] = True,
) -> None:
    """Edit a facade, or correct what a mesh is read as, in the browser.

    Of a facade sizes, grids, columns and rows can be changed; of a mesh units, lines and labels.
    """
    with friendly_errors():
        from grammarlab.facade.examples.mesh.reading import FORMATS

        if file.suffix.lower() in FORMATS:
            _correct(file, output, port, browser=browser)
        else:
            _edit(file, output, port, browser=browser)


def _edit(file: Path, output: Path | None, port: int, *, browser: bool) -> None:
    from grammarlab.runs.facade.editor.editor import Editor
    from grammarlab.runs.facade.editor.server import PAGE

    editor = Editor(file, output)
    try:
        _serve(editor, PAGE, editor.desk.target, port, browser=browser)
    finally:
        editor.close()
        if editor.desk.is_lost:
            say(f"what was not saved is in {editor.desk.rescue()}")


def _correct(file: Path, output: Path | None, port: int, *, browser: bool) -> None:
    from grammarlab.runs.facade.example_page.corrector import Corrector
    from grammarlab.runs.facade.example_page.server import PAGE

    say("reading the building ...")
    corrector = Corrector(file, output)
    try:
        _serve(corrector, PAGE, corrector.desk.target, port, browser=browser)
    finally:
        corrector.close()
        if corrector.desk.is_lost:
            say(f"what was not saved is in {corrector.desk.rescue()}")


def _serve(served: Served, page: Page, target: Path, port: int, *, browser: bool) -> None:
    from grammarlab.runs.serving.server import serve

    def tell(address: str) -> None:
        typer.echo(address)
        say(f"saves to {target}; Ctrl-C ends")
        if browser:
            typer.launch(address)

    try:
        serve(served, page, port, tell)
    except KeyboardInterrupt:
        say("ended.")
