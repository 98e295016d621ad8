"""Answers of processes that do tasks for another one: the result of a task, or its error."""

from __future__ import annotations

import pickle
import traceback
from collections.abc import Callable
from functools import lru_cache
from typing import Any


class EndedError(BaseException):
    """Raised in a process that must end; tasks do not catch it as an error."""


def answer(work: bytes, task: bytes) -> bytes:
    """Do a task.

    Args:
        work: the function, pickled by the process that asks.
        task: its argument, pickled by the same process.

    Returns:
        Whether it succeeded, and its result or its error, pickled. An error that cannot be pickled becomes a
        RuntimeError with its text.
    """
    try:
        return pickle.dumps((True, _function(work)(pickle.loads(task))))  # noqa: S301 - of our own process
    except EndedError:
        raise
    except BaseException as error:
        error.add_note(f"In a process that worked for this one:\n{traceback.format_exc()}")
        return failure(error)


def result_of(message: bytes) -> Any:
    """The result in an answer.

    Raises:
        BaseException: The error of the task, if it failed.
    """
    is_result, value = pickle.loads(message)  # noqa: S301 - of a process that works for this one
    if not is_result:
        raise value
    return value


def failure(error: BaseException) -> bytes:
    """Answer of a task that has failed: its error, pickled, or a RuntimeError with the text of one that cannot be."""
    try:
        message = pickle.dumps((False, error))
        pickle.loads(message)  # noqa: S301 - made a line above
    except Exception:
        text = "".join(traceback.format_exception(error))
        return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}\n{text}")))
    return message


@lru_cache(maxsize=1)
def _function(work: bytes) -> Callable[[Any], Any]:
    """The function that does tasks, imported with the first task."""
    return pickle.loads(work)  # noqa: S301 - of our own process
