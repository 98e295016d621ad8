"""A run that stops says how to go on, and going on ends as if it had not stopped."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from grammarlab.cli.console import Unfinished
from tests.cases import takes_turns
from tests.runs.grammars import TOWER
from tests.runs.processes import descendants
from tests.waiting import PATIENCE

COMMAND = [sys.executable, "-c", "from grammarlab.cli import main; main()"]


@pytest.mark.parametrize(
    ("words", "needs", "without", "expected"),
    [
        ("sample toy -n 5", "--resume", "", "sample toy -n 5 --resume"),
        ("sample toy --resume", "--resume", "", "sample toy --resume"),
        ("sample -o 'my out' -- toy", "--resume", "", "sample -o 'my out' --resume -- toy"),
        ("evaluate F1 --fresh --seeds 2", "", "--fresh", "evaluate F1 --seeds 2"),
    ],
)
def test_the_advice_is_the_users_own_command(monkeypatch, words, needs, without, expected):
    monkeypatch.setattr(sys, "argv", ["grammarlab", *shlex.split(words)])
    run = Unfinished(needs, without)
    assert run.advice() == ""
    run.note("models", 37, 1_000)
    assert run.advice() == f"stopped with 37 of 1,000 models done; go on with: grammarlab {expected}"


def workers(pid: int) -> list[int]:
    """The processes that do tasks for another one."""
    return [
        worker
        for worker in sorted(descendants(pid))
        if (line := Path(f"/proc/{worker}/cmdline")).exists() and b"spawn_main" in line.read_bytes()
    ]


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def begun(tmp_path: Path, out: str) -> subprocess.Popen[str]:
    """A run by two processes, after its first batch."""
    (tmp_path / "tower.cga").write_text(TOWER)
    options = ["-n", "450", "-o", out, "--no-image", "--jobs", "2"]
    process = subprocess.Popen(
        [*COMMAND, "sample", "tower.cga", *options], stderr=subprocess.PIPE, text=True, cwd=tmp_path
    )
    end = time.monotonic() + PATIENCE
    while not list((tmp_path / out).glob("derivations/*/models.json")):
        assert time.monotonic() < end
        time.sleep(0.01)
    return process


@takes_turns
def test_workers_that_are_killed_cost_nothing_but_time_until_there_are_too_many(tmp_path: Path):
    with begun(tmp_path, "once") as process:
        os.kill(workers(process.pid)[0], signal.SIGKILL)
        _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, said
    whole = contents(tmp_path / "once")
    assert len([name for name in whole if name.endswith(".glb")]) == 450
    assert not [name for name in whole if ".part" in name]
    with begun(tmp_path, "again") as process:
        while process.poll() is None:
            for worker in workers(process.pid):
                os.kill(worker, signal.SIGKILL)
            time.sleep(0.1)
        _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1, said
    assert "Traceback" not in said
    assert "--jobs 1" in said.splitlines()[-2]
    advice = said.splitlines()[-1]
    assert advice.startswith("stopped with ")
    assert advice.endswith("of 450 models done; go on with: grammarlab sample tower.cga " + OPTIONS)
    words = shlex.split(advice.partition("go on with: grammarlab ")[2])
    done = subprocess.run([*COMMAND, *words], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    assert contents(tmp_path / "again") == whole


OPTIONS = "-n 450 -o again --no-image --jobs 2 --resume"


def test_an_evaluation_says_how_to_go_on(run, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["grammarlab", "evaluate", "F1", "--fresh"])

    def stopped(*_arguments, on_progress, **_options):
        on_progress("curves", 3, 20)
        raise KeyboardInterrupt

    monkeypatch.setattr("grammarlab.runs.evaluate.run.evaluate_run", stopped)
    result = run("evaluate", "F1", "--fresh", "-o", tmp_path, code=130)
    assert result.stderr.splitlines() == [
        "interrupted: finished files stay valid.",
        "stopped with 3 of 20 curves done; go on with: grammarlab evaluate F1",
    ]


@pytest.mark.parametrize(("error", "code"), [(MemoryError(), 1), (OSError(28, "No space left on device"), 1)])
def test_a_sample_that_lacks_room_says_how_to_go_on(run, rules, tmp_path, monkeypatch, error, code):
    monkeypatch.setattr(sys, "argv", ["grammarlab", "sample", "house.cga"])

    def stopped(*_arguments, on_progress, **_options):
        on_progress("models", 3, 20)
        raise error

    monkeypatch.setattr("grammarlab.runs.sample.run.sample_run", stopped)
    said = run("sample", rules("Lot --> A."), "-o", tmp_path / "out", code=code).stderr.splitlines()
    assert said[-2].startswith("error: ")
    assert said[-1] == "stopped with 3 of 20 models done; go on with: grammarlab sample house.cga --resume"
