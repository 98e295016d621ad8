"""Progress and clusters are the same for every command that has them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import rich.progress

from grammarlab.cli import progress
from tests.cases import some
from tests.cli.test_city import PLAN
from tests.cli.test_city import RULES as BOXES
from tests.runs.evaluate.test_samples import RULES, SCENARIO

COMMANDS = {
    "sample": ("sample", "boxes.cga", "-n", 2, "--no-image", "-o", "out"),
    "sample --no-models": ("sample", "boxes.cga", "-n", 2, "--no-models", "-o", "out"),
    "evaluate": ("evaluate", "boxes.toml", "--methods", "kde", "--seeds", 1, "--max-labels", 8, "-o", "out"),
    "learn": ("learn", "boxes.cga", "--scenario", "boxes.toml", "--method", "parameters", "--samples", 64),
    "label": ("label", "boxes.toml", "-n", 8, "--method", "kde"),
    "city build": ("city", "build", "plan.toml", "-o", "out"),
}


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The current folder, with what the commands read."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "boxes.cga").write_text(RULES)
    (tmp_path / "boxes.toml").write_text(SCENARIO)
    (tmp_path / "rules.cga").write_text(BOXES)
    (tmp_path / "plan.toml").write_text(PLAN.replace('density = "zones.json"\n', ""))


@pytest.mark.parametrize("command", some(list(COMMANDS)))
@pytest.mark.usefixtures("files")
def test_programs_read_progress_as_lines_of_stderr_and_one_object_on_stdout(run: Any, command: str):
    result = run(*COMMANDS[command], "--json")
    json.loads(result.stdout)
    events = [json.loads(line) for line in result.stderr.splitlines() if line.startswith("{")]
    assert {event["event"] for event in events} == {"progress"}
    parts = {"labelled models of boxes, kde, seed 0", "models of boxes, kde, seed 0"}
    assert command != "evaluate" or parts < {event["task"] for event in events}
    for event in events:
        assert event["done"] <= event["total"]
        assert set(event) == {"event", "task", "done", "total", "per_second", "seconds_left"}
    assert events[-1]["done"] == events[-1]["total"] > 0


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.usefixtures("files")
def test_every_command_with_a_cluster_refuses_an_address_of_none(run: Any, command: str):
    result = run(*COMMANDS[command], "--scheduler", "nowhere", code=2)
    assert result.stderr.startswith("error: expected a Dask scheduler at 'nowhere', found none")
    assert not Path("out").exists()


def test_progress_is_shown_at_times_and_at_the_end_with_its_rate(monkeypatch: pytest.MonkeyPatch):
    now, shown = 0.0, list[tuple[Any, ...]]()
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    pace = progress.Pace(1.0, lambda *values: shown.append(values))
    for done in range(0, 41, 10):
        pace("models", done + 60, 100)
        now += 0.6
    assert shown == [
        ("models", 60, 100, 0.0, None),
        ("models", 80, 100, pytest.approx(20 / 1.2), pytest.approx(1.2)),
        ("models", 100, 100, pytest.approx(40 / 2.4), 0.0),
    ]
    pace("models", 30, 100)
    assert shown[-1] == ("models", 30, 100, 0.0, None)  # another task of this name


def test_a_second_task_of_a_name_has_rates_of_its_own(monkeypatch: pytest.MonkeyPatch):
    now, shown = 0.0, list[tuple[Any, ...]]()
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    pace = progress.Pace(1.0, lambda *values: shown.append(values))
    for start in (0.0, 1000.0):
        now = start
        for done in (10, 50, 100):
            pace("models", done, 100)
            now += 2.0
    assert shown[3:] == shown[:3]
    assert shown[1] == ("models", 50, 100, 20.0, 2.5)


def test_a_bar_of_a_second_task_of_a_name_is_not_finished_from_the_beginning(monkeypatch: pytest.MonkeyPatch):
    made: list[rich.progress.Progress] = []

    def start(bars: rich.progress.Progress) -> None:
        made.append(bars)

    monkeypatch.setattr(progress.sys.stderr, "isatty", lambda: True)
    monkeypatch.setattr(rich.progress.Progress, "start", start)
    with progress.progress() as show:
        for done in (1, 10, 1, 2):
            show("models", done, 10)
        (bar,) = made[0].tasks
        assert (bar.completed, bar.finished, bar.visible) == (2, False, True)
