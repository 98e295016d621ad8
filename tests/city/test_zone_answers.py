"""Tables of answers, as spreadsheets write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from grammarlab.city.zone_answers import ZoneAnswers, read_zone_answers
from grammarlab.errors import AssetError


def read(folder: Path, text: str, encoding: str = "utf-8") -> ZoneAnswers:
    (folder / "answers.csv").write_bytes(text.encode(encoding))
    return read_zone_answers(folder / "answers.csv")


def test_right_zones_and_scores_are_read(tmp_path: Path):
    zones = read(tmp_path, "id,zone\n007,park\n 8 ,tower\n")
    assert (zones.id.tolist(), zones.zone.tolist(), zones.score) == (["007", "8"], ["park", "tower"], None)
    scores = read(tmp_path, "ID;Zone;Score\n7;park;12,5\n7;tower;100\n")
    assert scores.score is not None
    assert (scores.zone.tolist(), scores.score.tolist()) == (["park", "tower"], [12.5, 100.0])


def test_spreadsheets_of_any_origin_have_equal_answers(tmp_path: Path):
    text = "id,zone\nA1,Grün\nA2,Haus\n"
    expected = read(tmp_path, text)
    forms = [
        ("sep=;\r\n" + text.replace(",", ";").replace("\n", "\r\n"), "cp1252"),
        ("\ufeff" + text, "utf-8"),
        (text.replace(",", "\t"), "utf-16"),
        ("note,zone,id\nx,Haus,A2\n,Gru\u0308n,A1\n,,\n", "utf-8"),
    ]
    for form, encoding in forms:
        assert read(tmp_path, form, encoding).hash == expected.hash


def test_the_hash_ignores_the_order_and_nothing_else(tmp_path: Path):
    one = read(tmp_path, "id,zone\na,b\nc,d\n").hash
    assert read(tmp_path, "id,zone\nc,d\na,b\n").hash == one
    others = ["id,zone\na,b\n", "id,zone\na,b\nc,d\nc,d\n", "id,zone\na,d\nc,b\n", "id,zone,score\na,b,100\nc,d,100\n"]
    assert len({one, *(read(tmp_path, text).hash for text in others)}) == 5


def test_rows_without_an_answer_are_left_out_and_counted(tmp_path: Path):
    answers = read(tmp_path, "id,zone\na,\nb,park\nc\n")
    assert (answers.id.tolist(), answers.line.tolist(), answers.num_blank) == (["b"], [3], 2)
    scores = read(tmp_path, "id,zone,score\na,park,\nb,park,3\n")
    assert (scores.id.tolist(), scores.num_blank) == (["b"], 1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected the columns id and zone, and perhaps score; found none"),
        ("parcel,zone\n1,a\n", "expected the columns id and zone, and perhaps score; found parcel, zone"),
        ("id,zone,zone\n1,a,b\n", "found id, zone, zone"),
        ("id,zone\n", "expected answers, found none in 0 rows"),
        ("id,zone\n1,\n", "expected answers, found none in 1 rows"),
        ("id,zone\n1,a\n,b\n", "line 3: expected the id of a parcel"),
        ("id,zone\n1," + "a" * 300, "line 2: expected zone = a line of at most 256"),
        ("id,zone\n1,a\x1b[2J\n", "line 2: expected zone = a line"),
        ("id,zone,score\n1,a,good\n", "line 2: .*good"),
        ("id,zone,score\n1,a,101\n", "line 2: expected a score from 0 to 100, found '101'"),
        ("id,zone,score\n1,a,-1\n", "line 2: expected a score from 0 to 100, found '-1'"),
        ('id,zone\n1,"a\n', "this is not valid CSV"),
        ("id,zone\n" + "1,a\n" * 50_001, "expected at most 50,001 rows"),
        ("id,zone\n1,a\0\n", "found bytes of zero"),
    ],
)
def test_mistakes_are_named_with_their_line(tmp_path: Path, text: str, message: str):
    with pytest.raises(AssetError, match=rf"answers\.csv: .*{message}"):
        read(tmp_path, text)


def test_a_missing_file_is_named(tmp_path: Path):
    with pytest.raises(AssetError, match="expected a table with the columns id and zone"):
        read_zone_answers(tmp_path / "answers.csv")
