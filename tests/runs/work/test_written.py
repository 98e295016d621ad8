"""A command removes what its earlier run wrote, and nothing else."""

import json

import pytest

from grammarlab.files import file_hash
from grammarlab.runs.work.run_folder import WRITTEN, replace_written


def write(folder, command, **contents):
    paths = [folder / name for name in contents]
    for path, content in zip(paths, contents.values(), strict=True):
        path.write_text(content)
    replace_written(folder, command, paths)


def names(folder):
    return sorted(path.name for path in folder.iterdir() if path.name != WRITTEN)


def test_files_of_the_earlier_run_go_and_all_others_stay(tmp_path):
    write(tmp_path, "edit", a="1", b="2", c="3", d="4")
    write(tmp_path, "match", e="5")
    (tmp_path / "mine").write_text("mine")
    (tmp_path / "c").write_text("changed")
    (tmp_path / "d").rename(tmp_path / "kept")
    (tmp_path / "d").symlink_to(tmp_path / "kept")
    write(tmp_path, "edit", a="1")
    assert names(tmp_path) == ["a", "c", "d", "e", "kept", "mine"]
    write(tmp_path, "match")
    assert names(tmp_path) == ["a", "c", "d", "kept", "mine"]


def test_an_input_is_not_removed(tmp_path):
    write(tmp_path, "edit", a="1", b="2")
    replace_written(tmp_path, "edit", [tmp_path / "a"], [tmp_path / "b", tmp_path / "missing"])
    assert names(tmp_path) == ["a", "b"]


@pytest.mark.parametrize("record", ["", "[]", "[" * 100_000, '{"edit": 3}', '{"edit": {"mine": 3, "\\u0000": "x"}}'])
def test_the_record_of_a_stranger_removes_nothing(tmp_path, record):
    (tmp_path / "mine").write_text("mine")
    (tmp_path / WRITTEN).write_text(record)
    write(tmp_path, "edit", a="1")
    assert names(tmp_path) == ["a", "mine"]


def test_a_record_reaches_neither_out_of_its_folder_nor_through_links(tmp_path):
    victim, folder = tmp_path / "victim", tmp_path / "out"
    victim.mkdir()
    folder.mkdir()
    (victim / "thesis.txt").write_text("precious")
    (folder / "d").symlink_to(victim)
    digest = file_hash(victim / "thesis.txt")
    listed = ["d/thesis.txt", "../victim/thesis.txt", str(victim / "thesis.txt")]
    (folder / WRITTEN).write_text(json.dumps({"edit": dict.fromkeys(listed, digest)}))
    write(folder, "edit", a="1")
    assert (victim / "thesis.txt").read_text() == "precious"
