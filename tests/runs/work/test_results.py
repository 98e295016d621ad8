"""Finished results are there when they are whole, and made again when they are damaged."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from grammarlab.runs.work.executors import SERIAL, AbstractExecutor, Processes
from grammarlab.runs.work.results import Kind, Results, adopt_lines, computed, json_kind
from tests.runs.tasks import square

KIND: Kind[dict[str, Any]] = json_kind(dict, dict)
VALUE = {"js": 0.1 + 0.2, "small": 1e-300, "name": "längst"}


def silent(_what: str, _done: int, _total: int) -> None:
    """Nobody listens."""


def test_what_is_kept_is_read_back_to_the_last_bit(tmp_path: Path):
    results = Results(tmp_path / "new" / "folder", KIND)
    assert (results.get("a"), results.all()) == (None, {})
    results.put("a", VALUE)
    results.put("b", {})
    results.put("b", {"n": 1})
    assert (results.get("a"), results.all()) == (VALUE, {"a": VALUE, "b": {"n": 1}})


def test_clearing_removes_results_and_no_other_files(tmp_path: Path):
    results = Results(tmp_path / "folder", KIND)
    keys = ["0" * 64, "f" * 64 + "-128"]
    for key in (*keys, "package"):
        results.put(key, VALUE)
    (tmp_path / "link").symlink_to(results.folder)
    Results(tmp_path / "link", KIND).clear()
    assert results.all().keys() == {*keys, "package"}
    results.clear()
    assert results.all() == {"package": VALUE}


@pytest.mark.parametrize("lasting", [True, False])
def test_every_beginning_of_a_file_but_the_whole_counts_as_none(tmp_path: Path, lasting: bool):
    results = Results(tmp_path, KIND, lasting)
    results.put("a", VALUE)
    (file,) = tmp_path.iterdir()
    content = file.read_bytes()
    for length in range(len(content) - 1):  # the last byte ends the line
        file.write_bytes(content[:length])
        assert results.get("a") is None
        assert results.all() == {}
    results.put("a", VALUE)
    assert results.all() == {"a": VALUE}


@pytest.mark.parametrize("content", [b"null", b"[1]", b"7", b"\xff", b"[" * 100_000, b'{"a": 1}x'])
def test_files_of_somebody_else_count_as_none(tmp_path: Path, content: bytes):
    (tmp_path / "a.json").write_bytes(content)
    assert Results(tmp_path, KIND).get("a") is None


def test_files_that_are_too_large_are_not_read(tmp_path: Path):
    results = Results(tmp_path, KIND)
    results.put("a", VALUE)
    assert Results(tmp_path, replace(KIND, most=10)).get("a") is None


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_pipes_and_devices_count_as_none_at_once(tmp_path: Path):
    os.mkfifo(tmp_path / "a.json")
    (tmp_path / "b.json").symlink_to("/dev/zero")
    assert Results(tmp_path, KIND).all() == {}
    adopt_lines(Results(tmp_path, KIND), tmp_path / "a.json", lambda entry: entry)


@pytest.mark.parametrize("executor", [SERIAL, Processes(2)])
def test_results_are_made_once_in_the_order_of_their_tasks(tmp_path: Path, executor: AbstractExecutor):
    results = Results(tmp_path, json_kind(int, int))
    steps: list[tuple[str, int, int]] = []
    results.put("3", -1)
    found = computed(
        results, square, {str(n): n for n in (5, 3, 4)}, executor, "squares", lambda *step: steps.append(step)
    )
    assert list(found.items()) == [("5", 25), ("3", -1), ("4", 16)]
    assert steps == [("squares", done, 3) for done in (1, 2, 3)]
    assert computed(results, forbidden, {"4": 4, "3": 3}, executor, "squares", silent) == {"4": 16, "3": -1}


def forbidden(_task: int) -> int:
    raise AssertionError("made again")


def test_an_interrupted_run_keeps_what_is_finished(tmp_path: Path):
    results = Results(tmp_path, json_kind(int, int))

    def work(number: int) -> int:
        if number == 2:
            raise KeyboardInterrupt
        return number

    with pytest.raises(KeyboardInterrupt):
        computed(results, work, {str(n): n for n in range(4)}, SERIAL, "numbers", silent)
    assert results.all() == {"0": 0, "1": 1}


def write_for_ever(folder: str) -> None:
    """Many processes do this in one folder, until they are killed."""
    results = Results(Path(folder), KIND, lasting=False)
    for number in range(10**9):
        results.put(str(number % 7), {"process": os.getpid(), "numbers": list(range(number % 1000))})


def test_processes_that_write_into_one_folder_may_be_killed_at_any_moment(tmp_path: Path):
    code = "import sys; from tests.runs.work.test_results import write_for_ever; write_for_ever(sys.argv[1])"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    results = Results(tmp_path, KIND)
    writers = [subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], env=environment) for _ in range(3)]
    try:
        while len(results.all()) < 7:
            time.sleep(0.02)
        for writer in writers:
            for _ in range(20):
                found = results.all()
                assert len(found) == 7
                assert all(each["numbers"] == list(range(len(each["numbers"]))) for each in found.values())
            writer.send_signal(signal.SIGKILL)
    finally:
        for writer in writers:
            writer.kill()
            writer.wait()
    assert len(results.all()) == 7


def test_lines_of_an_earlier_version_are_taken_in(tmp_path: Path):
    lines = tmp_path / "kept.jsonl"
    entries = [json.dumps({"key": key, "values": {"n": n}}) for key, n in (("a", 1), ("b-64", 2), ("../c", 3))]
    lines.write_text("\n".join([*entries[:2], "{}", "[", entries[2], '{"key": "d", "val']))
    results = Results(tmp_path / "kept", KIND)
    results.put("a", {"n": 7})
    for _ in range(2):
        adopt_lines(results, lines, lambda entry: (str(entry["key"]), dict(entry["values"])))
        assert results.all() == {"a": {"n": 7}, "b-64": {"n": 2}}
    assert {path.name for path in tmp_path.iterdir()} == {"kept", "kept.jsonl"}
    adopt_lines(results, tmp_path / "missing.jsonl", lambda entry: entry)
