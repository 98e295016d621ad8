"""Command line: parses arguments and calls one function per command.

Heavy libraries are imported inside functions, so that ``--help`` and completion answer at once.
"""

import io
import sys

from grammarlab.cli.app import app
from grammarlab.cli.console import INTERRUPTED, say
from grammarlab.runs.work.compiled import keep_compiled


def main() -> None:
    """Run the command line."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a terminal or a pipe may not have every character
    try:
        keep_compiled()
        app()
    except KeyboardInterrupt:  # while the commands are made; each command reports an interruption itself
        say("interrupted.")
        raise SystemExit(INTERRUPTED) from None


__all__ = ["app", "main"]
