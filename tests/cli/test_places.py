"""Folders where a file is to be written, and files where a folder is: told before anything is done."""

import pytest


@pytest.mark.parametrize(
    "command",
    [
        ("learn", "toy", "--scenario", "B1", "-o"),
        ("label", "B1", "-o"),
        ("compare", "toy", "toy", "--picture"),
        ("show", "toy", "--graph"),
        ("evaluate", "B1", "--report"),
    ],
)
@pytest.mark.parametrize("place", ["folder", ""])
def test_a_folder_where_a_file_is_to_be_written_is_refused(run, tmp_path, monkeypatch, command, place):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    assert "is a directory" in run(*command, place, code=2).stderr


@pytest.mark.parametrize(
    "command",
    [
        ("sample", "toy", "-o"),
        ("evaluate", "B1", "-o"),
        ("evaluate", "B1", "--cache"),
        ("learn", "toy", "--scenario", "B1", "--report"),
    ],
)
def test_a_file_where_a_folder_is_to_be_written_is_refused(run, tmp_path, command):
    (tmp_path / "file").write_text("mine")
    assert "is a file" in run(*command, tmp_path / "file", code=2).stderr
    assert (tmp_path / "file").read_text() == "mine"
