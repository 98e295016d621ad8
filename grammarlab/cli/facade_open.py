"""``grammarlab facade open``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from grammarlab.cli.console import friendly_errors, say
from grammarlab.cli.file_kinds import DESIGN, ELEMENTS, FACADE, MESH, expected_kind
from grammarlab.cli.page import page_opener

if TYPE_CHECKING:
    from grammarlab.pages.desktop import Desktop
    from grammarlab.pages.server import Page


class _Opened(NamedTuple):
    """The page for a file, and its workers."""

    desktop: Desktop[Any]
    page: Page


def open_facade(
    file: Annotated[
        Path,
        typer.Argument(
            help="A facade or elements (.json), a design of layers (.toml), the mesh of a building, or a scan.",
            exists=True,
            dir_okay=False,
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="File to save to. Default: a new file in the current folder, named after FILE.",
            dir_okay=False,
        ),
    ] = None,
    templates: Annotated[
        str, typer.Option("--templates", help="Templates for elements: files or names, as in facade match.")
    ] = "basic",
    port: Annotated[int, typer.Option("--port", help="Port of the page; 0 for any free one.", min=0, max=65535)] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser, or only print its address.")
    ] = True,
) -> None:
    """Edit a facade in the browser.

    A design of layers, the mesh of a building and a scan have pages of their own.
    """
    with friendly_errors():
        from grammarlab.matching.scans.scan_files import is_elements
        from grammarlab.synthesis.mesh.building_files import FORMATS

        if file.suffix.lower() == ".toml":
            opened = _design(file, output)
        elif is_elements(file):
            opened = _scan(file, output, templates)
        elif file.suffix.lower() in FORMATS:
            opened = _building(file, output)
        else:
            with expected_kind(file, FACADE, DESIGN, MESH, ELEMENTS):
                opened = _facade(file, output)
        try:
            _serve(opened, port, browser=browser)
        finally:
            opened.desktop.close()
            if opened.desktop.desk.is_lost:
                say(f"unsaved changes are in {opened.desktop.desk.rescue()}")


def _facade(file: Path, output: Path | None) -> _Opened:
    from grammarlab.pages.editor.editor import PAGE, Editor

    return _Opened(Editor(file, output), PAGE)


def _design(file: Path, output: Path | None) -> _Opened:
    from grammarlab.pages.layers.designer import PAGE, Designer

    return _Opened(Designer(file, output), PAGE)


def _building(file: Path, output: Path | None) -> _Opened:
    from grammarlab.pages.corrector import PAGE, Corrector

    say("reading the building ...")
    return _Opened(Corrector(file, output), PAGE)


def _scan(file: Path, output: Path | None, templates: str) -> _Opened:
    from grammarlab.extras import require
    from grammarlab.matching.library import templates_by_name
    from grammarlab.matching.scans.scan_files import load_elements
    from grammarlab.pages.matcher import PAGE, Matcher
    from grammarlab.pages.scan_desk import ScanDesk

    require("jax")
    target = output or Path(f"{file.stem}.corrections.json")
    return _Opened(Matcher(ScanDesk(file.name, load_elements(file), templates_by_name(templates), target)), PAGE)


def _serve(opened: _Opened, port: int, *, browser: bool) -> None:
    from grammarlab.pages.server import serve

    try:
        with page_opener(f"saves to {opened.desktop.desk.target}; Ctrl-C ends", browser=browser) as announce:
            serve(opened.desktop, opened.page, port, announce)
    except KeyboardInterrupt:
        say("ended.")
