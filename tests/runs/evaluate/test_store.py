import pytest

from grammarlab.errors import GrammarlabError
from grammarlab.evaluation.curves import Curve, Point
from grammarlab.runs.evaluate.store import STORE, CurveRecord, append, clear, read


def record(key="a", max_labels=32, js=0.1 + 0.2):
    return CurveRecord(
        key, "F1", "default", 3, max_labels, 0.3, Curve((Point(16, js, 0.5, 0), Point(32, 1e-300, 1.0, 7)))
    )


def test_what_is_written_is_read_back_to_the_last_bit(tmp_path):
    append(tmp_path, record("a"))
    append(tmp_path, record("b", js=1 / 3))
    assert read(tmp_path) == {"a": {32: record("a")}, "b": {32: record("b", js=1 / 3)}}


def test_curves_of_one_key_are_told_apart_by_what_they_were_made_for(tmp_path):
    for max_labels in (32, 64, 48):
        append(tmp_path, record(max_labels=max_labels))
    assert list(read(tmp_path)["a"]) == [32, 64, 48]


def test_every_beginning_of_a_store_is_a_store(tmp_path):
    append(tmp_path, record("a"))
    append(tmp_path, record("b"))
    content = (tmp_path / STORE).read_bytes()
    first_line = content.index(b"\n") + 1
    for length in range(len(content) + 1):
        (tmp_path / STORE).write_bytes(content[:length])
        expected = ["a", "b"] if length == len(content) else ["a"] if length >= first_line else []
        assert list(read(tmp_path)) == expected
        append(tmp_path, record("c"))
        assert list(read(tmp_path)) == [*expected, "c"]


LINE = (
    b'{"key": "a", "scenario": "F1", "method": "paper", "seed": 0, "max_labels": 32, '
    b'"js_original": 0.3, "curve": [[32, 0.1, 1, 4]]}'
)


@pytest.mark.parametrize(
    "line",
    [
        b"nonsense",
        b"{}",
        b"[]",
        b'{"key": 1}',
        b"[" * 100_000,
        b"\xff",
        b'{"curve": [[1, 2]]}',
        b"null",
        LINE.replace(b"0.3,", b"NaN,"),
        LINE.replace(b"32,", b"1e999,"),
    ],
)
def test_a_store_of_somebody_else_is_refused_with_its_line(tmp_path, line):
    append(tmp_path, record())
    with (tmp_path / STORE).open("ab") as file:
        file.write(line + b"\n")
    with pytest.raises(GrammarlabError, match=r"curves.jsonl:2: expected a curve"):
        read(tmp_path)
    clear(tmp_path)
    assert read(tmp_path) == {}
