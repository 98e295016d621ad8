"""Output of the command line: results on stdout, everything else on stderr, and exit codes."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import typer

from grammarlab.errors import GrammarlabError, LanguageError, UsageError, WorkerError
from grammarlab.extras import named_extras
from grammarlab.printable import printable

FAILURE, USAGE, INTERRUPTED = 1, 2, 130


def say(message: str) -> None:
    """Print a message on stderr; it may quote files from strangers."""
    typer.echo(printable(message), err=True)


def print_result(result: object) -> None:
    """Print a result on stdout: a path, an address or lines that may quote files from strangers."""
    typer.echo(printable(str(result)))


def print_content(text: str) -> None:
    """Write text that another program may read to stdout: as it is, unless stdout is a terminal."""
    typer.echo(printable(text) if sys.stdout.isatty() else text, nl=False)


def print_json(value: dict[str, Any]) -> None:
    """Print one JSON object on stdout."""
    typer.echo(json.dumps(value, indent=2, allow_nan=False))


@contextmanager
def friendly_errors(advice: Callable[[], str] = str) -> Iterator[None]:
    """Turn expected errors into a message and an exit code; only bugs of grammarlab show a traceback.

    Args:
        advice: returns how to continue after an interruption, too little memory or a full disk.
    """
    try:
        with named_extras():
            yield
    except UsageError as error:
        say(f"error: {error}")
        raise typer.Exit(USAGE) from error
    except LanguageError as error:
        say(str(error))  # each finding already names its severity
        raise typer.Exit(FAILURE) from error
    except WorkerError as error:
        _say_with(advice, f"error: {error}")
        raise typer.Exit(FAILURE) from error
    except GrammarlabError as error:
        say(f"error: {error}")
        raise typer.Exit(FAILURE) from error
    except BrokenPipeError:
        raise  # the reader of the pipe has closed it: typer exits without a message
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        _say_with(advice, f"error: {where}{error.strerror or error}")
        raise typer.Exit(FAILURE) from error
    except MemoryError as error:
        _say_with(advice, "error: not enough memory. Try fewer models at a time (--jobs 1) or a smaller footprint.")
        raise typer.Exit(FAILURE) from error
    except KeyboardInterrupt as error:
        _say_with(advice, "interrupted: finished files stay valid.")
        raise typer.Exit(INTERRUPTED) from error


def _say_with(advice: Callable[[], str], message: str) -> None:
    say(message)
    if words := advice():
        say(words)


def was_given(context: typer.Context, name: str) -> bool:
    """Whether a parameter was given on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"
