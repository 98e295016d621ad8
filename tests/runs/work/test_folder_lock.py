"""One run at a time writes into a folder, and nothing but its end decides when the next may."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from grammarlab.errors import UsageError
from grammarlab.files import atomic_file
from grammarlab.runs.work.run_folder import LOCK, only_run_in
from tests.waiting import wait_until


def enter(folder, inner=()):
    with only_run_in(folder, inner):
        pass


def test_a_second_run_is_refused_until_the_first_has_ended_and_nothing_remains(tmp_path):
    folder = tmp_path / "new" / "out"
    with only_run_in(folder):
        for _ in range(2):  # a refusal does not free the folder
            with pytest.raises(UsageError, match=rf"another run is writing into {folder}.*another folder"):
                enter(folder)
        enter(tmp_path / "other")
    enter(folder)
    assert list(folder.iterdir()) == []


def test_a_file_or_a_link_to_nothing_is_no_folder(tmp_path):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    for folder in (tmp_path / "file", tmp_path / "link"):
        with pytest.raises(UsageError, match=f"{folder} is a file or a link to nothing: expected a folder"):
            enter(folder)
    assert (tmp_path / "file").read_text() == "mine"
    (tmp_path / "real").mkdir()
    (tmp_path / "to-real").symlink_to(tmp_path / "real")
    enter(tmp_path / "to-real")


def test_of_many_threads_one_at_a_time_is_in_a_folder(tmp_path):
    inside = []

    def work(number):
        try:
            with only_run_in(tmp_path):
                inside.append(number)
                assert inside == [number]
                inside.remove(number)
        except UsageError:
            return 0
        return 1

    with ThreadPoolExecutor(8) as threads:
        assert sum(threads.map(work, range(200))) >= 1
    assert list(tmp_path.iterdir()) == []


HOLD = """
import sys, time
from pathlib import Path
from grammarlab.files import atomic_file
from grammarlab.runs.work.run_folder import only_run_in
with only_run_in(Path(sys.argv[1])), atomic_file(Path(sys.argv[1], "a.txt")):
    Path(sys.argv[1], "ready").touch()
    time.sleep(600)
"""


def test_a_killed_run_frees_its_folder_and_its_parts_go_with_the_next_run(tmp_path):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    process = subprocess.Popen([sys.executable, "-c", HOLD, tmp_path], env=environment)
    try:
        wait_until((tmp_path / "ready").exists, lambda: list(tmp_path.iterdir()))
        with pytest.raises(UsageError, match="another run"):
            enter(tmp_path)
        process.send_signal(signal.SIGKILL)
    finally:
        process.kill()
        process.wait()
    assert (tmp_path / LOCK).stat().st_size == 0
    assert len(list(tmp_path.iterdir())) == 3
    enter(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["ready"]


def test_the_part_of_another_writer_stays(tmp_path):
    with atomic_file(tmp_path / "labels.csv") as part:
        enter(tmp_path)
        part.write_text("scores")
    assert (tmp_path / "labels.csv").read_text() == "scores"


def test_what_has_the_name_of_the_lock_is_neither_followed_nor_removed(tmp_path):
    lock = tmp_path / "out" / LOCK
    lock.parent.mkdir()
    (tmp_path / "mine.txt").touch()

    def refused():
        with pytest.raises(UsageError, match="expected no file of this name"):
            enter(lock.parent)
        assert os.path.lexists(lock)

    lock.symlink_to(tmp_path / "mine.txt")
    refused()
    lock.unlink()
    lock.symlink_to(tmp_path / "missing.txt")
    refused()
    assert not (tmp_path / "missing.txt").exists()
    lock.unlink()
    lock.mkdir()
    refused()
    lock.rmdir()
    lock.write_text("mine")
    refused()
    lock.unlink()
    if hasattr(os, "mkfifo"):
        os.mkfifo(lock)
        refused()


def test_inner_folders_are_no_links(tmp_path):
    (tmp_path / "victim").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "plots").symlink_to(tmp_path / "victim")
    with pytest.raises(UsageError, match=r"plots: expected a folder.*found a link"):
        enter(tmp_path / "out", ("curves", "plots"))
    enter(tmp_path / "out", ("curves",))
