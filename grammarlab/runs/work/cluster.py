"""Tasks in the workers of a Dask cluster, which users start by Dask's own means (extra `cluster`).

Dask starts a task again whose worker has died, moves tasks between workers, and lets workers come and go. What it
leaves open is here: workers must be alike, a lost scheduler is an error, and a task that kills its workers is named.
"""

from __future__ import annotations

import pickle
import secrets
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Self

from distributed import Client, Future, KilledWorker, as_completed

from grammarlab.errors import WorkerError
from grammarlab.runs.work.cluster_connection import NO_WORKERS_SECONDS, Connection, check_threads, connected, no_workers
from grammarlab.runs.work.cluster_worker import Work, active_tasks, do_task
from grammarlab.runs.work.executors import AbstractExecutor, Result, Serial, Task
from grammarlab.runs.work.machine import Machine
from grammarlab.runs.work.task_answers import result_of
from grammarlab.runs.work.workforce import name_of

TASKS_PER_THREAD = 3
"""Tasks that are submitted per thread of the cluster: a worker that has finished one finds the next."""
_LEAVE_SECONDS = 5.0
"""Seconds in which the scheduler must answer at the end."""
_LOOK_SECONDS = 5.0
"""Seconds between looks at the cluster."""
_STALL_SECONDS = 60.0
"""Seconds without results after which workers are asked whether they are doing anything."""
_MAX_STALLS = 3
"""Largest number of connections in a row in which nothing is done."""


@dataclass(frozen=True, slots=True)
class Cluster(AbstractExecutor):
    """Tasks in the workers of a Dask cluster; files of tasks are in folders or stores that all workers share.

    Workers do one task at a time each (``--nthreads 1``). A task that runs when `run` raises ends by itself: Dask
    cannot interrupt it, so files of tasks must be whole at any time.
    """

    address: str
    """Address of the scheduler: ``tcp://host:8786``."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Variables of the tasks in addition to those of the workers."""
    folder: Path | None = None
    """Folder of a run that all workers must see."""
    notice: Callable[[str], object] = field(default=str, compare=False, repr=False)
    """Called with a message while nothing can be done, such as that there are no workers."""

    def run(self, work: Callable[[Task], Result], tasks: Iterable[Task], then: Callable[[int, Result], object]) -> None:
        _Run(self, work, tasks, then).run()

    def share(self, num_tasks: int) -> Serial:
        return Serial(self.environment)

    def with_environment(self, values: Mapping[str, str]) -> Self:
        return replace(self, environment={**self.environment, **values})

    def in_folder(self, folder: Path) -> Self:
        return replace(self, folder=folder.absolute())

    def machine(self) -> Machine:
        with connected(self.address) as connection:
            return connection.machine(self.notice)


def cluster_at(address: str, notice: Callable[[str], object] = str) -> Cluster:
    """Cluster of a scheduler that answers.

    Args:
        address: as in `Cluster`.
        notice: called with the address of the dashboard, and as in `Cluster`.

    Raises:
        UsageError: If there is no scheduler at the address.
    """
    with connected(address) as connection:
        dashboard = connection.dashboard() or "none"
        notice(f"cluster at {address}: {len(connection.threads()):,} workers; dashboard: {dashboard}")
    return Cluster(address, notice=notice)


@dataclass(eq=False, slots=True)
class _Job:
    """A task that is not finished."""

    index: int
    task: Any
    is_suspect: bool = False
    """Whether its workers have died, perhaps for another task on the same worker."""


class _Run:
    """The tasks of one run on a cluster."""

    def __init__(
        self,
        cluster: Cluster,
        work: Callable[[Any], Any],
        tasks: Iterable[Any],
        then: Callable[[int, Any], object],
    ) -> None:
        self._cluster, self._then = cluster, then
        self._work = pickle.dumps(work)
        self._source: Iterator[_Job] = (_Job(index, task) for index, task in enumerate(tasks))
        self._waiting: deque[_Job] = deque()
        """Jobs to do before those of the source."""
        self._submitted: dict[Future, _Job] = {}
        self._name = ""
        self._window = 1
        self._heard = self._looked = self._crowded = time.monotonic()
        """Times of the last result, of the last look, and at which there were workers."""
        self._is_said = False
        self._idle_looks = 0

    def run(self) -> None:
        """Do all tasks; see `grammarlab.runs.work.executors.AbstractExecutor.run`."""
        first = next(self._source, None)
        if first is None:
            return
        self._waiting.append(first)
        stalls = 0
        while self._waiting or self._submitted:
            before = self._heard
            with connected(self._cluster.address) as connection:
                self._use(connection)
            stalls = 0 if self._heard != before else stalls + 1
            if stalls == _MAX_STALLS:
                raise WorkerError(
                    f"the workers of {self._cluster.address} do nothing. Start scheduler and workers again."
                )

    def _use(self, connection: Connection) -> None:
        """Do tasks until all are done, or nothing is being done any more."""
        client, machine = connection.client, connection.machine(self._cluster.notice)
        self._name = f"grammarlab_{secrets.token_hex(4)}"
        cluster = self._cluster
        work = Work(self._work, Path.cwd(), cluster.environment, machine, cluster.folder)
        connection.send_plugin(work, self._name)
        completed: as_completed = as_completed(loop=client.loop, with_results=True, raise_errors=False)
        self._look(connection)
        try:
            while self._fill(client, completed):
                for future, result in _ready(completed):
                    self._hear(connection, future, result)
                if self._is_stalled(connection):
                    self._cluster.notice("no worker is doing anything: connecting again")
                    self._waiting.extendleft(reversed(self._submitted.values()))
                    return
        finally:
            self._leave(connection)

    def _fill(self, client: Client, completed: as_completed) -> bool:
        """Submit tasks while there is room; returns whether any is unfinished. A suspect is alone."""
        while len(self._submitted) < self._window:
            if any(job.is_suspect for job in self._submitted.values()):
                break
            if self._submitted and self._waiting and self._waiting[0].is_suspect:
                break
            job = self._waiting.popleft() if self._waiting else next(self._source, None)
            if job is None:
                break
            key = f"{self._name}-{job.index}-{secrets.token_hex(4)}"
            future = client.submit(do_task, self._name, key, pickle.dumps(job.task), key=key, pure=False)
            self._submitted[future] = job
            completed.add(future)
        return bool(self._submitted)

    def _hear(self, connection: Connection, future: Future, result: Any) -> None:
        job = self._submitted.pop(future)
        self._heard, self._idle_looks = time.monotonic(), 0
        # A result that is here counts, though its worker may have been given up since, and its task begun again.
        if isinstance(result, bytes):
            self._then(job.index, result_of(result))
            return
        if future.status != "error":
            raise connection.lost()
        _, error, _ = result
        if not isinstance(error, KilledWorker):
            raise error
        if job.is_suspect:
            raise WorkerError(
                f"{name_of(job.task)}: the worker that did nothing else died, {error.allowed_failures + 1} times. It "
                "may need more memory than a worker has: give workers more, or make tasks smaller. If machines are "
                "taken away often, start the scheduler with DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES=10."
            )
        self._waiting.append(replace(job, is_suspect=True))

    def _is_stalled(self, connection: Connection) -> bool:
        """Look at the cluster from time to time; returns whether twice no worker was doing anything.

        A scheduler may take a task for running whose worker has lost it (dask/distributed issue 3196).
        """
        now = time.monotonic()
        connection.check()
        if now - self._looked < _LOOK_SECONDS:
            return False
        workers = self._look(connection)
        if not workers or now - self._heard < _STALL_SECONDS * (1 + self._idle_looks):
            return False
        active = connection.from_workers(partial(active_tasks, self._name), self._cluster.notice)
        # A silent worker may be doing its task; Dask gives that to another one when it gives the worker up.
        is_active = any(isinstance(keys, TimeoutError) or (isinstance(keys, list) and keys) for keys in active.values())
        self._idle_looks = 0 if is_active else self._idle_looks + 1
        self._heard = self._heard if self._idle_looks else now
        return self._idle_looks == 2

    def _look(self, connection: Connection) -> bool:
        """Adapt the window to the cluster; returns whether there are workers."""
        threads = connection.threads()
        check_threads(threads)
        self._window = max(1, TASKS_PER_THREAD * sum(threads.values()))
        self._looked = time.monotonic()
        if threads:
            self._crowded, self._is_said = self._looked, False
        elif self._looked - self._crowded > NO_WORKERS_SECONDS and not self._is_said:
            self._cluster.notice(no_workers(self._cluster.address))
            self._is_said = True
        return bool(threads)

    def _leave(self, connection: Connection) -> None:
        """Forget the tasks, as the scheduler does when the connection is closed, and the function of the run."""
        self._submitted.clear()
        with suppress(WorkerError):
            connection.ask("unregister_worker_plugin", _LEAVE_SECONDS, name=self._name)


def _ready(completed: as_completed) -> list[tuple[Future, Any]]:
    """Finished tasks; none after a short while without."""
    if not completed.has_ready():
        with completed.thread_condition:
            completed.thread_condition.wait(0.1)
    return completed.next_batch(block=False)
