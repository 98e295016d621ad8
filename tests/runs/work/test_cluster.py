"""Workers of a Dask cluster do the same as processes of this machine, and what ends them is said."""

from __future__ import annotations

import asyncio
import os
import pickle
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from shapely import affinity

from grammarlab.errors import LanguageError, UsageError, WorkerError
from grammarlab.export.cityjson import LEVELS
from grammarlab.runs.city.build import build_city
from grammarlab.runs.sample.request import SampleRequest
from grammarlab.runs.sample.shard_run import sample_shards
from grammarlab.runs.work.cluster import TASKS_PER_THREAD, Cluster
from grammarlab.runs.work.cluster_connection import Connection
from grammarlab.runs.work.cluster_worker import Work
from grammarlab.runs.work.executor_choice import executor_of
from grammarlab.runs.work.executors import SERIAL
from grammarlab.runs.work.machine import Machine, this_machine
from grammarlab.runs.work.run_folder import only_run_in
from grammarlab.runs.work.task_answers import result_of
from tests.cases import some, takes_turns
from tests.runs import tasks
from tests.runs.city.plans import boxes, files_of, write_plan
from tests.runs.dask_processes import DaskCluster, dask_cluster

REQUEST = SampleRequest(
    name="tower", text="Lot --> extrude(rand(3, 9)) Tower", assets=Path(), num_models=25, seed=3, image=False
)


Clusters = Callable[[int], DaskCluster]


@pytest.fixture(scope="module")
def clusters(tmp_path_factory: pytest.TempPathFactory):
    """A cluster with at least so many workers; tests in any order share one until its scheduler ends."""
    with ExitStack() as stack:
        started: list[DaskCluster] = []

        def with_workers(number: int) -> DaskCluster:
            if not started or started[-1].scheduler.poll() is not None:
                started.append(stack.enter_context(dask_cluster(tmp_path_factory.mktemp("dask"), 0)))
            while started[-1].num_running < number:
                started[-1].add_worker()
            return started[-1]

        yield with_workers


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of a run of this process."""
    folder = tmp_path_factory.mktemp("whole")
    sample_shards(REQUEST, folder, shard_models=1)
    return files(folder)


def test_a_cluster_keeps_the_contract_of_executors(clusters: Clusters):
    executor = executor_of(0, clusters(2).address)
    assert executor.results(tasks.product_of, range(4)) == SERIAL.results(tasks.product_of, range(4))
    assert executor.results(tasks.square, []) == []
    within = executor.with_environment({"GRAMMARLAB_A": "a"})
    assert within.results(tasks.variable, ["GRAMMARLAB_A"]) == ["a"]
    assert executor.results(tasks.variable, ["GRAMMARLAB_A"]) == [None]
    seen = executor.results(tasks.process_and_threads, range(6))
    assert {threads for _, each in seen for threads in each} == {1}
    assert os.getpid() not in {process for process, _ in seen}
    assert executor.machine() == this_machine()
    for kind, error, message in [
        ("exit", SystemExit, "^7"),
        ("findings", LanguageError, "odd rule"),
        ("reason", RuntimeError, "ReasonError: nothing at 5"),
    ]:
        with pytest.raises(error, match=message):
            executor.results(tasks.fail, [kind] * 2)


def test_tasks_are_taken_as_there_is_room_for_them(clusters: Clusters):
    cluster = clusters(1)
    most = TASKS_PER_THREAD * cluster.num_running
    latest = done = 0

    def endless():
        nonlocal latest
        while True:
            latest += 1
            yield latest

    def then(_index: int, _result: int) -> None:
        nonlocal done
        done += 1
        assert latest - done <= most
        if done == 40:
            raise StopIteration("enough")

    with pytest.raises(StopIteration, match="enough"):
        executor_of(0, cluster.address).run(tasks.square, endless(), then)


def files(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@takes_turns
def test_a_worker_that_is_killed_changes_no_byte(clusters: Clusters, tmp_path: Path, whole: dict[str, bytes]):
    cluster = clusters(2)
    executor = executor_of(0, cluster.address)
    done: list[int] = []

    def note(_what: str, count: int, _total: int) -> None:
        done.append(count)
        if count == 5:
            cluster.kill_worker()

    assert sample_shards(REQUEST, tmp_path, shard_models=1, executor=executor, on_progress=note).num_made == 25
    assert done == list(range(26))
    assert files(tmp_path) == whole


@dataclass(frozen=True)
class Trouble:
    """What happens to a cluster after 5 of 25 shards."""

    name: str
    num_workers: int
    begin: Callable[[DaskCluster, ExitStack], object] = lambda _cluster, _stack: None

    def __str__(self) -> str:
        return self.name


def drop(cluster: DaskCluster, _stack: ExitStack) -> None:
    cluster.drop_worker()
    cluster.add_worker()


TROUBLES = [
    Trouble("one worker", 1),
    Trouble("four workers", 4),
    Trouble("a worker freezes", 2, lambda cluster, stack: stack.enter_context(cluster.frozen_worker())),
    Trouble("a worker that lives is taken for dead, and another comes", 1, drop),
    Trouble("a result is lost", 1, lambda cluster, _stack: cluster.lose_answer()),
]


@pytest.mark.parametrize("trouble", some(TROUBLES), ids=str)
def test_no_trouble_of_a_cluster_changes_a_byte(
    tmp_path: Path, whole: dict[str, bytes], monkeypatch: pytest.MonkeyPatch, trouble: Trouble
):
    """Dask gives up a frozen worker after 5 s here; a lost result, by dask/distributed 3196, is made again."""
    monkeypatch.setattr("grammarlab.runs.work.cluster._LOOK_SECONDS", 0.5)
    monkeypatch.setattr("grammarlab.runs.work.cluster._STALL_SECONDS", 2.0)
    monkeypatch.setattr("grammarlab.runs.work.cluster_connection._SILENT_SECONDS", 2.0)
    (tmp_path / "dask").mkdir()
    notices: list[str] = []
    with (
        ExitStack() as stack,
        dask_cluster(tmp_path / "dask", trouble.num_workers, DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL="5s") as cluster,
    ):
        executor = executor_of(0, cluster.address, notices.append)

        def begin(_what: str, count: int, _total: int) -> None:
            if count == 5:
                trouble.begin(cluster, stack)

        options: Any = {"shard_models": 1, "executor": executor, "on_progress": begin}
        assert sample_shards(REQUEST, tmp_path / "out", **options).num_made == 25
        assert files(tmp_path / "out") == whole
    expected = {"a worker freezes": "silent for 2 s: worker tcp", "a result is lost": "connecting again"}
    assert expected.get(trouble.name, "") in " ".join(notices)


def test_a_city_of_a_cluster_is_that_of_this_machine(clusters: Clusters, tmp_path: Path):
    parcels = boxes()
    far = {f"far {name}": affinity.translate(parcel, 5_000, 3_000) for name, parcel in parcels.items()}
    plan = write_plan(tmp_path, parcels | far)
    executor = executor_of(0, clusters(2).address)
    shards: list[int] = []
    build_city(plan, tmp_path / "there", executor=executor, cityjson=LEVELS, on_progress=lambda *_: shards.append(1))
    build_city(plan, tmp_path / "here", cityjson=LEVELS)
    assert files_of(tmp_path / "there") == files_of(tmp_path / "here")
    assert len(shards) > 3  # the start, and at least one after each shard


def test_a_task_that_kills_its_worker_is_named_and_not_the_one_beside_it(clusters: Clusters, tmp_path: Path):
    cluster = clusters(2)
    executor, before = executor_of(0, cluster.address), cluster.num_running
    marks = [tmp_path / f"{number}{'.deadly' * (number == 2)}" for number in range(6)]
    done: list[int] = []
    with pytest.raises(WorkerError, match=r"2\.deadly: the worker that did nothing else died, 1 times.*more memory"):
        executor.run(tasks.count_and_die, marks, lambda index, _: done.append(index))
    assert (tmp_path / "2.deadly").read_text() == "xx"
    assert set(done) <= {0, 1, 3, 4, 5}
    assert cluster.num_running == before - 2


def test_a_run_goes_on_elsewhere_when_its_scheduler_dies(clusters: Clusters, tmp_path: Path, whole: dict[str, bytes]):
    cluster = clusters(1)
    executor = executor_of(0, cluster.address)

    def kill(_what: str, count: int, _total: int) -> None:
        if count == 5:
            cluster.kill_scheduler()

    with pytest.raises(WorkerError, match=r"scheduler at tcp://127\.0\.0\.1:\d+ is gone"):
        sample_shards(REQUEST, tmp_path, shard_models=1, executor=executor, on_progress=kill)
    finished = {name: content for name, content in files(tmp_path).items() if name.startswith("shards")}
    assert 5 <= len(finished) < 25
    assert finished.items() <= whole.items()
    assert sample_shards(REQUEST, tmp_path, shard_models=1).num_made == 25 - len(finished)
    assert files(tmp_path) == whole
    with pytest.raises(UsageError, match="expected a Dask scheduler at 'here', found none"):
        executor_of(0, "here")


def connection_to(answers: dict[str, Any], threads: int = 1) -> Connection:
    """Connection to workers with answers; those that are errors of the system are raised."""

    async def run(_function: Any, workers: list[str], on_error: str) -> dict[str, Any]:
        assert on_error == "return"
        if isinstance(error := answers[workers[0]], OSError):
            raise error
        return {worker: answers[worker] for worker in workers}

    client: Any = SimpleNamespace(
        status="running",
        scheduler=SimpleNamespace(ncores=None),
        sync=lambda call, **_: dict.fromkeys(answers, threads) if call is None else asyncio.run(call()),
        run=run,
    )
    return Connection("tcp://x", client)


@pytest.mark.parametrize(
    ("answers", "threads", "message"),
    [
        (
            lambda here: {"a": here, "b": replace(here, processor={"BLAS": "Zen"})},
            1,
            "worker b has BLAS Zen, not .*pin",
        ),
        (lambda here: {"a": replace(here, software={"numpy": "1.0"})}, 1, "worker a has numpy 1.0, not .* as here"),
        (lambda here: {"a": here, "b": ModuleNotFoundError("no")}, 1, "worker b cannot import grammarlab.*install"),
        (lambda here: {"a": here}, 8, "worker a does 8 tasks at a time.*--nworkers 8 --nthreads 1"),
    ],
)
def test_workers_that_would_give_other_bits_are_refused(answers: Any, threads: int, message: str):
    with pytest.raises(UsageError, match=message):
        connection_to(answers(this_machine()), threads).machine(str)


def test_a_silent_worker_is_named_and_the_others_begin():
    notices: list[str] = []
    connection = connection_to({"a": TimeoutError(), "b": ConnectionResetError(), "c": this_machine()})
    assert connection.machine(notices.append) == this_machine()
    assert [notice.partition(". ")[0] for notice in notices] == ["silent for 60 s: worker a"]


def test_a_worker_without_the_folder_of_the_run_says_so(tmp_path: Path):
    work = Work(pickle.dumps(tasks.square), Path.cwd(), {}, this_machine(), tmp_path)
    with pytest.raises(UsageError, match=r"does not see the run's folder.*share"):
        result_of(work.answer("key", pickle.dumps(3)))
    with only_run_in(tmp_path):
        assert result_of(work.answer("key", pickle.dumps(3))) == 9
    assert Cluster("tcp://x").in_folder(Path("here")).folder == Path.cwd() / "here"


def test_a_machine_is_what_was_written_of_it():
    here = this_machine()
    assert Machine.from_json(here.as_json(), "machine") == here
    assert here.difference(here) == ""
