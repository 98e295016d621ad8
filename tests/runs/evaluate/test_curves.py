import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from grammarlab.evaluation.methods import Method
from grammarlab.evaluation.respondents import RESPONDENTS
from grammarlab.runs.evaluate.curve_store import STORE, curves_in
from grammarlab.runs.evaluate.curve_tasks import run_tasks
from grammarlab.runs.work.executors import SERIAL, Processes
from tests.runs.evaluate.doubles import make, refuse, tasks
from tests.waiting import wait_until

ROOT = Path(__file__).parents[3]


def read(folder):
    return curves_in(folder).all()


def test_the_curves_do_not_depend_on_the_number_of_workers(tmp_path):
    one = run_tasks(make, tasks(2), tmp_path / "one", executor=SERIAL)
    two = run_tasks(make, tasks(2), tmp_path / "two", executor=Processes(2))
    assert one == two
    assert read(tmp_path / "one") == read(tmp_path / "two")
    assert len(read(tmp_path / "one")) == len(one)
    assert [record.seed for record in one] == [0, 1, 0, 1]
    assert [record.method for record in one] == ["default"] * 2 + ["paper"] * 2


def test_a_run_that_was_killed_goes_on_and_ends_as_if_nothing_had_happened(tmp_path):
    whole = run_tasks(make, tasks(2), tmp_path / "whole")
    code = "import sys; from tests.runs.evaluate.doubles import run_two; run_two(sys.argv[1])"
    with subprocess.Popen([sys.executable, "-c", code, tmp_path / "killed"], cwd=ROOT) as process:
        store = tmp_path / "killed" / STORE
        wait_until(lambda: len(list(store.glob("[!.]*.json"))) == 2 or process.poll() is not None)
        process.send_signal(signal.SIGKILL)
    kept = {record.key for record in read(tmp_path / "killed").values()}
    assert len(kept) == 2
    done = []
    again = run_tasks(
        lambda task: refuse(task) if task.key in kept else make(task),
        tasks(2),
        tmp_path / "killed",
        on_progress=lambda *step: done.append(step),
    )
    assert again == whole
    assert done[0] == ("curves", len(kept), len(whole))
    assert done[-1] == ("curves", len(whole), len(whole))


def test_each_person_has_a_curve_of_their_own():
    (task, *_) = tasks(1)
    persons = [replace(task, person=person) for person in RESPONDENTS.values()]
    assert len({person.key for person in persons}) == len(RESPONDENTS)
    assert persons[0].key == task.key


def test_an_interrupted_run_keeps_what_is_finished(tmp_path):
    def work(task):
        if task.seed == 2:
            raise KeyboardInterrupt
        return make(task)

    with pytest.raises(KeyboardInterrupt):
        run_tasks(work, tasks(), tmp_path)
    assert [record.seed for record in read(tmp_path).values()].count(2) == 0
    assert len(read(tmp_path)) == 4


def test_a_fresh_run_forgets_what_was_there(tmp_path):
    run_tasks(make, tasks(1), tmp_path)
    run_tasks(make, tasks(3)[1:2], tmp_path, fresh=True)
    assert [record.seed for record in read(tmp_path).values()] == [1]


def test_a_longer_curve_serves_for_a_shorter_one_that_it_begins_with(tmp_path):
    run_tasks(make, tasks(1, 64), tmp_path)
    shorter = run_tasks(refuse, tasks(1, 32), tmp_path)
    assert shorter == run_tasks(make, tasks(1, 32), tmp_path / "other")
    with pytest.raises(AssertionError, match="there already"):
        run_tasks(refuse, tasks(1, 20), tmp_path)
    longer = run_tasks(make, tasks(1, 96), tmp_path)
    assert [record.curve.points[-1].labels for record in longer] == [96, 96]


def test_a_longer_and_a_shorter_curve_in_one_run_are_made_once(tmp_path):
    together = [*tasks(1, 32), *tasks(1, 64), *tasks(1, 20)]
    made = []

    def work(task):
        made.append(task.max_labels)
        return make(task)

    records = run_tasks(work, together, tmp_path)
    assert sorted(made) == [20, 20, 64, 64]
    assert [record.max_labels for record in records] == [32, 32, 64, 64, 20, 20]
    assert records == run_tasks(refuse, together, tmp_path)
    assert records[:2] == run_tasks(make, tasks(1, 32), tmp_path / "other")


def test_equal_curves_of_different_names_are_made_once(tmp_path):
    task = tasks(1)[0]
    made = []

    def work(task):
        made.append(task)
        return make(task)

    other = replace(task, method=replace(task.method, name="mine"))
    records = run_tasks(work, [task, other, task], tmp_path)
    assert len(made) == 1
    assert [record.method for record in records] == ["default", "mine", "default"]


@pytest.mark.parametrize(
    "change",
    [
        {"source_key": "other"},
        {"seed": 5},
        {"method": Method("default", batch=9)},
        {"method": Method("a", query="grammar")},
    ],
)
def test_whatever_decides_a_curve_decides_its_key(change):
    task = tasks(1)[0]
    assert replace(task, **change).key != task.key
    assert replace(task, max_labels=5, cache=Path("elsewhere")).key == task.key
