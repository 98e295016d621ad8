"""``grammarlab watch``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console import Library, friendly_errors, say
from grammarlab.cli.page import page_opener
from grammarlab.cli.sample import complete_grammar


def watch(
    grammar: Annotated[str, typer.Argument(help="A .cga file, or a shipped name.", autocompletion=complete_grammar)],
    port: Annotated[int, typer.Option("--port", help="Port of the page; 0 for any free one.", min=0, max=65535)] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser, or only print its address.")
    ] = True,
    assets: Annotated[
        Path | None, typer.Option("--assets", help="Folder of assets. Default: the asset folder of the file.")
    ] = None,
    library: Library = None,
) -> None:
    """Show the model of a rule file in the browser, again after every save of the file in any editor.

    The page has the mistakes with their lines, sliders, menus and colours of attributes, dice for the seed, a sheet of
    sixteen models, and the derivation tree; a click on a part shows its rule and line, one on a row of the tree its
    parts.
    """
    with friendly_errors():
        from grammarlab.pages.server import serve
        from grammarlab.pages.watch.watcher import PAGE, Watcher

        watcher = Watcher(grammar, assets=assets, library=library)
        try:
            with page_opener(f"watches {watcher.desk.target}; Ctrl-C ends", browser=browser) as announce:
                serve(watcher, PAGE, port, announce)
        except KeyboardInterrupt:
            say("ended.")
        finally:
            watcher.close()
