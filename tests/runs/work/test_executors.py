"""Whoever does the tasks, the results are the same; processes that die are replaced, and none is left."""

from __future__ import annotations

import itertools
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from grammarlab.errors import LanguageError, WorkerError
from grammarlab.runs.work.executor_choice import executor_of
from grammarlab.runs.work.executors import SERIAL, AbstractExecutor, Processes, Serial
from grammarlab.runs.work.workers import MAX_ATTEMPTS, available_cores, reporting
from tests.cases import takes_turns
from tests.runs import tasks
from tests.runs.processes import descendants, expect_gone
from tests.waiting import PATIENCE

EXECUTORS = (SERIAL, Processes(1), Processes(2), Processes(3))
ANY = pytest.mark.parametrize("executor", EXECUTORS, ids=["serial", "1", "2", "3"])


@pytest.fixture(autouse=True)
def nothing_is_left():
    yield
    assert not multiprocessing.active_children()


def test_results_are_equal_to_the_last_bit_whoever_makes_them():
    first, *others = [executor.results(tasks.product_of, range(5)) for executor in EXECUTORS]
    assert len(set(first)) == 5
    assert all(other == first for other in others)


@ANY
def test_every_result_comes_once_with_the_place_of_its_task(executor: AbstractExecutor):
    found: list[tuple[int, int]] = []
    executor.run(tasks.square, [5, 5, -1], lambda index, result: found.append((index, result)))
    assert sorted(found) == [(0, 25), (1, 25), (2, 1)]


@ANY
def test_steps_of_a_task_are_reported_in_order_by_whoever_does_it(executor: AbstractExecutor):
    heard: list[tuple[str, int, int]] = []
    with reporting(lambda *step: heard.append(step)):
        assert executor.results(tasks.in_steps, [7, 8]) == [7, 8]
    assert sorted(heard) == [(f"steps of {number}", step, 3) for number in (7, 8) for step in (1, 2, 3)]
    assert [step for part, step, _ in heard if part == "steps of 7"] == [1, 2, 3]
    assert executor.results(tasks.in_steps, [7, 8]) == [7, 8]  # nobody asks


@ANY
@pytest.mark.parametrize("number", [0, 1, 2])
def test_there_may_be_few_tasks(executor: AbstractExecutor, number: int):
    assert executor.results(tasks.square, range(number)) == [0, 1][:number]


@takes_turns
@ANY
def test_thousands_of_tiny_tasks(executor: AbstractExecutor):
    number = 300 if executor is SERIAL else 5_000
    assert executor.results(tasks.square, range(number)) == [number * number for number in range(number)]


@ANY
def test_tasks_are_taken_as_there_is_room_for_them(executor: AbstractExecutor):
    taken, done = itertools.count(), 0

    def then(_index: int, _result: int) -> None:
        nonlocal done
        done += 1
        assert latest[0] - done <= 3
        if done == 50:
            raise StopIteration("enough")

    latest = [0]

    def endless():
        for number in taken:
            latest[0] = number
            yield number

    with pytest.raises(StopIteration, match="enough"):
        executor.run(tasks.square, endless(), then)


@ANY
def test_libraries_have_one_thread(executor: AbstractExecutor):
    before = os.environ.get("OMP_NUM_THREADS")
    found = executor.results(tasks.process_and_threads, range(4))
    assert {threads for _, each in found for threads in each} == {1}
    is_serial = isinstance(executor, Serial)
    assert ({process for process, _ in found} == {os.getpid()}) == is_serial
    assert os.environ.get("OMP_NUM_THREADS") == before


@ANY
def test_tasks_have_the_environment_that_they_are_given(executor: AbstractExecutor, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delenv("GRAMMARLAB_B", raising=False)
    monkeypatch.setenv("GRAMMARLAB_A", "outside")
    within = executor.with_environment({"GRAMMARLAB_A": "a"}).with_environment({"GRAMMARLAB_B": "b"})
    assert within.results(tasks.variable, ["GRAMMARLAB_A", "GRAMMARLAB_B"]) == ["a", "b"]
    assert executor.results(tasks.variable, ["GRAMMARLAB_A", "GRAMMARLAB_B"]) == ["outside", None]
    assert (os.environ["GRAMMARLAB_A"], "GRAMMARLAB_B" in os.environ) == ("outside", False)


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_a_process_that_dies_is_replaced_and_its_task_done_again(tmp_path: Path, workers: int):
    marks = [tmp_path / (f"{number}.deadly" if number % 3 == 0 else str(number)) for number in range(8)]
    assert Processes(workers).results(tasks.die_once, marks) == [mark.name for mark in marks]
    assert len(list(tmp_path.iterdir())) == 3


def test_a_process_that_somebody_ends_politely_is_replaced_too():
    with pytest.raises(WorkerError, match=r"^3: the process that worked on it ended unasked, 3 times"):
        Processes(2).results(tasks.die_of_signal, range(5))


@pytest.mark.parametrize("workers", [1, 2])
def test_a_task_that_always_kills_is_named_after_a_few_times(tmp_path: Path, workers: int):
    marks = [tmp_path / name for name in ("a", "b.deadly", "c")]
    with pytest.raises(
        WorkerError, match=r"b\.deadly: .* 3 times \(it was killed.*memory is short.*Try fewer"
    ) as raised:
        Processes(workers).results(tasks.count_and_die, marks)
    assert len(str(raised.value)) < 500
    assert (tmp_path / "b.deadly").read_text() == "x" * MAX_ATTEMPTS


@ANY
@pytest.mark.parametrize(
    ("kind", "error", "message"),
    [
        ("value", ValueError, "^value is wrong"),
        ("memory", MemoryError, "^memory is wrong"),
        ("interrupt", KeyboardInterrupt, "^interrupt is wrong"),
        ("exit", SystemExit, "^7"),
    ],
)
def test_errors_cross_with_type_and_message(
    executor: AbstractExecutor, kind: str, error: type[BaseException], message: str
):
    with pytest.raises(error, match=message):
        executor.results(tasks.fail, [kind] * 3)


@ANY
def test_errors_cross_with_what_they_carry(executor: AbstractExecutor):
    with pytest.raises(LanguageError) as raised:
        executor.results(tasks.fail, ["findings"] * 2)
    assert [(one.code, one.location.line) for one in raised.value.findings] == [("odd", 2)]
    assert "^" in str(raised.value)


@pytest.mark.parametrize(
    ("kind", "message"), [("reason", "ReasonError: nothing at 5"), ("local", "HereError: made here")]
)
def test_errors_that_cannot_cross_are_told(kind: str, message: str):
    with pytest.raises(RuntimeError, match=message):
        Processes(2).results(tasks.fail, [kind] * 2)


def test_results_that_cannot_cross_are_an_error():
    with pytest.raises((pickle.PicklingError, AttributeError), match="no_value"):
        Processes(2).results(tasks.no_value, range(2))


@ANY
def test_nothing_runs_on_after_an_error_of_the_one_who_listens(executor: AbstractExecutor):
    def then(_index: int, _result: int) -> None:
        raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        executor.run(tasks.square, range(100), then)


@pytest.mark.parametrize("executor", [SERIAL, Processes(2), Processes(4)], ids=["serial", "2", "4"])
def test_executors_may_stand_in_each_other(executor: AbstractExecutor):
    assert tasks.squares_of_squares(executor, [range(3), range(2)]) == [[0, 1, 4], [0, 1]]


@ANY
def test_an_executor_is_a_value(executor: AbstractExecutor):
    assert pickle.loads(pickle.dumps(executor)) == executor  # noqa: S301 - made right here
    assert executor.with_environment({"A": "b"}) != executor


def test_shares_are_what_there_is_divided_by_the_tasks():
    assert [Processes(8).share(number) for number in (0, 1, 3, 5, 100)] == [
        Processes(8),
        Processes(8),
        Processes(2),
        SERIAL,
        SERIAL,
    ]
    assert Processes(4, {"A": "b"}).share(4) == Serial({"A": "b"})


def test_an_executor_is_chosen_by_a_number():
    assert (executor_of(1), executor_of(3)) == (SERIAL, Processes(3))
    assert executor_of(0) == executor_of(available_cores())


def parent_of(tmp_path: Path, script: str) -> subprocess.Popen[str]:
    """A process whose workers have begun with two tasks."""
    names = [str(tmp_path / str(number)) for number in range(6)]
    run = "Processes(2).results(tasks.begin_and_sleep, map(Path, sys.argv[1:]))"
    imports = "import signal, sys; from pathlib import Path; from grammarlab.runs.work.executors import *"
    code = f"{imports}; from tests.runs import tasks; {script}; {run}"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    parent = subprocess.Popen([sys.executable, "-c", code, *names], env=environment, stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + PATIENCE
    while sum(Path(name).exists() for name in names) < 2:
        assert time.monotonic() < end
        time.sleep(0.05)
    return parent


@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_no_worker_is_left_when_its_parent_is_ended(tmp_path: Path, ending: signal.Signals):
    # Where tests run in the background, Ctrl-C is ignored unless somebody asks for it.
    with parent_of(tmp_path, "signal.signal(signal.SIGINT, signal.default_int_handler)") as parent:
        processes = descendants(parent.pid)
        parent.send_signal(ending)
        _, said = parent.communicate(timeout=PATIENCE)
    assert len(processes) >= 2
    expect_gone(processes)
    assert "BrokenProcessPool" not in said
    if ending == signal.SIGINT:
        assert said.rstrip().endswith("KeyboardInterrupt")
        assert len(list(tmp_path.glob("*.tidy"))) == 2


def test_a_script_that_does_not_guard_what_it_runs_is_told_how(tmp_path: Path):
    script = tmp_path / "script.py"
    script.write_text(
        "from grammarlab.runs.work.executors import Processes\nprint(Processes(2).results(abs, range(3)))"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(
        [sys.executable, script], env=environment, capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 1
    assert "WorkerError: worker processes import the script that starts them" in done.stderr
    assert 'if __name__ == "__main__":' in done.stderr
    assert done.stderr.count("Traceback") == 1


def test_a_signal_while_a_process_ends_says_nothing(capfd: pytest.CaptureFixture[str]):
    assert Processes(2).results(tasks.terminated_at_the_end, range(3)) == [0, 1, 2]
    assert capfd.readouterr().err == ""


def test_a_signal_in_a_destructor_says_nothing(capfd: pytest.CaptureFixture[str]):
    # What the signal raises there is lost, so the process does its tasks until its connection is closed.
    assert Processes(2).results(tasks.terminated_in_a_destructor, range(3)) == [0, 1, 2]
    assert capfd.readouterr().err == ""
