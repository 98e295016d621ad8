"""Worker processes for the tasks of one run, one task each at a time; processes that die are replaced."""

from __future__ import annotations

import pickle
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any

from grammarlab.errors import WorkerError
from grammarlab.runs.work.task_answers import EndedError, answer, result_of
from grammarlab.runs.work.workers import (
    MAX_ATTEMPTS,
    UNGUARDED,
    exit_reason,
    is_unguarded,
    report,
    reporting,
    start_worker,
)

GRACE_SECONDS = 2.0
"""Seconds for processes to clean up before they are killed."""
_READY, _REPORT = b"", b"report "
"""Messages of a process: that it waits for its first task, and, before a pickled report, how far its task is."""
_MAX_NAME = 160
"""Largest number of characters of a task in a message."""


@dataclass(eq=False, slots=True)
class _Job:
    """A task, with the number of processes that died during it."""

    index: int
    task: Any
    losses: int = 0


@dataclass(eq=False, slots=True)
class _Worker:
    """A process and its task."""

    process: SpawnProcess
    connection: Connection
    job: _Job
    is_ready: bool = False


class Workforce:
    """The processes of one run.

    Args:
        work: function that does a task.
        tasks: arguments of the work, consumed lazily, one per process.
        then: called with index and result of each.
        environment: variables of the processes in addition to those of this one.
    """

    def __init__(
        self,
        work: Callable[[Any], Any],
        tasks: Iterable[Any],
        then: Callable[[int, Any], object],
        environment: Mapping[str, str],
    ) -> None:
        self._work = pickle.dumps(work)
        self._jobs: Iterator[_Job] = (_Job(index, task) for index, task in enumerate(tasks))
        self._lost: deque[_Job] = deque()
        self._then, self._environment = then, environment
        self._workers: dict[Connection, _Worker] = {}
        self._leaving: list[SpawnProcess] = []
        self._false_starts = 0
        """Number of consecutive processes that died before their first task."""

    def run(self, num_workers: int) -> None:
        """Run all tasks; see `grammarlab.runs.work.executors.AbstractExecutor.run`."""
        try:
            while len(self._workers) < num_workers and (job := self._next()) is not None:
                self._start(job)
            while self._workers:
                heard = wait(list(self._workers))
                for worker in [worker for connection, worker in self._workers.items() if connection in heard]:
                    self._hear(worker)
        finally:
            self._end()

    def _next(self) -> _Job | None:
        return self._lost.popleft() if self._lost else next(self._jobs, None)

    def _start(self, job: _Job) -> None:
        process, connection = start_worker(_do_tasks, (), self._environment)
        self._workers[connection] = _Worker(process, connection, job)

    def _hear(self, worker: _Worker) -> None:
        message = _received(worker)
        if message is None:
            self._replace(worker)
            return
        if message == _READY:
            worker.is_ready, self._false_starts = True, 0
            _send(worker, self._work)
            _send(worker, pickle.dumps(worker.job.task))
            return
        if message.startswith(_REPORT):
            report(*pickle.loads(message.removeprefix(_REPORT)))  # noqa: S301 - of a process that works for this one
            return
        done = worker.job
        job = self._next()
        if job is None:
            self._dismiss(worker)
        else:
            worker.job = job
            _send(worker, pickle.dumps(job.task))
        self._then(done.index, result_of(message))

    def _dismiss(self, worker: _Worker) -> None:
        """Close the connection of a process, which ends it."""
        del self._workers[worker.connection]
        worker.connection.close()
        self._leaving.append(worker.process)

    def _replace(self, worker: _Worker) -> None:
        """Replace a process that has died."""
        self._dismiss(worker)
        worker.process.join()
        if is_unguarded(worker.process):
            raise WorkerError(UNGUARDED)
        job, how = worker.job, exit_reason(worker.process)
        if worker.is_ready:
            job.losses += 1
        else:
            self._false_starts += 1
        if self._false_starts == MAX_ATTEMPTS:
            raise WorkerError(f"processes end as soon as they start ({how}). Try to do without (`jobs=1`).")
        if job.losses == MAX_ATTEMPTS:
            raise WorkerError(
                f"{name_of(job.task)}: the process that worked on it ended unasked, {job.losses} times ({how}). Try "
                "fewer processes at a time (`jobs=1`, `workers=1`) or smaller tasks, such as smaller footprints."
            )
        self._start(job)

    def _end(self) -> None:
        """End running processes: first by a signal that allows them to clean up, then by one that does not."""
        processes = [*self._leaving, *(worker.process for worker in self._workers.values())]
        for worker in self._workers.values():
            worker.connection.close()
            worker.process.terminate()
        end = time.monotonic() + GRACE_SECONDS
        for process in processes:
            process.join(max(0.0, end - time.monotonic()))
        for process in processes:
            process.kill()
            process.join()


def name_of(task: Any) -> str:
    """Name of a task in messages, of bounded length."""
    name = str(task)
    return name if len(name) <= _MAX_NAME else f"{name[:_MAX_NAME]}…"


def _received(worker: _Worker) -> bytes | None:
    """Next message of a process; None if it has ended."""
    try:
        return worker.connection.recv_bytes()
    except (EOFError, OSError):
        return None


def _send(worker: _Worker, message: bytes) -> None:
    # The end of a process is noticed by the end of its connection.
    with suppress(OSError):
        worker.connection.send_bytes(message)


def _do_tasks(connection: Connection) -> None:
    """Main function of a process: run tasks until the connection is closed."""
    signal.signal(signal.SIGTERM, _tidy_up)

    def send(part: str, done: int, total: int) -> None:
        connection.send_bytes(_REPORT + pickle.dumps((part, done, total)))

    with suppress(EndedError, EOFError, OSError), reporting(send):
        try:
            connection.send_bytes(_READY)
            work = connection.recv_bytes()
            while True:
                connection.send_bytes(answer(work, connection.recv_bytes()))
        finally:
            # The process ends anyway, and what the library does at its end must not be interrupted.
            signal.signal(signal.SIGTERM, signal.SIG_IGN)


def _tidy_up(_signal: int, _frame: object) -> None:
    """End the process where it is; if that is in a destructor, when it waits for its next task."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    # Half-made objects and destructors would complain on stderr.
    sys.unraisablehook = lambda _: None
    raise EndedError
