"""A command line that runs in the process of a test, with the application that the program makes for it."""

from __future__ import annotations

from typer.testing import CliRunner, Result

from grammarlab.cli.commands import app_for


def invoke(*arguments: object) -> Result:
    """What a command did; errors of ours that escape it fail the test.

    Only the command that is called is made, as `grammarlab` does it: making all of them takes longer than most of what
    tests do with one.
    """
    words = [str(argument) for argument in arguments]
    return CliRunner().invoke(app_for(words), words, catch_exceptions=False)
