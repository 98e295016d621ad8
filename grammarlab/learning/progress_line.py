"""Progress of learning: one line on a terminal, or below a cell of a notebook."""

from __future__ import annotations

import html
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any, Literal, TextIO, TypeAlias

from grammarlab.density.targets.rejection import Progress, silent
from grammarlab.errors import UsageError

ProgressOption: TypeAlias = Progress | Literal["auto"] | None
"""A function from the name of a stage, the number of its parts that are done, and the number of all, 0 if unknown; or
``auto``, a line on a terminal or in a notebook; or None for nothing."""

WRITING = "writing the file"
"""Last stage of learning: a learned grammar is made and written."""
LAST_REPORT = WRITING, 1, 1
"""Last report where scores become a file: then the file is written, whoever cancels it."""

_INTERVAL = 0.1
"""Seconds between two drawings of the line."""
_CELLS = 24
"""Characters of the bar."""


@contextmanager
def shown_progress(progress: ProgressOption) -> Iterator[Progress]:
    """Function that shows progress until the end of the block.

    Raises:
        UsageError: If the option is neither a function, nor ``auto``, nor None.
    """
    if progress is None:
        yield silent
    elif progress == "auto":
        write = _notebook_line() or _terminal_line(sys.stderr)
        if write is None:
            yield silent
            return
        line = _Line(write)
        try:
            yield line.show
        finally:
            line.end()
    elif callable(progress):
        yield progress
    else:
        raise UsageError(f"progress: expected 'auto', None or a function such as print, found {progress!r:.60}.")


class _Line:
    """A line that changes, drawn at most every `_INTERVAL` seconds; the last state of each stage is always drawn."""

    def __init__(self, write: Callable[[str], None]) -> None:
        self._write = write
        self._begun = perf_counter()
        self._drawn_at, self._stage, self._past = 0.0, "", list[str]()

    def show(self, stage: str, done: int, total: int) -> None:
        now = perf_counter()
        if stage == self._stage and done != total and now - self._drawn_at < _INTERVAL:
            return
        self._drawn_at, self._stage = now, stage
        seconds = f"{now - self._begun:.0f} s"
        if not total:
            self._write(f"{stage}: {done}, {seconds}" if done else f"{stage}, {seconds}")
            return
        filled = _CELLS * min(done, total) // total
        self._write(f"{stage}: {done}/{total} |{'█' * filled}{' ' * (_CELLS - filled)}| {seconds}")

    def end(self) -> None:
        self._write("")


def _terminal_line(stream: TextIO | None) -> Callable[[str], None] | None:
    """Function that replaces the last line of a terminal; None for other streams, such as log files."""
    if stream is None or not stream.isatty():
        return None

    def write(text: str) -> None:
        stream.write(f"\r\x1b[2K{text}")
        stream.flush()

    return write


def _notebook_line() -> Callable[[str], None] | None:
    """Function that replaces a line below the cell that runs; None outside notebooks."""
    ipython = sys.modules.get("IPython")
    shell: Any = ipython.get_ipython() if ipython is not None else None
    if shell is None or not hasattr(shell, "kernel"):
        return None
    from IPython.display import HTML, display  # noqa: PLC0415  # there is a notebook, so it is imported already

    handle: Any = display(HTML(""), display_id=True)

    def write(text: str) -> None:
        handle.update(HTML(f"<pre style='margin:0'>{html.escape(text)}</pre>" if text else ""))

    return write
