"""Progress bar on stderr, if stderr is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from grammarlab.printable import printable

Show = Callable[[str, int, int], None]


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
    from rich.progress import Progress, TaskID

    with Progress(console=Console(stderr=True), transient=True) as bars:
        tasks: dict[str, TaskID] = {}

        def show(what: str, done: int, total: int) -> None:
            if what not in tasks:
                tasks[what] = bars.add_task(escape(printable(what)), total=total)
            bars.update(tasks[what], completed=done)
            note(what, done, total)

        yield show
