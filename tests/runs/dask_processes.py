"""A Dask cluster of processes on this machine: a scheduler on a free port, without a dashboard, and workers."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from distributed import Client
from distributed.worker import Worker

from tests.waiting import wait_until

_QUIET = ["--no-dashboard", "--dashboard-address", "127.0.0.1:0"]


@dataclass
class DaskCluster:
    """Processes of a cluster."""

    file: Path
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)

    @property
    def address(self) -> str:
        return json.loads(self.file.read_text())["address"]

    def add_worker(self, *options: str, **environment: str) -> None:
        module = "distributed.cli.dask_worker"
        arguments = ["--scheduler-file", str(self.file), "--nthreads", "1", "--no-nanny", *_QUIET, *options]
        local = ["--local-directory", str(self.file.parent)]
        self.workers.append(_started(module, [*arguments, *local], environment))

    @property
    def num_running(self) -> int:
        """Number of workers that have not ended."""
        return sum(worker.poll() is None for worker in self.workers)

    def kill_scheduler(self) -> None:
        _kill(self.scheduler)

    def kill_worker(self) -> None:
        _kill(next(worker for worker in self.workers if worker.poll() is None))

    @contextmanager
    def frozen_worker(self) -> Iterator[None]:
        """A block in which a worker exists and does nothing."""
        worker = next(worker for worker in self.workers if worker.poll() is None)
        worker.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            worker.send_signal(signal.SIGCONT)

    def drop_worker(self) -> None:
        """Let the scheduler take a worker for dead that is not."""
        with Client(self.address, set_as_default=False) as client:
            worker, scheduler = next(iter(client.scheduler_info()["workers"])), cast("Any", client.scheduler)
            client.sync(scheduler.unregister, address=worker, stimulus_id="test")

    def lose_answer(self) -> None:
        """Let each worker send one result less, which the scheduler waits for."""
        with Client(self.address, set_as_default=False) as client:
            client.run(_lose_answer)


def _lose_answer(dask_worker: Worker) -> None:
    send = dask_worker.batched_send

    def lose(msg: dict[str, Any]) -> None:
        if msg.get("op") == "task-finished":
            dask_worker.batched_send = send
        else:
            send(msg)

    dask_worker.batched_send = lose


@contextmanager
def dask_cluster(folder: Path, num_workers: int, **variables: str) -> Iterator[DaskCluster]:
    """A cluster for a block, whose workers may still be starting; the first death of a worker is one too many.

    Args:
        folder: for its files.
        num_workers: number of workers.
        variables: of the scheduler in addition to those of this process.
    """
    file = folder / "scheduler.json"
    options = ["--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file), *_QUIET]
    environment = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0", **variables}
    cluster = DaskCluster(file, _started("distributed.cli.dask_scheduler", options, environment))
    try:
        wait_until(file.exists, lambda: "no scheduler")
        for _ in range(num_workers):
            cluster.add_worker()
        yield cluster
    finally:
        for process in (*cluster.workers, cluster.scheduler):
            _kill(process)


def _started(module: str, arguments: list[str], environment: dict[str, str]) -> subprocess.Popen[bytes]:
    paths = os.pathsep.join(filter(None, sys.path))
    variables = os.environ | {"PYTHONPATH": paths, "OMP_NUM_THREADS": "1"} | environment
    words = [sys.executable, "-m", module, *arguments]
    return subprocess.Popen(words, env=variables, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def _kill(process: subprocess.Popen[bytes]) -> None:
    process.send_signal(signal.SIGKILL)
    process.wait()
