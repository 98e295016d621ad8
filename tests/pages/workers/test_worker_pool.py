"""Processes that work for a session."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest

from grammarlab.errors import UsageError
from grammarlab.pages.workers.worker_pool import Handler, Report, TaskOutcome, WorkerPool
from tests.runs.processes import expect_gone
from tests.waiting import PATIENCE


def maker(greeting: str) -> Handler:
    """Made in each process."""
    if greeting == "bad":
        raise UsageError("bad greeting")

    seen: list[str] = []

    def do(request: Any, report: Report) -> Any:
        if request == "fail":
            raise UsageError("asked to fail")
        if request == "break":
            return 1 // 0
        seen.append(request)
        if request == "what was seen":
            return list(seen)
        if request == "die" or (request.startswith("die once ") and not Path(request[9:]).exists()):
            Path(request[9:] or os.devnull).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        if request == "sleep":
            time.sleep(1_000)
        if request == "long":
            for done in count():
                report("waiting", done, 0)
                time.sleep(0.01)
        return f"{greeting} {request}"

    return do


class Thread:
    """What runs a pool: calls what is delivered, until something holds."""

    def __init__(self, greeting: str, size: int) -> None:
        self.inbox: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self.pool = WorkerPool(f"{__name__}:maker", (greeting,), size, self.inbox.put)
        self.outcomes: dict[str, TaskOutcome] = {}
        self.progress: list[tuple[str, int, int]] = []

    def submit(self, request: str, **options: Any) -> int:
        return self.pool.submit(
            request, lambda outcome: self.outcomes.__setitem__(request, outcome), on_progress=self.note, **options
        )

    def note(self, stage: str, done: int, total: int) -> None:
        self.progress.append((stage, done, total))

    def until(self, holds: Callable[[], Any]) -> None:
        while not holds():
            self.inbox.get(timeout=PATIENCE)()


@pytest.fixture
def thread() -> Iterator[Thread]:
    thread = Thread("hello", 1)
    yield thread
    thread.pool.close()


def test_tasks_end_with_a_value_or_with_words(thread: Thread):
    for request in ("world", "fail", "break"):
        thread.submit(request)
    thread.until(lambda: len(thread.outcomes) == 3)
    assert thread.outcomes["world"] == TaskOutcome("hello world")
    assert thread.outcomes["fail"] == TaskOutcome(error="asked to fail")
    assert "ZeroDivisionError" in thread.outcomes["break"].error


def test_a_task_that_cannot_be_made_says_why():
    thread = Thread("bad", 1)
    thread.submit("world")
    thread.until(lambda: thread.outcomes)
    assert thread.outcomes["world"] == TaskOutcome(error="bad greeting")
    thread.pool.close()


def test_a_lost_process_is_replaced_and_its_task_done_again_before_others(thread: Thread, tmp_path: Path):
    deadly = f"die once {tmp_path / 'mark'}"
    thread.submit(deadly)
    thread.submit("world")
    thread.until(lambda: len(thread.outcomes) == 2)
    assert thread.outcomes == {deadly: TaskOutcome(f"hello {deadly}"), "world": TaskOutcome("hello world")}
    assert list(thread.outcomes) == [deadly, "world"]


def test_a_task_that_always_ends_its_process_is_told(thread: Thread):
    for request in ("die", "world"):
        thread.submit(request)
    thread.until(lambda: len(thread.outcomes) == 2)
    assert re.search("ended unasked, 3 times .*it was killed", thread.outcomes["die"].error)
    assert thread.outcomes["world"].value == "hello world"


def test_a_new_process_is_brought_to_where_the_lost_one_was(thread: Thread, tmp_path: Path):
    thread.submit("world")
    thread.until(lambda: thread.outcomes)
    thread.pool.recall = "what there is to know"
    (worker,) = thread.pool._workers
    worker.process.kill()  # it waits for a task
    thread.until(lambda: not thread.pool._workers)
    thread.submit("what was seen")
    thread.until(lambda: len(thread.outcomes) == 2)
    assert thread.outcomes.pop("what was seen").value == ["what there is to know", "what was seen"]
    deadly = f"die once {tmp_path / 'mark'}"
    thread.submit(deadly)
    thread.submit("what was seen")
    thread.until(lambda: "what was seen" in thread.outcomes)
    assert thread.outcomes["what was seen"].value == ["what there is to know", deadly, "what was seen"]


def test_what_cannot_be_recalled_is_forgotten(thread: Thread):
    thread.pool.recall = "die"
    thread.submit("world")
    thread.until(lambda: thread.outcomes)
    assert thread.outcomes == {"world": TaskOutcome("hello world")}


def test_what_was_cancelled_is_not_done_again(thread: Thread):
    long = thread.submit("sleep")
    thread.submit("world")
    thread.pool.cancel(long)
    (worker,) = thread.pool._workers
    worker.process.kill()
    thread.until(lambda: "world" in thread.outcomes)
    assert list(thread.outcomes) == ["sleep", "world"]


def test_processes_that_cannot_live_are_given_up():
    thread = Thread("hello", 1)
    thread.pool.make = "tests.no_such_module:maker"
    thread.submit("world")
    thread.until(lambda: thread.outcomes)
    thread.submit("more")
    thread.until(lambda: "more" in thread.outcomes)
    assert re.search(r"ended unasked, 3 times .*\(exit code 1\)", thread.outcomes["more"].error)
    thread.pool.close()


def test_tasks_are_cancelled_while_they_wait_and_while_they_run(thread: Thread):
    long = thread.submit("long")
    waiting = thread.submit("world")
    thread.until(lambda: thread.progress)
    thread.pool.cancel(waiting)
    assert thread.outcomes == {"world": TaskOutcome(cancelled=True)}
    thread.pool.cancel(long)
    assert thread.outcomes["long"].cancelled
    told = len(thread.progress)
    thread.submit("again")
    thread.until(lambda: "again" in thread.outcomes)
    assert len(thread.outcomes) == 3
    assert len(thread.progress) == told


def test_what_is_first_is_first_and_what_nobody_wants_is_dropped(thread: Thread):
    thread.submit("one")
    thread.submit("two")
    thread.submit("three", first=True)
    thread.submit("four", is_wanted=lambda: False)
    thread.until(lambda: "two" in thread.outcomes)
    assert list(thread.outcomes) == ["one", "three", "two"]
    # Nothing begins before all of them are there, so that the last one in front is done first.
    with thread.pool.held():
        thread.submit("five", first=True)
        thread.submit("six", first=True)
    thread.until(lambda: "five" in thread.outcomes)
    assert list(thread.outcomes)[3:] == ["six", "five"]


@pytest.mark.parametrize("busy", [False, True])
def test_processes_end_when_the_session_is_killed(tmp_path: Path, busy: bool):
    code = f"""
import time
from queue import SimpleQueue
from grammarlab.pages.workers.worker_pool import WorkerPool
inbox = SimpleQueue()
pool = WorkerPool("{__name__}:maker", ("hello",), 2, inbox.put)
pool.submit("world", lambda outcome: None)
inbox.get()()
for _ in range(2 * {busy}):
    pool.submit("sleep", lambda outcome: None)
print(*(worker.process.pid for worker in pool._workers), flush=True)
time.sleep(100)
"""
    script = tmp_path / "run.py"
    script.write_text(f"if __name__ == '__main__':\n{''.join(f'    {line}' for line in code.splitlines(True))}")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        workers = [int(pid) for pid in process.stdout.readline().split()]
        process.kill()
    assert len(workers) == 2
    expect_gone(workers)
