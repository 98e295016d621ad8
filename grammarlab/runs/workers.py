"""Work on several cores at once, with one core as the plain case."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from itertools import islice
from multiprocessing import connection, get_context, parent_process
from threading import Thread
from typing import TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def map_unordered(work: Callable[[Task], Result], tasks: Iterable[Task], jobs: int) -> Iterator[Result]:
    """The results of all tasks, each as soon as it is there.

    Args:
        work: a function that other processes can import.
        tasks: its arguments; taken as workers become free, so that they may be many.
        jobs: processes; with 1 everything happens in this one.
    """
    if jobs == 1:
        yield from map(work, tasks)
        return
    source = iter(tasks)
    # Spawned, not forked: threads of numerical libraries do not survive a fork.
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=begin_worker) as pool:
        running: set[Future[Result]] = {pool.submit(work, task) for task in islice(source, 2 * jobs)}
        try:
            while running:
                done, running = wait(running, return_when=FIRST_COMPLETED)
                running |= {pool.submit(work, task) for task in islice(source, len(done))}
                for future in done:
                    yield future.result()
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def begin_worker() -> None:
    """What a process that works for another one begins with.

    Ctrl-C reaches the whole group of processes: what to do is for the parent to say, so that what is under way can be
    finished. And when the parent has ended, however that was, so does the worker.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)  # nobody waits for the task any more
