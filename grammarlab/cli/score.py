"""``grammarlab score``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from grammarlab.cli.console import Attributes, Library, NoFootprint, StartRule, StyleName, friendly_errors, say
from grammarlab.cli.page import page_opener
from grammarlab.cli.sample import choices_of, complete_grammar, print_if_alike
from grammarlab.option_names import with_options

if TYPE_CHECKING:
    from collections.abc import Sequence

    from grammarlab.pages.windows import Message, Send


def score(
    grammar: Annotated[
        str, typer.Argument(help="A .cga, .toml or .xml file, or a shipped name.", autocompletion=complete_grammar)
    ],
    session: Annotated[
        Path | None, typer.Option("--session", help="Session file (.db); created if missing, otherwise continued.")
    ] = None,
    port: Annotated[int, typer.Option("--port", help="Port of the page; 0 for any free one.", min=0, max=65535)] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser, or only print its address.")
    ] = True,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the models of a new session.", min=0)] = 0,
    assets: Annotated[
        Path | None, typer.Option("--assets", help="Folder of assets. Default: the asset folder of the file.")
    ] = None,
    start_rule: StartRule = "",
    attributes: Attributes = None,
    style: StyleName = "",
    library: Library = None,
    _footprint: NoFootprint = None,
    stored_grammar: Annotated[
        bool, typer.Option("--stored-grammar", help="Use the text that the session was started with.")
    ] = False,
) -> None:
    """Score models in the browser, in a session file."""
    with friendly_errors():
        from grammarlab.cli.console import note_slow_pictures
        from grammarlab.pages.scoring.serving import serve
        from grammarlab.pages.scoring.session import Session
        from grammarlab.runs.sample.shipped import find_rules

        path = session or Path(f"{Path(grammar).stem}.db")
        choices = choices_of(grammar, start_rule, attributes, style, library)
        opened = Session(
            grammar,
            path,
            seed=seed,
            assets=assets,
            choices=choices,
            stored_grammar=stored_grammar,
            phrase=with_options,
        )

        note_slow_pictures()
        if not stored_grammar:
            source = find_rules(grammar, choices=choices)
            print_if_alike(source.text(), source.suffix)
        opened.listen(_warner())

        try:
            with page_opener(f"scores are saved in {path}; Ctrl-C ends", browser=browser) as announce:
                serve(opened, port, announce)
        except KeyboardInterrupt:
            say(f"ended; the same command continues the session. Scores are in {path}.")
        finally:
            opened.close()


def _warner() -> Send:
    """A listener that prints each warning of a session once."""
    printed_lines: set[str] = set()

    def hear(message: Message, _buffers: Sequence[bytes]) -> None:
        if message.get("event") != "state":
            return
        # Several warnings may have the same hint.
        for line in "\n".join(message["state"]["warnings"]).splitlines():
            if line not in printed_lines:
                printed_lines.add(line)
                say(line)

    return hear
