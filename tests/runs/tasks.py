"""Tasks that other processes can import."""

from __future__ import annotations

import os
import signal
import sys
import time
from functools import partial
from multiprocessing import util
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_info

from grammarlab.errors import Finding, LanguageError, Location
from grammarlab.runs.work.executors import AbstractExecutor
from grammarlab.runs.work.workers import report

LONG = 600.0


def square(number: int) -> int:
    return number * number


def in_steps(number: int) -> int:
    """Reports three steps."""
    for step in range(1, 4):
        report(f"steps of {number}", step, 3)
    return number


def product_of(seed: int) -> bytes:
    """Sums whose last bits depend on the number of threads."""
    matrix = np.random.default_rng(seed).normal(size=(400, 400))
    return (matrix @ matrix.T).tobytes()


def process_and_threads(_task: object) -> tuple[int, set[int]]:
    """Which process it was, and how many threads numerical libraries have there."""
    np.linalg.inv(np.eye(2))  # loads what it needs
    return os.getpid(), {library["num_threads"] for library in threadpool_info()}


def variable(name: str) -> str | None:
    return os.environ.get(name)


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def die_once(mark: Path) -> str:
    """Kills its process unless it has done so before."""
    if mark.suffix == ".deadly" and not mark.exists():
        mark.touch()
        die()
    return mark.name


def count_and_die(mark: Path) -> None:
    """Kills its process every time, and counts how often."""
    if mark.suffix == ".deadly":
        with mark.open("a") as file:
            file.write("x")
        die()


def die_of_signal(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(LONG)
    return number


class ReasonError(Exception):
    """An error that cannot be made again from its arguments."""

    def __init__(self, reason: str, *, place: int) -> None:
        super().__init__(f"{reason} at {place}")


def fail(kind: str) -> None:
    if kind == "findings":
        raise LanguageError((Finding("error", "odd", "odd rule", Location(2, 3), "do not"),), "A --> B\nB --> C")
    if kind == "reason":
        raise ReasonError("nothing", place=5)
    if kind == "exit":
        sys.exit(7)
    if kind == "local":
        raise type("HereError", (Exception,), {})("made here")
    raise {"value": ValueError, "memory": MemoryError, "interrupt": KeyboardInterrupt}[kind](f"{kind} is wrong")


def no_value(_task: object) -> object:
    """A result that cannot cross to another process."""
    return lambda: None


def squares_inside(executor: AbstractExecutor, numbers: range) -> list[int]:
    return executor.results(square, numbers)


def squares_of_squares(executor: AbstractExecutor, tasks: list[range]) -> list[list[int]]:
    return executor.results(partial(squares_inside, executor.share(len(tasks))), tasks)


def begin_and_sleep(begun: Path) -> None:
    """A task that takes longer than any test, and tells that it has begun; it tidies up where it may."""
    try:
        begun.touch()
        time.sleep(LONG)
    finally:
        begun.with_suffix(".tidy").touch()


def terminated_at_the_end(number: int) -> int:
    """The number; the process gets a signal to end when it ends."""
    util.Finalize(None, os.kill, (os.getpid(), signal.SIGTERM), exitpriority=1)
    return number


def terminated_in_a_destructor(number: int) -> int:
    """The number; the process gets a signal to end while an object is destroyed."""

    class Fragile:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGTERM)

    Fragile()
    return number
