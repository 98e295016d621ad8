import csv
import json
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.errors import AssetError, UsageError
from grammarlab.preference import label_files
from grammarlab.preference.label_files import read_labels, save_labels
from grammarlab.preference.labels import Label, Labels
from tests.preference.labelling import label_models

HASH = "0123456789abcdef" * 4
OTHER = '{"seed":5,"model":17}'
FORMATS = (".csv", ".jsonl", ".parquet")
TEXT = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), max_size=12).map(str.strip)
"""Blanks around cells of tables are not kept."""

KINDS = st.one_of(
    st.tuples(st.just("score"), st.floats(0.0, 100.0), st.just("")),
    st.tuples(st.just("stars"), st.sampled_from([0.0, 25.0, 50.0, 75.0, 100.0]), st.just("")),
    st.tuples(st.just("thumb"), st.sampled_from([0.0, 100.0]), st.just("")),
    st.tuples(st.just("rather"), st.just(100.0), st.just(OTHER)),
    st.tuples(st.just("tie"), st.just(50.0), st.just(OTHER)),
)
PLAIN = st.builds(
    Label,
    seed=st.integers(0, 2**64 - 1),
    model=st.integers(0, 2**64 - 1),
    factor=TEXT.filter(bool),
    score=st.just(1.0),
    grammar=st.just(HASH),
    start_rule=TEXT,
    attributes=st.sampled_from(["{}", '{"height":12}', '{"name":"a, \\"b\\"","old":true}']),
    footprint=st.sampled_from(["", "20x12"]),
)
LABEL = st.builds(
    lambda label, kind: replace(label, kind=kind[0], score=kind[1], other=kind[2]),
    PLAIN.filter(lambda label: (label.seed, label.model) != (5, 17)),
    KINDS,
)


@pytest.mark.parametrize("suffix", FORMATS)
@given(rows=st.lists(LABEL, max_size=6))
def test_a_file_gives_back_what_was_written(tmp_path_factory, suffix, rows):
    path = tmp_path_factory.getbasetemp() / f"labels{suffix}"
    # Scores that are all at most 1 are taken for fractions, even in our own files.
    labels = Labels((*rows, Label(7, 7, "overall", 80.0, HASH)))
    save_labels(labels, path)
    assert read_labels(path) == labels
    assert [entry.name for entry in path.parent.iterdir() if entry.name.startswith(".part")] == []


def test_files_with_the_needed_columns_alone_are_read(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(
        f"\ufeffscore,seed,model,factor,grammar,remark\r\n7.5,1,2,roof,{HASH},nice\r\n\r\n", encoding="utf-8"
    )
    assert read_labels(path) == Labels((Label(1, 2, "roof", 7.5, HASH),))


def test_hand_written_comparisons_need_no_score(tmp_path):
    path = tmp_path / "a.csv"
    head = f"seed,model,factor,score,grammar,kind,other\n1,2,roof,75,{HASH},stars,\n3,4,roof,9,{HASH},,\n"
    other = OTHER.replace('"', '""')
    path.write_text(f'{head}1,2,roof,,{HASH},rather,"{other}"\n1,2,roof,,{HASH},tie,"{other}"\n')
    expected = (
        Label(1, 2, "roof", 75.0, HASH, kind="stars"),
        Label(3, 4, "roof", 9.0, HASH),
        Label(1, 2, "roof", 100.0, HASH, kind="rather", other=OTHER),
        Label(1, 2, "roof", 50.0, HASH, kind="tie", other=OTHER),
    )
    assert read_labels(path) == Labels(expected)


def test_the_other_model_differs_in_what_is_said_of_it_alone():
    own = Label(1, 2, "a", 50.0, HASH, "Lot", '{"b":1}', "20x12", kind="tie", other=OTHER)
    assert own.other_address == (HASH, "Lot", '{"b":1}', "20x12", 5, 17)
    said = f'{{"seed":5,"model":17,"grammar":"{"f" * 64}","start_rule":"","attributes":"{{}}","footprint":"9x9"}}'
    assert replace(own, other=said).other_address == ("f" * 64, "", "{}", "9x9", 5, 17)
    assert Label(1, 2, "a", 50.0, HASH).other_address is None


def test_labels_of_equal_address_are_about_the_same_model():
    first, second = (Label(1, 2, "a", score, HASH, attributes='{"b":1}') for score in (3.0, 4.0))
    assert first.address == second.address
    assert first.address != Label(1, 2, "a", 3.0, HASH).address


def test_factors_and_their_scores_are_taken_apart_in_order():
    labels = label_models(HASH, 5, [3, 1], [10.0, 20.0], "roof") + label_models(HASH, 5, [3], [0.0], "door")
    assert labels.factors == ("roof", "door")
    np.testing.assert_array_equal(labels.of("roof").scores, [10.0, 20.0])
    assert [label.model for label in labels.of("door")] == [3]


def test_contradicting_scores_are_both_kept(tmp_path):
    labels = label_models(HASH, 5, [3, 3], [10.0, 90.0])
    save_labels(labels, tmp_path / "a.csv")
    np.testing.assert_array_equal(read_labels(tmp_path / "a.csv").scores, [10.0, 90.0])


GOOD = {"seed": 1, "model": 2, "factor": "a", "score": 3, "grammar": HASH, "attributes": "{}", "kind": "", "other": ""}
RATHER = {"kind": "rather", "score": 100}
BAD_CELLS = [
    ({"score": "good"}, "score: expected a number from 0 to 100, found 'good'"),
    ({"score": "1_0"}, "score: expected a number from 0 to 100, found '1_0'"),
    ({"score": 101}, "score: .* found 101"),
    ({"score": -0.5}, "score: "),
    ({"score": "", "other": OTHER}, "score: .* Leave models out"),
    ({"score": 1e999}, "score: .* found '?inf"),
    ({"seed": -1}, r"seed: expected an integer 0 <= seed < 2\*\*64, found -1"),
    ({"seed": 2**64}, "seed: "),
    ({"seed": 10**4000}, "seed: .* found an integer of 13288 bits"),
    ({"seed": "9" * 5000}, "seed: "),
    ({"model": 1.5}, "model: "),
    *(
        ({"model": text}, f"model: expected an integer .* found '{text}'")
        for text in ("1_000", "1e3x", "0x1F", "١٧", "")
    ),
    *(({"seed": text}, "seed: .* is rounded: .* as text") for text in ("1.23E+19", "1,23E+19", 1.23e19)),
    ({"model": "1.000"}, "model: 1.000 may be 1 or a thousand times as much"),
    ({"model": 2**64}, "model: "),
    ({"factor": ""}, "factor: expected a name"),
    ({"factor": "two\nlines"}, "factor: expected one line"),
    ({"factor": "x" * 5000}, "factor: 5000 characters; 4096 are allowed"),
    ({"grammar": "abc"}, "grammar: expected a SHA-256"),
    ({"attributes": "[1]"}, "attributes: expected a JSON object"),
    ({"attributes": '{"a": [1]}'}, "attributes: "),
    ({"attributes": '{"a": ' * 600}, "attributes: "),
    ({"kind": "likes"}, "kind: expected one of score, stars, thumb, rather, tie, found 'likes'"),
    ({"kind": "stars"}, "score: expected 0 or 25 or 50 or 75 or 100 for the kind stars, found 3"),
    ({"kind": "thumb", "score": 50}, "score: expected 0 or 100 for the kind thumb, found 50"),
    ({"kind": "tie", "score": 100, "other": OTHER}, "score: expected 50 for the kind tie"),
    ({"other": OTHER}, "other: expected nothing for the kind score"),
    (RATHER, "other: expected the model to compare with"),
    (RATHER | {"other": "5-17"}, "other: expected a JSON object of seed and model like"),
    (RATHER | {"other": '{"seed":5}'}, "other: expected a JSON object of seed and model"),
    (RATHER | {"other": '{"seed":5,"model":17,"score":3}'}, "other: expected a JSON object of seed and model"),
    (RATHER | {"other": '{"seed":-5,"model":17}'}, "other: seed: expected an integer"),
    (RATHER | {"other": '{"seed":5,"model":1.5}'}, "other: model: expected an integer"),
    (RATHER | {"other": '{"seed":5,"model":1,"grammar":"abc"}'}, "other: grammar: expected a SHA-256"),
    (RATHER | {"other": '{"seed":5,"model":1,"attributes":"[1]"}'}, "attributes: expected a JSON object"),
    (RATHER | {"other": '{"seed":5,"model":1,"footprint":7}'}, "other: footprint: expected text"),
    (RATHER | {"other": '{"seed":1,"model":2}'}, "other: expected another model"),
]


@pytest.mark.parametrize(("change", "message"), BAD_CELLS)
@pytest.mark.parametrize("suffix", [".csv", ".jsonl"])
def test_a_bad_cell_is_named_with_line_and_column(tmp_path, suffix, change, message):
    path = tmp_path / f"a{suffix}"
    rows = [GOOD, GOOD | change]
    if suffix == ".jsonl":
        path.write_text("".join(f"{json.dumps(row)}\n" for row in rows))
    else:
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, GOOD)
            writer.writeheader()
            writer.writerows(rows)
    with pytest.raises(AssetError, match=rf"a{suffix}: line \d: .*{message}"):
        read_labels(path)


@pytest.mark.parametrize("change", [{"seed": True}, {"score": True}, {"factor": 3}, {"model": [2]}, {"model": None}])
def test_values_of_another_kind_are_refused(tmp_path, change):
    path = tmp_path / "a.jsonl"
    path.write_text(json.dumps(GOOD | change))
    with pytest.raises(AssetError, match=f"a.jsonl: line 1: {next(iter(change))}: expected"):
        read_labels(path)


@pytest.mark.parametrize(
    ("suffix", "text", "message"),
    [
        (".csv", "", "missing seed, model, factor, score, grammar; found none"),
        (".csv", "seed,model\n", "missing factor, score, grammar; found seed, model"),
        (".csv", "seed,seed,model,factor,score,grammar\n", "same name"),
        (".csv", "seed,model,factor,score,grammar\n1,2,a\n", "line 2: expected 5 cells as in the header, found 3"),
        (".csv", 'seed,model,factor,score,grammar\n1,2,"a\n', "end of data"),
        (".csv", f"seed,model,factor,score,grammar\n1,2,{'a' * 200_000},3,{HASH}\n", "field limit"),
        (".jsonl", "[1, 2]\n", "line 1: expected one JSON object"),
        (".jsonl", "[" * 100_000, "line 1: expected a JSON object"),
        (".jsonl", '{"seed": 1}', "line 1: .* missing model, factor"),
        (".jsonl", '{"seed": ' + "1" * 10_000 + "}", "line 1: "),
        (".parquet", "PAR1 but no more", "a.parquet: "),
    ],
)
def test_broken_files_are_refused_with_the_place(tmp_path, suffix, text, message):
    path = tmp_path / f"a{suffix}"
    path.write_text(text)
    with pytest.raises(AssetError, match=message):
        read_labels(path)


@pytest.mark.parametrize("suffix", [".csv", ".jsonl"])
def test_what_is_not_text_is_refused(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"seed,model,factor,score,grammar\n1,2,\x00,3,x\n")
    with pytest.raises(AssetError, match=rf"a{suffix}: expected text, found bytes of zero"):
        read_labels(path)


def test_parquet_columns_of_other_types_are_refused_by_cell(tmp_path):
    path = tmp_path / "a.parquet"
    columns = {"seed": [1, None], "model": [1, 2], "factor": ["a", "b"], "score": [1.0, 2.0], "grammar": [HASH] * 2}
    pq.write_table(pa.table(columns), path)
    with pytest.raises(AssetError, match="row 2: seed: expected an integer"):
        read_labels(path)


def test_size_is_bounded(tmp_path, monkeypatch):
    labels = label_models(HASH, 1, range(5), [50.0] * 5)
    for suffix in FORMATS:
        save_labels(labels, tmp_path / f"a{suffix}")
    monkeypatch.setattr(label_files, "MAX_LABELS", 4)
    for suffix in FORMATS:
        with pytest.raises(AssetError, match="more than 4 labels"):
            read_labels(tmp_path / f"a{suffix}")
    monkeypatch.setattr(label_files, "MAX_UNPACKED_BYTES", 10)
    with pytest.raises(AssetError, match="when unpacked"):
        read_labels(tmp_path / "a.parquet")
    monkeypatch.setattr(label_files, "MAX_FILE_BYTES", 10)
    with pytest.raises(AssetError, match="at most 10 bytes"):
        read_labels(tmp_path / "a.csv")


def test_files_that_are_missing_or_of_another_kind_are_refused(tmp_path):
    with pytest.raises(AssetError, match="no such label file"):
        read_labels(tmp_path / "a.csv")
    with pytest.raises(UsageError, match=r"ends in \.csv, \.tsv, \.txt, \.jsonl, \.parquet"):
        read_labels(tmp_path / "a.xlsx")
    with pytest.raises(UsageError, match=r"ends in \.csv"):
        save_labels(Labels(), tmp_path / "a.pickle")


def test_labels_made_by_programs_are_checked_too():
    with pytest.raises(UsageError, match="score: expected a number from 0 to 100, found 500"):
        label_models(HASH, 1, [1, 2], [1.0, 500.0])
    with pytest.raises(UsageError, match="grammar: expected"):
        label_models("short", 1, [1], [1.0])
