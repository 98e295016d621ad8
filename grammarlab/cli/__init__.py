"""Command line: parses arguments and calls one function per command.

Heavy libraries are imported inside functions, so that ``--help`` and completion answer at once.
"""

import io
import sys
from typing import Any

import typer

from grammarlab.cli.console import INTERRUPTED, say
from grammarlab.cli.interruptions import interruptions_come_again
from grammarlab.runs.work.compiled import keep_compiled

app: typer.Typer
"""The application with all commands, made when it is first asked for."""


def main() -> None:
    """Run the command line."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a terminal or a pipe may not have every character
    try:
        with interruptions_come_again():
            keep_compiled()
            from grammarlab.cli.commands import app_for

            app_for(sys.argv[1:])()
    except KeyboardInterrupt:  # while the commands are made; each command reports an interruption itself
        say("interrupted.")
        raise SystemExit(INTERRUPTED) from None


def __getattr__(name: str) -> Any:
    if name != "app":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from grammarlab.cli.commands import app_for

    globals()["app"] = app_for(())
    return globals()["app"]


__all__ = ["app", "main"]
