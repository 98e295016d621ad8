"""Output of the command line: results on stdout, everything else on stderr, and exit codes.

A command that has stopped prints the command that continues it; `grammarlab.cli.progress` shows how far it is.
"""

from __future__ import annotations

import json
import platform
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from grammarlab.cli.interruptions import interruptions_answered
from grammarlab.errors import GrammarlabError, LanguageError, UsageError, WorkerError
from grammarlab.extras import named_extras
from grammarlab.option_names import with_options
from grammarlab.printable import printable

FAILURE, USAGE, INTERRUPTED = 1, 2, 130
Scheduler = Annotated[
    str,
    typer.Option(
        "--scheduler",
        help="Address of a Dask scheduler, such as tcp://host:8786: its workers do the work.",
        metavar="URL",
    ),
]
"""Option of commands whose tasks a cluster can do."""
StartRule = Annotated[str, typer.Option("--start", help="Start rule.")]
Attributes = Annotated[
    list[str] | None, typer.Option("--attr", help="Value of an attribute, name=value; may be repeated.")
]
StyleName = Annotated[str, typer.Option("--style", help="Style of a rule file, instead of its default style.")]
Library = Annotated[
    Path | None, typer.Option("--library", help="Folder of further projects, such as ESRI.lib, with rules and assets.")
]
"""Options for what a rule file leaves open."""


def _refuse_footprint(value: str | None) -> str | None:
    if value is not None:
        raise typer.BadParameter(
            "scores are about models where they stand by default: buildings on a lot of 20 x 20 m, trees on a point. "
            "For another lot let the start rule begin with its size, as in "
            "Lot --> s(12, 0, 8) center(xz) extrude(9) Mass. "
            "grammarlab sample makes buildings, also of learned rules, on any lots."
        )
    return value


NoFootprint = Annotated[
    str | None,
    typer.Option("--footprint", hidden=True, callback=_refuse_footprint, help="Refused with what to do instead."),
]
"""An option of `sample` that others are asked for."""


@dataclass
class Unfinished:
    """Progress of a run, recorded by `note` and described by `advice` when the run stops."""

    needs: str = ""
    """Option that makes the command continue; empty if it always does."""
    without: str = ""
    """Option that would make the command start again."""
    _step: tuple[str, int, int] | None = None

    def note(self, task: str, done: int, total: int) -> None:
        """Record the name of the task, the number of finished parts, and the number of all parts."""
        self._step = task, done, total

    def advice(self) -> str:
        """The command that continues the run, with the options of the user; empty before the run has begun."""
        if self._step is None:
            return ""
        task, done, total = self._step
        words = [word for word in sys.argv[1:] if word != self.without]
        if self.needs and self.needs not in words:
            words.insert(words.index("--") if "--" in words else len(words), self.needs)
        return f"stopped with {done:,} of {total:,} {task} done; go on with: {shlex.join(['grammarlab', *words])}"


def say(message: str) -> None:
    """Print a message on stderr with options for arguments; it may quote files from strangers."""
    typer.echo(printable(with_options(message)), err=True)


def print_result(result: object) -> None:
    """Print a result on stdout: a path, an address or lines that may quote files from strangers."""
    typer.echo(printable(str(result)))


def print_content(text: str) -> None:
    """Write text that another program may read to stdout: as it is, unless stdout is a terminal."""
    typer.echo(printable(text) if sys.stdout.isatty() else text, nl=False)


def print_json(value: dict[str, Any]) -> None:
    """Print one JSON object on stdout."""
    typer.echo(with_options(json.dumps(value, indent=2, allow_nan=False)))


@contextmanager
def friendly_errors(advice: Callable[[], str] = str) -> Iterator[None]:
    """Turn expected errors into a message and an exit code; only bugs of grammarlab show a traceback.

    Args:
        advice: returns how to continue after an interruption, too little memory or a full disk.
    """

    def interrupted(words: str) -> None:
        _say_with(advice, "interrupted: finished files stay valid." + (f" ({words})" if words else ""))
        raise typer.Exit(INTERRUPTED)

    try:
        with interruptions_answered(interrupted), named_extras():
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


def was_given(context: typer.Context, name: str) -> bool:
    """Whether a parameter was given on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def note_slow_pictures() -> None:
    """Print a note if pictures are cast without Embree on this machine."""
    from grammarlab.rendering.light.rays import has_embree

    if not has_embree():
        machine = f"{platform.system()} on {platform.machine()}"
        say(
            f"Pictures take about ten times longer here: the package embreex is not installed (for {machine} there may "
            "be none). They are the same as elsewhere. Where OpenGL works, `grammarlab sample --renderer gl` is faster."
        )


def _say_with(advice: Callable[[], str], message: str) -> None:
    say(message)
    if words := advice():
        say(words)
