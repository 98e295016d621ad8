"""``grammarlab facade open``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple, Protocol

import typer

from grammarlab.cli.console import friendly_errors, say
from grammarlab.cli.file_kinds import DESIGN, ELEMENTS, FACADE, MESH, expected_kind
from grammarlab.cli.page import page_opener

if TYPE_CHECKING:
    from collections.abc import Callable

    from grammarlab.pages.server import Page, Served


class _Desk(Protocol):
    """The edited document."""

    target: Path

    @property
    def is_lost(self) -> bool:
        """Whether changes could not be saved."""
        ...

    def rescue(self) -> Path:
        """Save it to another path, and return the path."""
        ...


class _DocumentPage(NamedTuple):
    """The page for a file."""

    served: Served
    page: Page
    target: Path
    """The file that the page saves to."""
    desk: _Desk | None
    """None if every change is saved at once."""
    close: Callable[[], None]
    """Ends the workers of the page."""


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
            document_page = _design(file, output)
        elif is_elements(file):
            document_page = _scan(file, output, templates)
        elif file.suffix.lower() in FORMATS:
            document_page = _building(file, output)
        else:
            with expected_kind(file, FACADE, DESIGN, MESH, ELEMENTS):
                document_page = _facade(file, output)
        try:
            _serve(document_page, port, browser=browser)
        finally:
            document_page.close()
            if document_page.desk is not None and document_page.desk.is_lost:
                say(f"unsaved changes are in {document_page.desk.rescue()}")


def _facade(file: Path, output: Path | None) -> _DocumentPage:
    from grammarlab.pages.editor.editor import PAGE, Editor

    editor = Editor(file, output)
    return _DocumentPage(editor, PAGE, editor.desk.target, editor.desk, editor.close)


def _design(file: Path, output: Path | None) -> _DocumentPage:
    from grammarlab.pages.layers.designer import PAGE, Designer

    designer = Designer(file, output)
    return _DocumentPage(designer, PAGE, designer.desk.target, designer.desk, designer.close)


def _building(file: Path, output: Path | None) -> _DocumentPage:
    from grammarlab.pages.corrector import PAGE, Corrector

    say("reading the building ...")
    corrector = Corrector(file, output)
    return _DocumentPage(corrector, PAGE, corrector.desk.target, corrector.desk, corrector.close)


def _scan(file: Path, output: Path | None, templates: str) -> _DocumentPage:
    from grammarlab.extras import require
    from grammarlab.matching.library import templates_by_name
    from grammarlab.matching.scans.scan_files import load_elements
    from grammarlab.pages.matcher import PAGE, Matcher
    from grammarlab.pages.scan_desk import ScanDesk

    require("jax")
    target = output or Path(f"{file.stem}.corrections.json")
    matcher = Matcher(ScanDesk(file.name, load_elements(file), templates_by_name(templates), target))
    return _DocumentPage(matcher, PAGE, target, None, matcher.close)


def _serve(document_page: _DocumentPage, port: int, *, browser: bool) -> None:
    from grammarlab.pages.server import serve

    try:
        with page_opener(f"saves to {document_page.target}; Ctrl-C ends", browser=browser) as announce:
            serve(document_page.served, document_page.page, port, announce)
    except KeyboardInterrupt:
        say("ended.")
