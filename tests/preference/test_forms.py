"""Label files as spreadsheets and other programs write them, and scales other than 0 to 100."""

import json
import re
from dataclasses import replace
from decimal import Decimal

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from grammarlab.errors import AssetError, UsageError
from grammarlab.preference.label_files import integer, on_one_scale, read_labels, score
from grammarlab.preference.labels import Kind, Label, Labels

HASH = "0123456789abcdef" * 4
OTHER = '{"seed":5,"model":17}'
HEAD = "seed,model,factor,score,grammar,start_rule,attributes,footprint,kind,other"
EXPECTED = Labels(
    (
        Label(3, 17, "Höhe", 12.5, HASH, attributes='{"height":12}'),
        Label(3, 0, "Höhe", 100.0, HASH, kind="rather", other=OTHER),
        Label(18446744073709551615, 1, "Höhe", 80.0, HASH),
    )
)
LARGEST = "18446744073709551615"
COMMAS = f'''{HEAD}
3,17,Höhe,12.5,{HASH},,"{{""height"":12}}",,score,
3,0,Höhe,,{HASH},,{{}},,rather,"{OTHER.replace('"', '""')}"
{LARGEST},1,Höhe,80,{HASH},,{{}},,score,
'''
SEMICOLONS = f'''{HEAD.replace(",", ";")}
3;17;Höhe;12,5;{HASH};;"{{""height"":12}}";;score;
3;0;Höhe;;{HASH};;{{}};;rather;"{OTHER.replace('"', '""')}"
{LARGEST};1;Höhe;80,0;{HASH};;{{}};;score;
'''
FORMS = {
    "as we write it": COMMAS,
    "semicolons and decimal commas": SEMICOLONS,
    "tabs": SEMICOLONS.replace(";", "\t"),
    "sep=": f"sep=;\n{SEMICOLONS}",
    "capitals": COMMAS.replace(HEAD, HEAD.title().replace(",", " , ")).replace("score,\n", "Score,\n"),
    "blanks": COMMAS.replace("3,17,Höhe,12.5", " 3 , 17 , Höhe , 12.5 "),
    "empty rows and columns": "\n".join(f"{line},," for line in COMMAS.splitlines()) + f"\n{',' * 11}\n\n",
    "whole numbers as floats": COMMAS.replace("3,17,", "3.0,17.0,").replace("3,0,", "3.00,0.0,"),
    "without empty cells at the end": COMMAS.replace(",,{},,score,\n", "\n"),
    "an index": "\n".join(f"{'' if n == 0 else n - 1},{line}" for n, line in enumerate(COMMAS.splitlines())),
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("form", FORMS)
def test_tables_of_text_are_read_in_every_form(tmp_path, form, encoding):
    path = tmp_path / "a.csv"
    path.write_bytes(FORMS[form].replace("\n", "\r\n").encode(encoding))
    labels = read_labels(path)
    assert labels == EXPECTED
    assert labels.notes == ()


@pytest.mark.parametrize(("suffix", "encoding"), [(".tsv", "utf-8"), (".txt", "utf-16")])
def test_a_table_with_tabs_has_the_suffix_that_its_program_gives_it(tmp_path, suffix, encoding):
    path = tmp_path / f"a{suffix}"
    path.write_text(FORMS["tabs"], encoding=encoding)
    assert read_labels(path) == EXPECTED


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_lines_of_json_are_read_in_every_form(tmp_path, encoding):
    rows = [
        {"seed": 3.0, "model": 17.0, "factor": "Höhe", "score": 12.5, "grammar": HASH, "attributes": '{"height":12}'},
        {"Seed": 3, "MODEL": 0, "factor": "Höhe", "score": None, "grammar": HASH, "kind": "rather", "other": OTHER},
        {"seed": LARGEST, "model": "1", "factor": "Höhe", "score": "80", "grammar": HASH, "kind": None, "other": None},
    ]
    path = tmp_path / "a.jsonl"
    path.write_bytes("\r\n\r\n".join(map(json.dumps, rows)).encode(encoding))
    assert read_labels(path) == EXPECTED


@pytest.mark.parametrize(
    ("seed", "score_type"),
    [(pa.uint64(), pa.float32()), (pa.decimal128(20, 0), pa.decimal128(5, 1)), (pa.string(), pa.float64())],
)
def test_parquet_columns_may_have_other_types(tmp_path, seed, score_type):
    scores = [12.5, None, 80.0] if not pa.types.is_decimal(score_type) else [Decimal("12.5"), None, Decimal(80)]
    seeds = [3, 3, int(LARGEST)]
    columns = {
        "Seed": pa.array(map(str, seeds) if pa.types.is_string(seed) else map(Decimal, seeds), seed)
        if not pa.types.is_integer(seed)
        else pa.array(seeds, seed),
        "model": pa.array([17.0, 0.0, 1.0], pa.float64()),
        "factor": pa.array(["Höhe"] * 3).dictionary_encode(),
        "score": pa.array(scores, score_type),
        "grammar": pa.array([HASH] * 3, pa.large_string()),
        "attributes": pa.array(['{"height":12}', None, ""]),
        "kind": pa.array([None, "rather", ""]).dictionary_encode(),
        "other": pa.array(["", OTHER, None]),
    }
    pq.write_table(pa.table(columns), tmp_path / "a.parquet")
    assert read_labels(tmp_path / "a.parquet") == EXPECTED


def test_rows_without_a_score_are_left_out_and_counted(tmp_path):
    path = tmp_path / "a.csv"
    blank = "".join(f"1,{model},a,{cell},{HASH}\n" for model, cell in enumerate(("", " ", "NaN", "n/a", "null", "NA")))
    path.write_text(f"seed,model,factor,score,grammar\n{blank}1,9,a,70,{HASH}\n")
    labels = read_labels(path)
    assert labels.scores.tolist() == [70.0]
    assert labels.notes == ("6 rows without a score are left out",)
    path.write_text(f"seed,model,factor,score,grammar\n1,1,a,,{HASH}\n1,9,a,70,{HASH}\n")
    assert read_labels(path).notes == ("1 row without a score is left out",)
    path.write_text(f"seed,model,factor,score,grammar\n{blank}")
    with pytest.raises(AssetError, match=r"a.csv: none of 6 rows has a score"):
        read_labels(path)


def test_blank_scores_of_other_formats_are_left_out(tmp_path):
    row = {"seed": 1, "model": 2, "factor": "a", "score": 50.0, "grammar": HASH}
    rows = [row, row | {"score": None}, row | {"score": float("nan")}]
    (tmp_path / "a.jsonl").write_text("\n".join(map(json.dumps, rows)))
    pq.write_table(pa.Table.from_pylist(rows), tmp_path / "a.parquet")
    for name in ("a.jsonl", "a.parquet"):
        labels = read_labels(tmp_path / name)
        assert (len(labels), labels.notes) == (1, ("2 rows without a score are left out",))


def test_a_row_that_ends_early_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(COMMAS[: COMMAS.rindex("80")], encoding="utf-8")
    with pytest.raises(AssetError, match="line 4: expected 10 cells as in the header, found 4"):
        read_labels(path)


def scored(*scores: float, kind: Kind = "score") -> list[Label]:
    return [Label(1, model, "a", value, HASH, kind=kind) for model, value in enumerate(scores)]


@pytest.mark.parametrize(
    ("scores", "points", "note"),
    [
        ((0.0, 0.25, 1.0), [0.0, 25.0, 100.0], "fractions of 100: 0.25 as 25"),
        ((0.07, 0.5), [7.0, 50.0], "fractions of 100: 0.07 as 7"),
        ((0.0, 1.0, 1.0), [0.0, 100.0, 100.0], r"all scores are 0 or 1 and are read as 0 \(disliked\) and 100"),
        ((0.0, 3.0, 5.0), [0.0, 3.0, 5.0], "the highest score is 5, on a scale of 0 .*kind 'stars'"),
        ((1.0, 10.0), [1.0, 10.0], "the highest score is 10"),
    ],
)
def test_other_scales_are_understood_or_named(scores, points, note):
    labels, notes = on_one_scale(scored(*scores))
    assert [label.score for label in labels] == points
    (text,) = notes
    assert re.search(note, text)


@pytest.mark.parametrize("rows", [[], scored(0.0, 0.0), scored(0.0, 11.0), scored(100.0, kind="thumb")])
def test_scores_of_0_to_100_have_no_note(rows):
    assert on_one_scale(rows) == (tuple(rows), ())


def test_a_shorter_scale_of_one_factor_is_named():
    rows = [replace(label, factor=factor) for factor in "bcd" for label in scored(0.0, 0.5, 1.0)]
    rows += [*scored(10.0, 90.0), *(replace(label, factor="e") for label in scored(0.0, 0.0))]
    labels, (note,) = on_one_scale(rows)
    assert labels == tuple(rows)
    assert note.startswith("the highest score is 1 for the factor 'b', 1 for the factor 'c', 1 for the factor 'd', on")
    many = [replace(label, factor=str(number)) for number in range(12) for label in scored(5.0)]
    assert "and 4 more factors, on" in on_one_scale([*rows[-3:], *many])[1][0]


def test_labels_of_other_kinds_have_their_own_scale():
    rows = [*scored(0.5, 1.0), *scored(0.0, 25.0, kind="stars")]
    labels, _ = on_one_scale(rows)
    assert [label.score for label in labels] == [50.0, 100.0, 0.0, 25.0]


def test_notes_of_labels_are_kept_when_they_are_joined():
    assert (Labels((), ("a",)) + Labels((), ("b",))).notes == ("a", "b")
    assert Labels((), ("a",)) == Labels()


@pytest.mark.parametrize("text", ["12", "12.0", "12,00", "12.000000", " 12 ", 12.0, 12, Decimal(12)])
def test_a_whole_number_has_several_forms(text):
    assert integer("model", text) == 12
    assert type(integer("model", text)) is int


@pytest.mark.parametrize(
    "text",
    ["1_000", "1 000", " 1_0", "١٢", "１２", "0x1F", "1e3x", "12.5", "", "+1", "12.", "--1", True, None, 12.5],
)
def test_what_is_not_a_whole_number_stays_as_it_is(text):
    value = integer("model", text)
    assert not isinstance(value, int) or isinstance(value, bool)


@pytest.mark.parametrize("value", ["1e3", "1.23E+19", "1,23e19", 1.23e19, 2.0**53])
def test_digits_that_a_spreadsheet_has_lost_are_named(value):
    with pytest.raises(UsageError, match=r"seed: .* is rounded: .* as text"):
        integer("seed", value)


def test_a_thousand_or_one_is_not_guessed():
    with pytest.raises(UsageError, match=r"model: 1.000 may be 1 or a thousand times as much"):
        integer("model", "1.000")


def test_scores_are_numbers_or_blank():
    assert [score(value) for value in ("12.5", "", None, "NaN", 3, "1_0", "12,5")] == [
        12.5, None, None, None, 3, "1_0", "12,5",
    ]  # fmt: skip
