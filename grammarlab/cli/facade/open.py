"""``grammarlab facade open``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console.report import friendly_errors, say


def open_facade(
    file: Annotated[Path, typer.Argument(help="Facade file.", exists=True, dir_okay=False)],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="File to save to. Default: NAME.edited.facade.json.", dir_okay=False),
    ] = None,
    port: Annotated[int, typer.Option("--port", help="Port of the page; 0 for any free one.", min=0, max=65535)] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser, or only print its address.")
    ] = True,
) -> None:
    """Edit a facade in the browser.

    Sizes, grids, columns and rows can be changed.
    """
    with friendly_errors():
        from grammarlab.runs.facade.editor.editor import Editor
        from grammarlab.runs.facade.editor.server import PAGE
        from grammarlab.runs.serving.server import serve

        editor = Editor(file, output)

        def tell(address: str) -> None:
            typer.echo(address)
            say(f"saves to {editor.desk.target}; Ctrl-C ends")
            if browser:
                typer.launch(address)

        try:
            serve(editor, PAGE, port, tell)
        except KeyboardInterrupt:
            say("ended.")
        finally:
            editor.close()
            if editor.desk.is_lost:
                say(f"what was not saved is in {editor.desk.rescue()}")
