"""Measurements are made once, survive a crash, and damaged files are refused."""

import pytest

from grammarlab.errors import GrammarlabError
from grammarlab.runs.evaluate.kept import Kept


def never():
    raise AssertionError("made again")


def test_what_was_measured_is_not_measured_again(tmp_path):
    path = tmp_path / "new" / "kept.jsonl"
    assert Kept(path).get("a", lambda: {"js": 0.5}) == {"js": 0.5}
    kept = Kept(path)
    assert "a" in kept
    assert kept.get("a", never) == {"js": 0.5}
    assert "a" not in Kept(path, fresh=True)


def test_a_half_written_line_is_cut_off(tmp_path):
    path = tmp_path / "kept.jsonl"
    Kept(path).put("a", {"js": 0.5})
    with path.open("ab") as file:
        file.write(b'{"key": "b", "val')
    Kept(path).put("c", {})
    again = Kept(path)
    assert ("a" in again, "b" in again, "c" in again) == (True, False, True)


@pytest.mark.parametrize("line", [b"{}", b"[]", b"x", b'{"key": 1, "values": 7}', b"\xff", b"[" * 10_000])
def test_damaged_files_are_refused(tmp_path, line):
    path = tmp_path / "kept.jsonl"
    path.write_bytes(line + b"\n")
    with pytest.raises(GrammarlabError, match="expected a measurement"):
        Kept(path)
