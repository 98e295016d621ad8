"""Who does the tasks of a run: chosen once, by the command line, a notebook or a test, and handed down.

A task and its result are values that can be pickled, and a task leaves nothing behind but files, so that whoever does
it may share no memory with the run, nor the machine.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from typing import Self, TypeVar

from grammarlab.runs.work.workers import available_cores, one_thread, variables
from grammarlab.runs.work.workforce import Workforce

Task = TypeVar("Task")
Result = TypeVar("Result")


class AbstractExecutor(ABC):
    """Does tasks. A frozen value: nothing runs but during `run`.

    Numerical libraries have one thread during a task, so that results are equal to the last bit whoever does it.
    """

    @abstractmethod
    def run(self, work: Callable[[Task], Result], tasks: Iterable[Task], then: Callable[[int, Result], object]) -> None:
        """Does all tasks; when this ends, however that is, nothing is being done any more.

        Args:
            work: a function that other processes can import. It may be called again with a task that was lost.
            tasks: its arguments, taken as there is room for them, so that they may be many. What `str` makes of one
                names it in messages.
            then: gets the place of a task and its result, here, as soon as that is there, in any order.

        Raises:
            WorkerError: a task has lost its process `grammarlab.runs.work.workers.MAX_ATTEMPTS` times.
            Exception: whatever a task, or `then`, raises first.
        """

    @abstractmethod
    def share(self, num_tasks: int) -> AbstractExecutor:
        """An executor for the inside of some tasks that are done side by side: its part of this one."""

    @abstractmethod
    def with_environment(self, values: Mapping[str, str]) -> Self:
        """The same with environment variables for its tasks; libraries may look at them only when they are loaded."""

    def results(self, work: Callable[[Task], Result], tasks: Iterable[Task]) -> list[Result]:
        """The results of all tasks, in their order; for the rest as `run`."""
        found: dict[int, Result] = {}
        self.run(work, tasks, found.__setitem__)
        return [found[index] for index in range(len(found))]


@dataclass(frozen=True, slots=True)
class Serial(AbstractExecutor):
    """One task after the other, in this process."""

    environment: Mapping[str, str] = field(default_factory=dict)
    """Variables of the tasks besides those of this process."""

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
    """Tasks in processes of their own on this machine, which end with this one.

    A process that dies is replaced and its task done again. Of a single task this process is the only one, since
    starting another takes longer than most tasks do. In a script, call what runs below ``if __name__ == "__main__":``.

    >>> Processes(2).results(abs, [-1, 2, -3])
    [1, 2, 3]
    """

    num_workers: int
    """>= 1."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Variables of the processes besides those of this one."""

    def run(self, work: Callable[[Task], Result], tasks: Iterable[Task], then: Callable[[int, Result], object]) -> None:
        source = iter(tasks)
        first = list(islice(source, 2))
        if len(first) < 2:
            Serial(self.environment).run(work, first, then)
        else:
            Workforce(work, chain(first, source), then, self.environment).run(self.num_workers)

    def share(self, num_tasks: int) -> AbstractExecutor:
        share = self.num_workers // max(1, num_tasks)
        return replace(self, num_workers=share) if share > 1 else Serial(self.environment)

    def with_environment(self, values: Mapping[str, str]) -> Self:
        return replace(self, environment={**self.environment, **values})


SERIAL = Serial()


def executor_of(jobs: int) -> AbstractExecutor:
    """An executor of as many processes, one a core for 0; this one alone for 1."""
    num_workers = jobs or available_cores()
    return SERIAL if num_workers == 1 else Processes(num_workers)
