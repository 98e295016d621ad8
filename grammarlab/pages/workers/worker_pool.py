"""Long-lived worker processes of a session, which end with it in any case."""

from __future__ import annotations

import os
import traceback
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from ctypes import c_ulonglong
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import import_module
from itertools import count
from multiprocessing.connection import Connection
from multiprocessing.sharedctypes import RawValue
from threading import Thread
from typing import Any

from grammarlab.errors import GrammarlabError
from grammarlab.runs.work.workers import MAX_ATTEMPTS, UNGUARDED, exit_reason, is_unguarded, start_worker

_END_SECONDS = 5.0
"""Seconds to wait for the end of a process."""

Report = Callable[[str, int, int], None]
"""Function called with a stage, the number of finished parts, and that of all parts. It ends a cancelled task."""
Handler = Callable[[Any, Report], Any]


@dataclass(frozen=True, slots=True)
class TaskOutcome:
    """Outcome of a task."""

    value: Any = None
    error: str = ""
    """Error message; empty if it succeeded."""
    cancelled: bool = False


@dataclass(frozen=True, slots=True)
class PendingTask:
    """A task for another process."""

    ticket: int
    request: Any
    then: Callable[[TaskOutcome], None]
    on_progress: Report | None
    is_wanted: Callable[[], bool]
    """Called before it begins; the task is dropped if it returns False."""
    losses: int = 0
    """Number of processes that died during it."""


@dataclass(eq=False)
class _WorkerProcess:
    """A process and its task."""

    process: Any
    connection: Connection
    cancelled: Any
    """Tasks with tickets up to this one are cancelled."""
    listener: Thread = field(default_factory=Thread)
    task: PendingTask | None = None


@dataclass
class WorkerPool:
    """Processes that run tasks, one each at a time. All methods and callbacks are for one thread."""

    make: str
    """``package.module:function``: called in each process, it returns the function that does the tasks."""
    arguments: tuple[Any, ...]
    """Arguments of that function."""
    size: int
    """Number of processes."""
    deliver: Callable[[Callable[[], None]], None]
    """Called from other threads with a function to run on the pool's thread."""
    politeness: int = 0
    """Increment of the processes' nice value."""
    recall: Any = None
    """A request that restores the state of a replaced process; None for none."""
    _workers: list[_WorkerProcess] = field(default_factory=list)
    _waiting: deque[PendingTask] = field(default_factory=deque)
    _tickets: count[int] = field(default_factory=lambda: count(1))
    _is_closed: bool = False
    _is_held: bool = False

    def start(self) -> None:
        """Start missing processes, and return before they are ready."""
        while len(self._workers) < self.size and not self._is_closed:
            cancelled = RawValue(c_ulonglong, 0)
            work = (cancelled, self.politeness, self.make, self.arguments)
            worker = _WorkerProcess(*start_worker(_work, work, outlives=True), cancelled)
            worker.listener = Thread(target=self._listen, args=(worker,), daemon=True)
            worker.listener.start()
            self._workers.append(worker)
            if self.recall is not None:
                _give(worker, PendingTask(next(self._tickets), self.recall, _ignore, None, lambda: True))

    def submit(
        self,
        request: Any,
        then: Callable[[TaskOutcome], None],
        *,
        on_progress: Report | None = None,
        is_wanted: Callable[[], bool] = lambda: True,
        first: bool = False,
    ) -> int:
        """Submit a task.

        Args:
            request: argument of the processes' function.
            then: called with the outcome, unless the task is dropped.
            on_progress: called with the progress.
            is_wanted: called before it begins.
            first: whether it goes before all waiting tasks.

        Returns:
            A ticket for `cancel`.
        """
        task = PendingTask(next(self._tickets), request, then, on_progress, is_wanted)
        (self._waiting.appendleft if first else self._waiting.append)(task)
        self.start()
        self._dispatch()
        return task.ticket

    def cancel(self, ticket: int) -> None:
        """Cancel a task, which ends at once; its process continues until its next report."""
        for task in self._waiting:
            if task.ticket == ticket:
                self._waiting.remove(task)
                task.then(TaskOutcome(cancelled=True))
                return
        for worker in self._workers:
            task = worker.task
            if task is not None and task.ticket == ticket:
                worker.cancelled.value = ticket
                worker.task = replace(task, then=_ignore, on_progress=None, is_wanted=lambda: False)
                task.then(TaskOutcome(cancelled=True))

    def close(self) -> None:
        """End the processes; tasks are dropped."""
        self._is_closed = True
        self._waiting.clear()
        for worker in self._workers:
            worker.process.terminate()
        for worker in self._workers:
            worker.process.join(_END_SECONDS)
            worker.listener.join(_END_SECONDS)

    @contextmanager
    def held(self) -> Iterator[None]:
        """Begin no task meanwhile, so that of several that are submitted in front the last one begins first."""
        self._is_held = True
        try:
            yield
        finally:
            self._is_held = False
            self._dispatch()

    def _dispatch(self) -> None:
        if self._is_held:
            return
        for worker in list(self._workers):
            while worker.task is None and self._waiting and not self._is_closed:
                task = self._waiting.popleft()
                if task.is_wanted():
                    _give(worker, task)

    def _listen(self, worker: _WorkerProcess) -> None:
        """Forward the messages of a process, in a separate thread.

        Only this thread closes the connection, since it reads from it.
        """
        with worker.connection, suppress(EOFError, OSError):
            while True:
                self.deliver(partial(self._hear, worker, worker.connection.recv()))
        self.deliver(partial(self._lose, worker))

    def _hear(self, worker: _WorkerProcess, message: tuple[str, Any]) -> None:
        kind, value = message
        task = worker.task
        if task is None or self._is_closed:
            return
        if kind == "progress":
            if task.on_progress is not None:
                task.on_progress(*value)
            return
        worker.task = None
        task.then(value)
        self._dispatch()

    def _lose(self, worker: _WorkerProcess) -> None:
        """Handle the end of a process: another one does its task. An idle one is replaced with the next task."""
        if self._is_closed or worker not in self._workers:
            return
        self._workers.remove(worker)
        task = worker.task
        if task is None:
            return
        worker.process.join(_END_SECONDS)
        if is_unguarded(worker.process):
            task.then(TaskOutcome(error=UNGUARDED))
        elif task.request is self.recall:
            self.recall = None
        elif task.losses + 1 < MAX_ATTEMPTS:
            self._waiting.appendleft(replace(task, losses=task.losses + 1))
        else:
            task.then(TaskOutcome(error=_lost(exit_reason(worker.process))))
        if self._waiting:
            self.start()
            self._dispatch()


def _lost(how: str) -> str:
    return (
        f"Processes that worked for the session have ended unasked, {MAX_ATTEMPTS} times with the same task ({how}). "
        "Close other programs if memory is short, and try again."
    )


def _give(worker: _WorkerProcess, task: PendingTask) -> None:
    worker.task = task
    # The listener notices the end of a process.
    with suppress(OSError):
        worker.connection.send((task.ticket, task.request))


def _ignore(_outcome: TaskOutcome) -> None:
    """Outcome of a cancelled task."""


class _CancelledError(Exception):
    """Raised in a cancelled task."""


def _work(connection: Connection, cancelled: Any, politeness: int, make: str, arguments: tuple[Any, ...]) -> None:
    """Main function of a process: run tasks until the pipe is closed."""
    if politeness and hasattr(os, "nice"):
        os.nice(politeness)
    with suppress(EOFError, OSError):
        module, _, name = make.partition(":")
        try:
            handler: Handler = getattr(import_module(module), name)(*arguments)
        except GrammarlabError as error:
            handler = partial(_refuse, str(error))
        while True:
            ticket, request = connection.recv()

            def report(stage: str, done: int, total: int, ticket: int = ticket) -> None:
                if cancelled.value == ticket:
                    raise _CancelledError
                connection.send(("progress", (stage, done, total)))

            connection.send(("done", _outcome(handler, request, report)))


def _refuse(reason: str, _request: Any, _report: Report) -> None:
    raise GrammarlabError(reason)


def _outcome(handler: Handler, request: Any, report: Report) -> TaskOutcome:
    try:
        return TaskOutcome(handler(request, report))
    except _CancelledError:
        return TaskOutcome(cancelled=True)
    except GrammarlabError as error:
        return TaskOutcome(error=str(error))
    except Exception as error:  # a bug must not lose the state of the process
        traceback.print_exc()
        return TaskOutcome(error=f"unexpected {type(error).__name__}: {error}. Please report it.")
