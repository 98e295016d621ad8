"""What the command line says: results on stdout, everything else on stderr, an exit code for each way to end."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import typer

from grammarlab.errors import GrammarlabError, LanguageError, UsageError, WorkerError
from grammarlab.extras import named_extras

FAILURE, USAGE, INTERRUPTED = 1, 2, 130


def say(message: str) -> None:
    """A line for the person, on stderr."""
    typer.echo(message, err=True)


def print_json(value: dict[str, Any]) -> None:
    """One object on stdout."""
    typer.echo(json.dumps(value, indent=2, allow_nan=False))


@contextmanager
def friendly_errors(advice: Callable[[], str] = str) -> Iterator[None]:
    """Turn what can go wrong into a message and an exit code; a traceback remains for mistakes of ours only.

    Args:
        advice: says how to go on after what is nobody's mistake: an interruption, too little memory, a full disk.
    """
    try:
        with named_extras():
            yield
    except UsageError as error:
        say(f"error: {error}")
        raise typer.Exit(USAGE) from error
    except LanguageError as error:
        say(str(error))  # each finding says that it is an error
        raise typer.Exit(FAILURE) from error
    except WorkerError as error:
        _say_with(advice, f"error: {error}")
        raise typer.Exit(FAILURE) from error
    except GrammarlabError as error:
        say(f"error: {error}")
        raise typer.Exit(FAILURE) from error
    except BrokenPipeError:
        raise  # the reader of a pipe has gone: typer ends quietly
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        _say_with(advice, f"error: {where}{error.strerror or error}")
        raise typer.Exit(FAILURE) from error
    except MemoryError as error:
        _say_with(advice, "error: not enough memory. Try fewer models at a time (--jobs 1) or a smaller footprint.")
        raise typer.Exit(FAILURE) from error
    except KeyboardInterrupt as error:
        _say_with(advice, "interrupted: what is finished stays valid.")
        raise typer.Exit(INTERRUPTED) from error


def _say_with(advice: Callable[[], str], message: str) -> None:
    say(message)
    if words := advice():
        say(words)


def was_given(context: typer.Context, name: str) -> bool:
    """Whether a parameter stands on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"
