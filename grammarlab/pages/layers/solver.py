"""A solver in the background: one job at a time, always the latest request."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from threading import Condition, Thread

from grammarlab.errors import GrammarlabError
from grammarlab.layers.design import Design
from grammarlab.layers.layouts import layouts
from grammarlab.layers.solving import Layout

_BEST_SECONDS = 0.4
"""Time that the best layout of a canvas may take while other requests wait, seconds."""


@dataclass(frozen=True, eq=False)
class Job:
    """A design to lay out."""

    design: Design
    width: float
    """Width of the canvas, metres."""
    height: float
    """Height of the canvas, metres."""
    counts: tuple[int, ...]
    """Largest numbers of layouts of consecutive solutions, ascending."""


@dataclass(frozen=True, eq=False)
class SolverOutcome:
    """Result of a job."""

    job: Job
    count: int
    """Largest number of layouts."""
    layouts: tuple[Layout, ...]
    """Layouts, best first; empty if there are none."""
    error: str
    """Reason why there are none, else empty."""


class Solver:
    """A thread that solves jobs."""

    def __init__(self, done: Callable[[SolverOutcome], None]) -> None:
        """Starts the thread.

        Args:
            done: receives each outcome, on the solver's thread.
        """
        self._done = done
        self._condition = Condition()
        self._next_job: Job | None = None
        self._is_closed = False
        Thread(target=self._run, daemon=True).start()

    def submit(self, job: Job) -> None:
        """Requests a job as the next one; earlier requests are dropped, unless one is almost done."""
        with self._condition:
            self._next_job = job
            self._condition.notify()

    def close(self) -> None:
        """Starts no further jobs."""
        with self._condition:
            self._is_closed = True
            self._condition.notify()

    def _next(self) -> Job | None:
        with self._condition:
            self._condition.wait_for(lambda: self._is_closed or self._next_job)
            job, self._next_job = self._next_job, None
            return None if self._is_closed else job

    def _run(self) -> None:
        while job := self._next():
            for turn, count in enumerate(job.counts):
                stop = partial(self._is_overtaken, time.monotonic() + (0.0 if turn else _BEST_SECONDS))
                result = outcome(job, count, stop)
                if stop():
                    break
                self._done(result)
                if self._next_job or not result.layouts:
                    break

    def _is_overtaken(self, patient_until: float) -> bool:
        return self._is_closed or (self._next_job is not None and time.monotonic() > patient_until)


def outcome(job: Job, count: int, stop: Callable[[], bool] = lambda: False) -> SolverOutcome:
    """Solves a job; after `stop` returned true, the result is arbitrary."""
    try:
        return SolverOutcome(job, count, tuple(layouts(job.design, job.width, job.height, count, stop=stop)), "")
    except GrammarlabError as error:
        return SolverOutcome(job, count, (), str(error))
    except Exception as error:  # an internal error must not end the solver
        traceback.print_exc()
        return SolverOutcome(job, count, (), f"unexpected {type(error).__name__}: {error}. Please report it.")
