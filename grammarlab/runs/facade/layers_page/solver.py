"""Layouts that are solved for beside what windows ask: one at a time, and always the latest that is wished for."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from threading import Condition, Thread

from grammarlab.errors import GrammarlabError
from grammarlab.facade.layers.designs.design import Design
from grammarlab.facade.layers.layouts import layouts
from grammarlab.facade.layers.solving import Layout

_PATIENCE = 0.4
"""Seconds that the best layout of a canvas is waited for while others are wished for already."""


@dataclass(frozen=True, eq=False)
class Job:
    """A design that is to be laid out."""

    design: Design
    width: float
    """Metres."""
    height: float
    """Metres."""
    counts: tuple[int, ...]
    """Layouts at most, one time after the other, ascending."""


@dataclass(frozen=True, eq=False)
class SolverOutcome:
    """What became of a job."""

    job: Job
    count: int
    """Layouts at most."""
    layouts: tuple[Layout, ...]
    """Best first; empty when there are none."""
    error: str
    """Why there are none, else empty."""


class Solver:
    """A thread that solves."""

    def __init__(self, done: Callable[[SolverOutcome], None]) -> None:
        """Begins.

        Args:
            done: gets each outcome, on the solver's thread.
        """
        self._done = done
        self._changed = Condition()
        self._wanted: Job | None = None
        self._ended = False
        Thread(target=self._run, daemon=True).start()

    def want(self, job: Job) -> None:
        """Solves this next; what was wanted before is left out, unless it is almost done."""
        with self._changed:
            self._wanted = job
            self._changed.notify()

    def close(self) -> None:
        """Begins nothing more."""
        with self._changed:
            self._ended = True
            self._changed.notify()

    def _next(self) -> Job | None:
        with self._changed:
            self._changed.wait_for(lambda: self._ended or self._wanted)
            job, self._wanted = self._wanted, None
            return None if self._ended else job

    def _run(self) -> None:
        while job := self._next():
            for turn, count in enumerate(job.counts):
                stop = partial(self._is_overtaken, time.monotonic() + (0.0 if turn else _PATIENCE))
                found = outcome(job, count, stop)
                if stop():
                    break
                self._done(found)
                if self._wanted or not found.layouts:
                    break

    def _is_overtaken(self, patient_until: float) -> bool:
        return self._ended or (self._wanted is not None and time.monotonic() > patient_until)


def outcome(job: Job, count: int, stop: Callable[[], bool] = lambda: False) -> SolverOutcome:
    """Solves now; what it finds after `stop` said so may be anything."""
    try:
        return SolverOutcome(job, count, tuple(layouts(job.design, job.width, job.height, count, stop=stop)), "")
    except GrammarlabError as error:
        return SolverOutcome(job, count, (), str(error))
    except Exception as error:  # a mistake of ours must not end the solver
        traceback.print_exc()
        return SolverOutcome(job, count, (), f"unexpected {type(error).__name__}: {error}. Please report it.")
