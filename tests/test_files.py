"""Files and folders are whole or not there."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from grammarlab.errors import AssetError, UsageError
from grammarlab.files import (
    PART_PREFIX,
    atomic_file,
    atomic_folder,
    check_overwrites,
    existing,
    read_bounded,
    remove_parts,
    write_bytes,
    write_text,
)

LASTING = pytest.mark.parametrize("lasting", [True, False])


@LASTING
def test_a_file_appears_when_it_is_whole_and_not_before(tmp_path, lasting):
    path = tmp_path / "a.txt"
    write_text(path, "old")
    with atomic_file(path, lasting=lasting) as part:
        part.write_text("new")
        assert (part.parent, part.suffix, path.read_text()) == (tmp_path, ".txt", "old")
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


@LASTING
def test_a_failure_leaves_what_was_there(tmp_path, lasting):
    path = tmp_path / "a.txt"
    write_text(path, "old")

    def interrupted() -> None:
        with atomic_file(path, lasting=lasting) as part:
            part.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_text_has_unix_line_ends_and_names_may_be_as_long_as_names_can_be(tmp_path):
    path = tmp_path / ("a" * 251 + ".txt")
    write_text(path, "längst\nhier\n")
    assert path.read_bytes() == "längst\nhier\n".encode()


def test_threads_that_write_one_file_do_not_meet(tmp_path):
    contents = [bytes([number]) * 100_000 for number in range(40)]
    with ThreadPoolExecutor(8) as threads:
        list(threads.map(lambda content: write_bytes(tmp_path / "a", content, lasting=False), contents))
    assert (tmp_path / "a").read_bytes() in contents
    assert len(list(tmp_path.iterdir())) == 1


def test_a_folder_replaces_another_one_as_a_whole(tmp_path):
    path = tmp_path / "new" / "folder"
    for names in ("ab", "c"):
        with atomic_folder(path, "abcd") as part:
            for name in names:
                (part / name).touch()
        assert sorted(file.name for file in path.iterdir()) == list(names)

    def interrupted() -> None:
        with atomic_folder(path, "abcd") as part:
            (part / "d").touch()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert [file.name for file in path.iterdir()] == ["c"]
    assert list(path.parent.iterdir()) == [path]


def test_what_a_killed_process_left_is_removed_and_nothing_else(tmp_path):
    code = f"""
import os, signal, sys
from pathlib import Path
from grammarlab.files import atomic_file, atomic_folder
with atomic_folder(Path(sys.argv[1], "folder"), "a") as folder, atomic_file(Path(sys.argv[1], "file")) as file:
    (folder / "a").touch()
    file.touch()
    os.kill(os.getpid(), {int(signal.SIGKILL)})
"""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run([sys.executable, "-c", code, tmp_path], env=environment, check=False)
    assert done.returncode == -signal.SIGKILL
    (tmp_path / "mine").touch()
    left = sorted(path.name for path in tmp_path.iterdir())
    assert [name for name in left if not name.startswith(PART_PREFIX)] == ["mine"]
    assert len(left) == 3
    remove_parts(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


def test_an_input_is_not_written_over_by_any_of_its_names(tmp_path):
    (tmp_path / "scores.csv").write_text("scores")
    (tmp_path / "link.csv").symlink_to(tmp_path / "scores.csv")
    (tmp_path / "other.csv").write_text("scores")
    inputs = [tmp_path / "missing.csv", tmp_path / "scores.csv"]
    check_overwrites([tmp_path / "new.cga", tmp_path / "other.csv", tmp_path / "missing.csv"], inputs)
    for name in ("scores.csv", "link.csv", "../" + tmp_path.name + "/scores.csv"):
        with pytest.raises(UsageError, match="is the input file"):
            check_overwrites([tmp_path / "new.cga", tmp_path / name], inputs)


def test_a_text_that_is_too_long_for_a_name_names_no_file(tmp_path):
    (tmp_path / "here.txt").touch()
    assert existing(str(tmp_path / "here.txt")) == tmp_path / "here.txt"
    assert existing(str(tmp_path)) == tmp_path
    for text in (str(tmp_path / "missing"), "a" * 300, "a" * 5000, "a/" * 5000, "with\0zero"):
        assert existing(text) is None


def test_a_file_is_read_up_to_its_bound(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(bytes(range(10)))
    assert read_bounded(path, 10) == bytes(range(10))
    with pytest.raises(AssetError, match="at most 9 bytes"):
        read_bounded(path, 9)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_without_a_writer_and_a_device_without_an_end_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/zero")):
        with pytest.raises(AssetError, match="expected a regular file"):
            read_bounded(path, 10)
    with pytest.raises(OSError, match=str(tmp_path)):
        read_bounded(tmp_path, 10)
