"""What runs in the workers of a Dask cluster: the function of a run, sent once to each worker, and its tasks."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from time import sleep

from distributed import get_worker
from distributed.diagnostics.plugin import WorkerPlugin
from distributed.worker import Worker

from grammarlab.errors import UsageError
from grammarlab.runs.work.machine import PINNED, Machine, this_machine
from grammarlab.runs.work.run_folder import check_shared
from grammarlab.runs.work.task_answers import answer, failure
from grammarlab.runs.work.workers import one_thread, variables

_WAIT_SECONDS = 10.0
"""Longest time in seconds in which a worker that has joined receives the function of a run."""


class Work(WorkerPlugin):
    """The function of a run, in every worker that the cluster has or will have.

    Args:
        work: the function, pickled.
        folder: current folder of the process that asks: that of tasks, on machines that have it.
        environment: variables during its tasks.
        machine: that of the worker that was asked first.
        shared: folder of a run that the worker must see, if there is one.
    """

    def __init__(
        self, work: bytes, folder: Path, environment: Mapping[str, str], machine: Machine, shared: Path | None = None
    ) -> None:
        self._work, self._folder, self._environment = work, folder, dict(environment)
        self._machine, self._shared = machine, shared
        self.active: set[str] = set()
        """Keys of the tasks that this worker is doing."""

    def setup(self, worker: Worker) -> None:
        """Nothing: the function is imported by its first task, whose errors are reported."""

    def answer(self, key: str, task: bytes) -> bytes:
        """Answer of a task; see `grammarlab.runs.work.task_answers.answer`."""
        self.active.add(key)
        try:
            if difference := _machine().difference(self._machine):
                return failure(UsageError(mixture(get_worker().address, difference)))
            if self._shared is not None:
                check_shared(self._shared)
            with variables(self._environment), one_thread(), _inside(self._folder):
                return answer(self._work, task)
        except UsageError as error:
            return failure(error)
        finally:
            self.active.discard(key)


def mixture(worker: str, difference: str) -> str:
    """Message about a worker that would give other last bits than the first one."""
    return (
        f"the cluster is a mixture: worker {worker} has {difference}, so that results would depend on who makes them. "
        "Start all workers from one environment on one kind of processor. Where only the processors differ, pin "
        f"them in the environment of every worker: {PINNED}"
    )


def do_task(run: str, key: str, task: bytes) -> bytes:
    """Do a task of a run in a worker."""
    worker = get_worker()
    for _ in range(int(_WAIT_SECONDS / 0.1)):
        if isinstance(plugin := worker.plugins.get(run), Work):
            return plugin.answer(key, task)
        sleep(0.1)
    raise RuntimeError(f"worker {worker.address} has not received the function of {run}; its log says why.")


def active_tasks(run: str, dask_worker: Worker) -> list[str]:
    """Keys of the tasks of a run that a worker is doing."""
    plugin = dask_worker.plugins.get(run)
    return sorted(plugin.active) if isinstance(plugin, Work) else []


@contextmanager
def _inside(folder: Path) -> Iterator[None]:
    """The current folder during a block, if this machine has it."""
    before = Path.cwd()
    with suppress(OSError):
        os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


@cache
def _machine() -> Machine:
    return this_machine()
