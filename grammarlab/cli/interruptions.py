"""Ctrl-C, wherever it falls: in a finaliser of Python as well, or between a lock and its release."""

from __future__ import annotations

import signal
import sys
from _thread import interrupt_main
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Timer, main_thread

import typer

_DELAY = 0.05
"""Seconds until an interruption that Python ignored comes again: what interrupts the hook itself is ignored as well."""


@contextmanager
def interruptions_come_again() -> Iterator[None]:
    """Interrupt again where Python ignores Ctrl-C, as in a finaliser or in the clean-up after an import."""
    before = sys.unraisablehook

    def hook(ignored: sys.UnraisableHookArgs) -> None:
        if ignored.exc_type is KeyboardInterrupt:
            timer = Timer(_DELAY, _interrupt)
            timer.daemon = True
            timer.start()
        else:
            before(ignored)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


@contextmanager
def interruptions_answered(answer: Callable[[str], None]) -> Iterator[None]:
    """Call a function where something is interrupted, with the words of an error that came of it, if one did."""
    try:
        yield
    except typer.Exit:
        raise
    except BaseException as error:
        if not _is_interruption(error):
            raise
        answer("" if isinstance(error, KeyboardInterrupt) else f"{type(error).__name__}: {error}")


def _interrupt() -> None:
    if sys.platform == "win32":
        interrupt_main()
    else:
        signal.pthread_kill(main_thread().ident or 0, signal.SIGINT)  # it wakes a thread that waits


def _is_interruption(error: BaseException | None) -> bool:
    """Whether an error is Ctrl-C or comes of it: the release of a lock fails if it falls before the note of it."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    return error is not None
