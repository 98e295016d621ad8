"""Worker processes end with the process that they work for, however that ends."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.runs.processes import descendants, expect_gone
from tests.waiting import PATIENCE, wait_until

WORKERS = 2
LONG = 10.0 * PATIENCE


def begin_and_sleep(begun: Path) -> None:
    """A task that takes longer than any test, and tells that it has begun."""
    begun.touch()
    time.sleep(LONG)


@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGTERM])
def test_no_worker_is_left_when_its_parent_is_killed(tmp_path: Path, ending: signal.Signals):
    tasks = [tmp_path / str(task) for task in range(3 * WORKERS)]  # some wait for a worker
    modules = "from tests.runs.test_workers import *; from grammarlab.runs.workers import map_unordered"
    run = f"list(map_unordered(begin_and_sleep, map(Path, sys.argv[1:]), {WORKERS}))"
    with subprocess.Popen([sys.executable, "-c", f"{modules}; {run}", *map(str, tasks)]) as parent:
        wait_until(lambda: sum(task.exists() for task in tasks) == WORKERS)
        processes = descendants(parent.pid)
        parent.send_signal(ending)
    assert len(processes) >= WORKERS
    expect_gone(processes)
