"""``grammarlab format``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from grammarlab.cli.console.report import FAILURE, friendly_errors, print_content, say
from grammarlab.errors import UsageError


def format_file(
    file: Annotated[Path, typer.Argument(help="A .cga file.")],
    check: Annotated[
        bool, typer.Option("--check", help="Exit with 1 if the file would change; write nothing.")
    ] = False,
    in_place: Annotated[bool, typer.Option("--in-place", "-i", help="Write the file instead of printing it.")] = False,
) -> None:
    """Print a rule file in the canonical style, comments included."""
    with friendly_errors():
        from grammarlab.files import rewrite_text
        from grammarlab.language.formatting import format_grammar
        from grammarlab.language.grammar import Grammar, read_text

        if check and in_place:
            raise UsageError("--check and --in-place exclude each other.")
        text = read_text(file)
        formatted = format_grammar(Grammar.parse(text, str(file)))
        changed = formatted != text
        if check:
            say(f"{file}: {'would change' if changed else 'is formatted'}")
            raise typer.Exit(FAILURE if changed else 0)
        if not in_place:
            print_content(formatted)
        elif changed:
            rewrite_text(file, formatted)
            say(f"{file}: formatted")
