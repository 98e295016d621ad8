"""Executors of the tasks of a run: chosen once, by the command line, a notebook or a test, and passed down.

A task and its result are values that can be pickled, and the only side effects of a task are files, so that an executor
needs no shared memory, nor the same machine.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from pathlib import Path
from typing import Self, TypeVar

from grammarlab.runs.work.machine import Machine, this_machine
from grammarlab.runs.work.workers import one_thread, variables

Task = TypeVar("Task")
Result = TypeVar("Result")


class AbstractExecutor(ABC):
    """Runs tasks. It is a frozen value: processes exist only during `run`.

    Numerical libraries have one thread during a task, so that results are equal to the last bit for all executors.
    """

    @abstractmethod
    def run(self, work: Callable[[Task], Result], tasks: Iterable[Task], then: Callable[[int, Result], object]) -> None:
        """Run all tasks; no task runs after it returns or raises.

        Args:
            work: a function that other processes can import. It may be called again with a lost task.
            tasks: arguments of the work, consumed lazily, so that they may be many. `str` of a task is its name in
                messages.
            then: called in this process with the index and result of each finished task, in any order.

        Raises:
            WorkerError: If a task has lost its process `grammarlab.runs.work.workers.MAX_ATTEMPTS` times.
            Exception: The first exception of a task or of `then`.
        """

    @abstractmethod
    def share(self, num_tasks: int) -> AbstractExecutor:
        """Executor for use inside parallel tasks: a share of this one."""

    @abstractmethod
    def with_environment(self, values: Mapping[str, str]) -> Self:
        """The same with environment variables for its tasks; libraries may read them only when they are loaded."""

    def in_folder(self, folder: Path) -> Self:  # processes of this machine see it
        """The same for tasks that need the folder of a run (`grammarlab.runs.work.run_folder.only_run_in`).

        Raises:
            UsageError: In `run`, if a worker does not see the folder.
        """
        return self

    def machine(self) -> Machine:
        """Software and class of the processors that do the tasks."""
        return this_machine()

    def results(self, work: Callable[[Task], Result], tasks: Iterable[Task]) -> list[Result]:
        """Results of all tasks, in their order; see `run`."""
        by_index: dict[int, Result] = {}
        self.run(work, tasks, by_index.__setitem__)
        return [by_index[index] for index in range(len(by_index))]


@dataclass(frozen=True, slots=True)
class Serial(AbstractExecutor):
    """One task after the other, in this process."""

    environment: Mapping[str, str] = field(default_factory=dict)
    """Variables of the tasks in addition to those of this process."""

    def run(self, work: Callable[[Task], Result], tasks: Iterable[Task], then: Callable[[int, Result], object]) -> None:
        for index, task in enumerate(tasks):
            with variables(self.environment), one_thread():
                result = work(task)
            then(index, result)

    def share(self, num_tasks: int) -> Serial:
        return self

    def with_environment(self, values: Mapping[str, str]) -> Self:
        return replace(self, environment={**self.environment, **values})


@dataclass(frozen=True, slots=True)
class Processes(AbstractExecutor):
    """Tasks in separate processes on this machine, which end with this one.

    A process that dies is replaced and its task done again. A single task runs in this process, since
    starting another takes longer than most tasks. In a script, use it below ``if __name__ == "__main__":``.

    >>> import grammarlab as gl
    >>> gl.Processes(2).results(abs, [-1, 2, -3])
    [1, 2, 3]
    """

    num_workers: int
    """Number of processes, >= 1."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Variables of the processes in addition to those of this one."""

    def run(self, work: Callable[[Task], Result], tasks: Iterable[Task], then: Callable[[int, Result], object]) -> None:
        source = iter(tasks)
        first = list(islice(source, 2))
        if len(first) < 2:
            Serial(self.environment).run(work, first, then)
        else:
            from grammarlab.runs.work.workforce import Workforce  # noqa: PLC0415  # one task needs no others

            Workforce(work, chain(first, source), then, self.environment).run(self.num_workers)

    def share(self, num_tasks: int) -> AbstractExecutor:
        share = self.num_workers // max(1, num_tasks)
        return replace(self, num_workers=share) if share > 1 else Serial(self.environment)

    def with_environment(self, values: Mapping[str, str]) -> Self:
        return replace(self, environment={**self.environment, **values})


SERIAL = Serial()
