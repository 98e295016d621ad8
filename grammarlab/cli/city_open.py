"""``grammarlab city open``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console import friendly_errors, say
from grammarlab.cli.page import page_opener


def open_city(
    folder: Annotated[
        Path, typer.Argument(help="Folder of a city, from grammarlab city build.", exists=True, file_okay=False)
    ],
    port: Annotated[int, typer.Option("--port", help="Port of the page; 0 for any free one.", min=0, max=65535)] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser, or only print its address.")
    ] = True,
) -> None:
    """See a city in the browser, from above and from the street, and change it parcel by parcel.

    A click on a building shows its parcel, zone, seed and rules. It can be rerolled, pinned, excluded and scored; what
    is learned from the scores of a zone is built at once.
    """
    with friendly_errors():
        from grammarlab.pages.city.city_viewer import CityViewer, page_of
        from grammarlab.pages.server import serve

        viewer = CityViewer(folder)
        note = f"saves to {viewer.desk.target}; Ctrl-C ends" if viewer.desk.plan else "shows only; Ctrl-C ends"
        try:
            with page_opener(note, browser=browser) as announce:
                serve(viewer, page_of(folder), port, announce)
        except KeyboardInterrupt:
            say("ended.")
        finally:
            viewer.close()
