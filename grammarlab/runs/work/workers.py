"""Worker processes: start, environment, and end."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from multiprocessing import connection, current_process, get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from threading import Lock, Thread
from typing import Any, TypeAlias

from threadpoolctl import threadpool_limits

MAX_ATTEMPTS = 3
"""Largest number of starts of a task whose process dies."""
UNGUARDED = """worker processes import the script that starts them, and this script would start them again. Add a guard:

    import grammarlab as gl

    if __name__ == "__main__":
        ...  # the rest of the script
"""
"""Message about a script without a guard."""
_UNGUARDED_CODE = 78
"""Exit code of a worker that found its script without a guard: how its parent learns the reason."""
_NAME = "grammarlab worker"
"""Name of worker processes, known before the script is imported."""
Report: TypeAlias = Callable[[str, int, int], None]
"""Function of the name of a part of a task, the number of its finished steps, and the number of all of them."""
_reported: ContextVar[Report] = ContextVar("reported")
"""Where reports of this thread go: they cross the border of a process, which arguments of a task cannot."""
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
# Spawned, not forked: threads of numerical libraries do not survive a fork.
_CONTEXT = get_context("spawn")
# A new process copies the environment of this one, which all threads share.
_starting = Lock()


def available_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def start_worker(
    target: Callable[..., None],
    arguments: tuple[Any, ...],
    environment: Mapping[str, str] | None = None,
    *,
    outlives: bool = False,
) -> tuple[SpawnProcess, Connection]:
    """Start a process, and return before it is ready.

    Numerical libraries have one thread in it. It ignores Ctrl-C, which reaches the whole group of processes: this
    process decides what to do. The new process ends when this process ends in any way.

    Args:
        target: a function that other processes can import; called with the other end of the connection and `arguments`.
        arguments: few and small, since this process waits until they are received.
        environment: variables of the process in addition to those of this one.
        outlives: whether it may run until this process ends. Such a process cannot start others.

    Returns:
        The process, and a connection to it that ends when it does.
    """
    end_if_unguarded()
    here, there = _CONTEXT.Pipe()
    process = _CONTEXT.Process(target=_begin, args=(target, there, *arguments), name=_NAME, daemon=outlives)
    with _starting, variables({**_ONE_THREAD, **(environment or {})}), _without_interrupts():
        process.start()
    there.close()
    return process, here


def end_if_unguarded() -> None:
    """End this process if it is a worker that still imports the script of its parent.

    A worker imports the script before its first task, as `multiprocessing` does. What a script without a guard does is
    then repeated in the worker, so call this before anything that must not be repeated.
    """
    process = current_process()
    # The standard library refuses to start processes by the same attribute.
    if process.name == _NAME and getattr(process, "_inheriting", False):
        raise SystemExit(_UNGUARDED_CODE)


def is_unguarded(process: SpawnProcess) -> bool:
    """Whether a lost process ended since its script has no guard (`UNGUARDED`)."""
    return process.exitcode == _UNGUARDED_CODE


@contextmanager
def variables(values: Mapping[str, str]) -> Iterator[None]:
    """Environment variables of this process during a block."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def reporting(to: Report) -> Iterator[None]:
    """Send what tasks report during a block to a function, also from processes of this machine."""
    token = _reported.set(to)
    try:
        yield
    finally:
        _reported.reset(token)


@contextmanager
def reporting_for(whose: str) -> Iterator[None]:
    """Add to the names of all parts that tasks report during a block whose they are."""
    outer = _reported.get(None)
    if outer is None:
        yield
    else:
        with reporting(lambda part, done, total: outer(f"{part}, {whose}", done, total)):
            yield


def report(part: str, done: int, total: int) -> None:
    """Report how far a long part of a task is; nothing happens if nobody asks."""
    if to := _reported.get(None):
        to(part, done, total)


def one_thread() -> threadpool_limits:
    """A context in which numerical libraries have one thread.

    Several threads are slower at these sizes, and the last bits of a sum must not depend on the number of cores.
    """
    return threadpool_limits(1)


def exit_reason(process: SpawnProcess) -> str:
    """Description of the end of a lost process."""
    code = process.exitcode
    if code == -signal.SIGKILL:
        return "it was killed, as systems do when memory is short"
    return f"ended by signal {-code}" if code is not None and code < 0 else f"exit code {code}"


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Delay Ctrl-C until the end of the block; processes started in it inherit this."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(target: Callable[..., None], there: Connection, *arguments: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    Thread(target=_end_with_parent, daemon=True).start()
    target(there, *arguments)


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)  # nobody waits for the task any more
