"""Choice of the executor of a run, by a number of processes or the address of a cluster."""

from __future__ import annotations

from collections.abc import Callable

from grammarlab.runs.work.executors import SERIAL, AbstractExecutor, Processes
from grammarlab.runs.work.workers import available_cores


def executor_of(jobs: int, scheduler: str = "", notice: Callable[[str], object] = str) -> AbstractExecutor:
    """Executor with a number of processes, or a cluster.

    Args:
        jobs: number of processes of this machine; 0 for one per core, 1 for this process only.
        scheduler: address of the scheduler of a Dask cluster, which replaces this machine.
        notice: called with messages about the cluster, such as that it has no workers.

    Raises:
        UsageError: If there is no scheduler at the address.
    """
    if scheduler:
        from grammarlab.runs.work.cluster import cluster_at  # noqa: PLC0415  # an extra

        return cluster_at(scheduler, notice)
    num_workers = jobs or available_cores()
    return SERIAL if num_workers == 1 else Processes(num_workers)
