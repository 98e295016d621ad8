"""Progress of a command on stderr: bars on a terminal, events for programs, a line a minute in a log."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import typer

from grammarlab.cli.console import say
from grammarlab.printable import printable

Show = Callable[[str, int, int], None]
"""Function of the name of a task, the number of finished parts, and the number of all parts."""
_EVENT_SECONDS, _LINE_SECONDS = 1.0, 60.0
"""Seconds between two events, and between two lines of a log."""


@contextmanager
def progress(note: Show = lambda _task, _done, _total: None, *, as_json: bool = False) -> Iterator[Show]:
    """A function that shows progress.

    Args:
        note: called with the same arguments.
        as_json: write events where there is no terminal, one JSON object a line.
    """
    if sys.stderr.isatty():
        with _bars() as draw:
            yield _both(draw, note)
    else:
        yield _both(Pace(_EVENT_SECONDS, _print_event) if as_json else Pace(_LINE_SECONDS, _print_line), note)


def _both(show: Show, note: Show) -> Show:
    def call(task: str, done: int, total: int) -> None:
        show(task, done, total)
        note(task, done, total)

    return call


class Pace:
    """Progress at times, with rate and time left; the end of a task is always shown.

    Args:
        seconds: least time between two calls for a task.
        show: called with the task, the numbers of finished and of all parts, the rate and the seconds left.
    """

    def __init__(self, seconds: float, show: Callable[[str, int, int, float, float | None], None]) -> None:
        self._seconds, self._show = seconds, show
        self._first: dict[str, tuple[float, int]] = {}
        self._done: dict[str, int] = {}
        self._last: dict[str, float] = {}

    def __call__(self, task: str, done: int, total: int) -> None:
        now = time.monotonic()
        if done < self._done.get(task, 0):  # another task of this name
            del self._first[task]
            self._last.pop(task, None)
        self._done[task] = done
        start, before = self._first.setdefault(task, (now, done))
        if done < total and now - self._last.get(task, start - self._seconds) < self._seconds:
            return
        self._last[task] = now
        rate = (done - before) / (now - start) if now > start else 0.0
        self._show(task, done, total, rate, (total - done) / rate if rate else None)


def _print_event(task: str, done: int, total: int, rate: float, seconds_left: float | None) -> None:
    values = {"event": "progress", "task": task, "done": done, "total": total, "per_second": round(rate, 3)}
    left = None if seconds_left is None else round(seconds_left, 1)
    typer.echo(json.dumps({**values, "seconds_left": left}), err=True)
    sys.stderr.flush()


def _print_line(task: str, done: int, total: int, rate: float, seconds_left: float | None) -> None:
    """A line, if the task takes longer than the time between two."""
    if seconds_left:
        say(f"{done:,} of {total:,} {task}, {rate:,.3g} per second, {seconds_left / 60:,.0f} min left")


@contextmanager
def _bars() -> Iterator[Show]:
    """A bar per task, which disappears at the end."""
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
            elif done < bars.tasks[tasks[task]].completed:  # another task of this name: a finished bar stays finished
                bars.reset(tasks[task])
            bars.update(tasks[task], completed=done, total=total, visible=done < total)

        yield show
