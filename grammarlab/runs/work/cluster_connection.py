"""Connections to the scheduler of a Dask cluster, and what is asked of its workers before they get tasks."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from queue import Empty, Queue
from threading import Thread
from typing import Any

from distributed import Client
from distributed.comm.core import CommClosedError
from distributed.diagnostics.plugin import WorkerPlugin
from distributed.protocol.pickle import dumps

from grammarlab.errors import UsageError, WorkerError
from grammarlab.runs.work.cluster_worker import mixture
from grammarlab.runs.work.machine import Machine, this_machine

NO_WORKERS_SECONDS = 60.0
"""Seconds without workers after which it is said."""
_CONNECT_SECONDS, _CLOSE_SECONDS = 15.0, 5.0
_ANSWER_SECONDS = 30.0
"""Seconds in which the scheduler must answer."""
_SILENT_SECONDS = 60.0
"""Seconds in which a worker must answer; its first answer imports the libraries, perhaps from a slow disk."""
_MAX_SENDINGS = 3
"""Largest number of times that a plugin is sent while workers leave."""


@dataclass(frozen=True, slots=True)
class Connection:
    """A connection to a scheduler."""

    address: str
    client: Client

    def check(self) -> None:
        """Check that the connection has not been lost; futures do not report that.

        Raises:
            WorkerError: If it has.
        """
        if self.client.status != "running":
            raise self.lost()

    def lost(self) -> WorkerError:
        """Error about a lost connection."""
        return WorkerError(
            f"the scheduler at {self.address} is gone or does not answer. What is finished stays: "
            "start a scheduler again."
        )

    def threads(self) -> Mapping[str, int]:
        """Number of threads of each worker, by address.

        Raises:
            WorkerError: If the scheduler does not answer.
        """
        return self.ask("ncores", _ANSWER_SECONDS)

    def ask(self, question: str, seconds: float, **arguments: Any) -> Any:
        """Answer of the scheduler, which may be silent without having closed the connection.

        Raises:
            WorkerError: If it does not answer in time, or the connection is lost.
        """
        self.check()
        try:
            call = getattr(self.client.scheduler, question)
            return self.client.sync(call, callback_timeout=seconds, **arguments)
        except (OSError, TimeoutError) as error:
            raise self.lost() from error

    def from_workers(self, function: Callable[..., Any], notice: Callable[[str], object]) -> Mapping[str, Any]:
        """Results of a function in each worker, by address.

        Its error where it raises one; a TimeoutError where the worker is silent, another OSError where it has left.

        Args:
            function: can be pickled; Dask gives it the worker if it has a parameter `dask_worker`.
            notice: called with the address of a silent worker.
        """

        async def answer(worker: str) -> Any:
            try:
                question: Any = self.client.run(function, workers=[worker], on_error="return")
                answers = await asyncio.wait_for(question, _SILENT_SECONDS)
            except OSError as error:
                return error
            return answers.get(worker, ConnectionError())

        async def answers() -> list[Any]:
            return await asyncio.gather(*map(answer, workers))

        workers = list(self.threads())
        client: Any = self.client
        results: dict[str, Any] = dict(zip(workers, client.sync(answers), strict=True))
        if silent := [worker for worker, result in results.items() if isinstance(result, TimeoutError)]:
            more = f" and {len(silent) - 1:,} more" if len(silent) > 1 else ""
            notice(
                f"silent for {_SILENT_SECONDS:.0f} s: worker {silent[0]}{more}. Dask gives the tasks of silent workers "
                "to others after its `worker-ttl`, 5 minutes unless the scheduler was started with another."
            )
        return results

    def send_plugin(self, plugin: WorkerPlugin, name: str) -> None:
        """Send a plugin to all workers; one that is silent, or comes later, gets it when it can.

        Raises:
            WorkerError: If the scheduler does not answer.
        """
        client: Any = self.client
        content = {"plugin": dumps(plugin), "name": name, "idempotent": False}
        for _ in range(_MAX_SENDINGS):
            try:
                client.sync(client.scheduler.register_worker_plugin, callback_timeout=_SILENT_SECONDS, **content)
            except TimeoutError:
                return
            except OSError:  # of a worker that leaves, perhaps before the others have it
                self.check()
            else:
                return

    def dashboard(self) -> str:
        """Address of the page of the scheduler; empty if it has none."""
        services = self.client.scheduler_info(n_workers=0).get("services", {})
        return str(self.client.dashboard_link) if services.get("dashboard") else ""

    def machine(self, notice: Callable[[str], object]) -> Machine:
        """Machine of all workers, when there are any.

        Args:
            notice: called if there are none for a while.

        Raises:
            UsageError: If they differ, cannot import this version of grammarlab, or do several tasks at a time.
            WorkerError: If the scheduler does not answer.
        """
        answers: Mapping[str, Any] = {}
        while not answers:  # all may be silent, or leave before they answer; plugins ask those that do
            check_threads(self._workers(notice))
            results = self.from_workers(this_machine, notice)
            answers = {worker: result for worker, result in results.items() if not isinstance(result, OSError)}
        here, first = this_machine(), None
        for worker, machine in answers.items():
            if not isinstance(machine, Machine):
                raise UsageError(
                    f"worker {worker} cannot import grammarlab {here.software['grammarlab']} ({machine!r:.200}). Start "
                    "workers from the environment of this command: pip install 'grammarlab[cluster]'."
                )
            if difference := Machine(machine.software, {}).difference(Machine(here.software, {})):
                raise UsageError(f"worker {worker} has {difference} as here. Start workers from the same environment.")
            first = first or machine
            if difference := machine.difference(first):
                raise UsageError(mixture(worker, difference))
        return first or here

    def _workers(self, notice: Callable[[str], object]) -> Mapping[str, int]:
        """Threads of workers, when there are any."""
        start, is_said = time.monotonic(), False
        while not (threads := self.threads()):
            if not is_said and time.monotonic() - start > NO_WORKERS_SECONDS:
                notice(no_workers(self.address))
                is_said = True
            time.sleep(0.2)
        return threads


@contextmanager
def connected(address: str) -> Iterator[Connection]:
    """A connection to a scheduler during a block.

    Raises:
        UsageError: If there is none at the address.
        WorkerError: If it is lost in the block.
    """
    client = _client(address)
    connection = Connection(address, client)
    log = logging.getLogger("distributed.client")
    before, log.disabled = log.disabled, True  # it prints tracebacks of what is said here in words
    try:
        yield connection
    except CommClosedError as error:
        raise connection.lost() from error
    finally:
        client.close(timeout=_CLOSE_SECONDS if client.status == "running" else 1)
        log.disabled = before


def _client(address: str) -> Client:
    """A client of a scheduler; made by a thread, since it waits for ever for one that accepts and is silent.

    Raises:
        UsageError: If there is no scheduler at the address.
    """
    made: Queue[Client | Exception] = Queue()

    def connect() -> None:
        try:
            made.put(Client(address, timeout=_CONNECT_SECONDS, set_as_default=False))
        except Exception as error:
            made.put(error)

    Thread(target=connect, daemon=True).start()
    try:
        client = made.get(timeout=2 * _CONNECT_SECONDS)
    except Empty:
        client = TimeoutError("it does not answer")
    if isinstance(client, Client):
        return client
    raise UsageError(
        f"expected a Dask scheduler at {address!r:.200}, found none ({client!s:.200}). Start one with "
        "`dask scheduler`, and give the address that it prints: tcp://HOST:8786."
    ) from client


def no_workers(address: str) -> str:
    """Message about a cluster without workers."""
    return f"no workers at {address} for {NO_WORKERS_SECONDS:.0f} s: start some: dask worker {address} --nthreads 1"


def check_threads(threads: Mapping[str, int]) -> None:
    """Check that each worker does one task at a time.

    Raises:
        UsageError: If one does several.
    """
    for worker, number in threads.items():
        if number != 1:
            raise UsageError(
                f"worker {worker} does {number} tasks at a time in one process. Start it with `--nworkers {number} "
                "--nthreads 1`: tasks share neither a core nor the settings of numerical libraries."
            )
