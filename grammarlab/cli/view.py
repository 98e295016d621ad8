"""``grammarlab view``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console import friendly_errors, print_json, print_result, say


def view(
    run: Annotated[Path, typer.Argument(help="Folder of a run, as `grammarlab sample` writes it: out/building.")],
    other: Annotated[Path | None, typer.Argument(help="Folder of another run, to be shown beside it.")] = None,
    html: Annotated[
        Path | None,
        typer.Option("--html", help="Write the page to this file, which needs nothing else, to send.", dir_okay=False),
    ] = None,
    megabytes: Annotated[
        int, typer.Option("--megabytes", help="Largest size of the models in the page; later ones are left out.", min=1)
    ] = 32,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser, or only print its file.")
    ] = True,
    as_json: Annotated[bool, typer.Option("--json", help="With --html: print one JSON object about the page.")] = False,
) -> None:
    """Show the models of a run, or of two side by side, large and turning, with their derivation trees."""
    with friendly_errors():
        from grammarlab.errors import UsageError
        from grammarlab.files import write_text
        from grammarlab.pages.run_page import run_page

        if as_json and html is None:
            raise UsageError("--json is about the file of --html: say which.")
        folders = [folder for folder in (run, other) if folder is not None]
        page = run_page(folders, megabytes << 20, sent=html is not None)
        for folder, count in zip(folders, page.left_out, strict=True):
            if count:
                say(f"{folder}: {count:,} models are left out: not finished, or beyond --megabytes {megabytes}")
        if html is not None:
            write_text(html, page.content)
            if as_json:
                print_json({"file": str(html), "bytes": html.stat().st_size, "left_out": list(page.left_out)})
            else:
                say(f"page: {html} ({html.stat().st_size / 1e6:.1f} MB)")
            return
        _show(page.content, browser=browser)


def _show(content: str, *, browser: bool) -> None:
    """Keep the page in a private file until the user ends it."""
    from threading import Event

    from grammarlab.cli.page import open_file
    from grammarlab.pages.redirect import private_page

    try:
        with private_page(content) as file:
            print_result(str(file))
            say("shows the run; Ctrl-C ends")
            if browser:
                open_file(file)
            Event().wait()
    except KeyboardInterrupt:
        say("ended.")
