"""Command line: parses arguments and calls one function per command.

Heavy libraries are imported inside functions, so that ``--help`` and completion answer at once.
"""

from grammarlab.cli.app import app
from grammarlab.runs.work.compiled import keep_compiled


def main() -> None:
    """Run the command line."""
    keep_compiled()
    app()


__all__ = ["app", "main"]
