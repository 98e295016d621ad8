"""Files and folders are whole or not there."""

import json
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
    file_below,
    folder_below,
    open_regular,
    read_bounded,
    remove_parts,
    rewrite_text,
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


def test_other_files_with_names_like_parts_stay(tmp_path):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "mine.png").touch()
    (tmp_path / f"{PART_PREFIX}photos").mkdir()
    (tmp_path / f"{PART_PREFIX}0123456789abcdef.png").symlink_to(tmp_path / "photos" / "mine.png")
    (tmp_path / f"{PART_PREFIX}0123456789abcdee").symlink_to(tmp_path / "photos")
    remove_parts(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"{PART_PREFIX}photos", "photos"]
    assert (tmp_path / "photos" / "mine.png").exists()


def test_what_a_running_writer_has_not_finished_stays(tmp_path):
    with atomic_folder(tmp_path / "folder", "a") as folder, atomic_file(tmp_path / "file") as file:
        (folder / "a").touch()
        remove_parts(tmp_path)
        assert (folder / "a").exists()
        assert file.exists()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder"]


def test_a_folder_keeps_files_of_other_names(tmp_path):
    for name in ("a", "b", "mine"):
        (tmp_path / name).write_text("old")
    with atomic_folder(tmp_path, "abc") as part:
        (part / "c").write_text("new")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"c": "new", "mine": "old"}


def test_errors_name_the_file_and_not_its_part(tmp_path):
    def fail(error):
        with atomic_file(tmp_path / "a.txt") as part:
            raise error(part)

    for error in (
        lambda _part: OSError(28, "No space left on device"),
        lambda part: OSError(28, "No space left on device", str(part)),
        lambda _part: OSError("encoder error -2"),
    ):
        with pytest.raises(OSError, match=r"space|encoder") as caught:
            fail(error)
        assert caught.value.filename == str(tmp_path / "a.txt")
    with pytest.raises(OSError, match="another"):
        fail(lambda _part: OSError(13, "denied", "another"))
    with pytest.raises(FileNotFoundError, match=r"missing/a\.txt"), atomic_file(tmp_path / "missing" / "a.txt"):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_file_opened_for_editing_keeps_its_link_and_permissions(tmp_path):
    (tmp_path / "real").mkdir()
    path = tmp_path / "real" / "a.txt"
    path.write_text("old")
    path.chmod(0o600)
    (tmp_path / "link.txt").symlink_to("real/a.txt")
    rewrite_text(tmp_path / "link.txt", "new")
    assert (path.read_text(), path.stat().st_mode & 0o777) == ("new", 0o600)
    assert (tmp_path / "link.txt").is_symlink()
    rewrite_text(tmp_path / "new.txt", "new")
    assert (tmp_path / "new.txt").read_text() == "new"


def test_names_of_strangers_stay_below_a_folder_and_follow_no_link(tmp_path):
    inside, outside = tmp_path / "in", tmp_path / "out"
    (inside / "deep").mkdir(parents=True)
    outside.mkdir()
    for path in (inside / "a", inside / "deep" / "b", outside / "c"):
        path.touch()
    (inside / "link").symlink_to(outside)
    (inside / "file").symlink_to(inside / "a")
    (tmp_path / "root").symlink_to(inside)
    names = ["a", "deep/b", "deep", "link/c", "link", "file", "../out/c", str(outside / "c"), "missing", "a/b"]
    names += ["", ".", "..", "a\0", "x" * 5000, "deep\\b", "C:a", "deep/../a", "\ud800"]
    for folder in (inside, tmp_path / "root"):
        assert [name for name in names if file_below(folder, name)] == ["a", "deep/b"]
        assert [name for name in names if folder_below(folder, name)] == ["deep"]


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


def test_text_with_bytes_of_file_names_is_written_as_json_writes_it(tmp_path):
    name = os.fsdecode(b"b\xff")
    write_text(tmp_path / "a.json", json.dumps({"name": name, "word": "é"}, ensure_ascii=False))
    assert json.loads((tmp_path / "a.json").read_text(encoding="utf-8")) == {"name": name, "word": "é"}


def test_a_part_of_a_file_of_any_size_may_be_read(tmp_path):
    write_bytes(tmp_path / "a", b"12345")
    with open_regular(tmp_path / "a") as file:
        assert file.read(3) == b"123"
    with pytest.raises(AssetError, match="at most 4 bytes"), open_regular(tmp_path / "a", 4):
        pass
