"""Output of the command line: results on stdout, everything else on stderr, and exit codes.

Progress bars appear if stderr is a terminal. A command that has stopped prints the command that continues it.
"""

from __future__ import annotations

import json
import platform
import re
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Annotated, Any

import typer

from grammarlab.errors import GrammarlabError, LanguageError, UsageError, WorkerError
from grammarlab.extras import named_extras
from grammarlab.printable import printable

Show = Callable[[str, int, int], None]
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


@contextmanager
def progress(note: Show = lambda _what, _done, _total: None) -> Iterator[Show]:
    """A function that shows progress: the name of the task, the number of finished parts, and the number of all parts.

    Args:
        note: called with the same arguments.
    """
    if not sys.stderr.isatty():
        yield note
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress, ProgressColumn, Task, TaskID
    from rich.text import Text

    class Rate(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(f"{task.speed:,.3g}/s" if task.speed else "")

    columns = (*Progress.get_default_columns(), Rate())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        tasks: dict[str, TaskID] = {}

        def show(task: str, done: int, total: int) -> None:
            if task not in tasks:
                tasks[task] = bars.add_task(escape(printable(task)), total=total)
            bars.update(tasks[task], completed=done)
            note(task, done, total)

        yield show


_ARGUMENT = re.compile(r"`([a-z_]+)=([^`\n]{0,40})`")
"""An argument in a message of the library: ``width=``, ``unit='mm'`` or ``resume=True``, each between backticks."""
_ARGUMENTS = frozenset(
    [
        "assets",
        "box",
        "boxes",
        "columns",
        "corrections",
        "height",
        "jobs",
        "method",
        "no_models",
        "port",
        "resume",
        "rows",
        "split",
        "stored_grammar",
        "templates",
        "unit",
        "up",
        "wall",
        "width",
        "workers",
    ]
)
"""Arguments that are options of the same name."""


def with_options(message: str) -> str:
    """A message of the library with the options of the command line instead of arguments.

    >>> with_options("give `width=` or `unit='mm'`, or leave out `stored_grammar=True`")
    'give --width or --unit mm, or leave out --stored-grammar'
    """
    return _ARGUMENT.sub(_option, message)


def _option(match: re.Match[str]) -> str:
    name, value = match[1], match[2].strip("'")
    if name not in _ARGUMENTS:
        return match[0]
    option = f"--{name.replace('_', '-')}"
    return option if value in {"", "True"} else f"{option} {value}"


def say(message: str) -> None:
    """Print a message on stderr with options for arguments; it may quote files from strangers."""
    typer.echo(printable(with_options(message)), err=True)


def print_result(result: object) -> None:
    """Print a result on stdout: a path, an address or lines that may quote files from strangers."""
    typer.echo(printable(str(result)))


def print_content(text: str) -> None:
    """Write text that another program may read to stdout: as it is, unless stdout is a terminal."""
    typer.echo(printable(text) if sys.stdout.isatty() else text, nl=False)


def print_event(event: str, values: Mapping[str, Any]) -> None:
    """Print one line with a JSON object about what happens, for programs, on stdout at once."""
    typer.echo(json.dumps({"event": event, **values}, allow_nan=False))
    sys.stdout.flush()


def print_json(value: dict[str, Any]) -> None:
    """Print one JSON object on stdout."""
    typer.echo(with_options(json.dumps(value, indent=2, allow_nan=False)))


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
