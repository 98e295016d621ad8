import json
from dataclasses import replace

import pytest

from grammarlab.evaluation.curves import Curve, Point
from grammarlab.runs.evaluate.curve_store import STORE, CurveRecord, curves_in, measurements_in

A, B = "a" * 64, "b" * 64
"""Keys of curves: SHA-256 of their inputs, in hexadecimal."""


def record(key=A, max_labels=32, js=0.1 + 0.2):
    return CurveRecord(
        key, "F1", "default", 3, max_labels, 0.3, Curve((Point(16, js, 0.5, 0), Point(32, 1e-300, 1.0, 7)))
    )


def test_curves_are_read_back_to_the_last_bit_and_told_apart_by_what_they_were_made_for(tmp_path):
    curves = curves_in(tmp_path)
    records = [record(A), record(B, js=1 / 3), record(A, 64), replace(record(A, 48), person="sd10")]
    for each in records:
        curves.put(each.curve_name, each)
    assert curves_in(tmp_path).all() == {each.curve_name: each for each in records}
    assert curves_in(tmp_path, fresh=True).all() == {}


@pytest.mark.parametrize(("old", "new"), [("0.3", "NaN"), ("32", "1e999"), ('"key"', '"kex"'), ("0.3", '"x"')])
def test_damaged_curves_are_left_out(tmp_path, old, new):
    curves = curves_in(tmp_path)
    for each in (record(A), record(B)):
        curves.put(each.curve_name, each)
    file = tmp_path / STORE / f"{A}-32.json"
    file.write_text(file.read_text().replace(old, new))
    assert list(curves.all()) == [f"{B}-32"]


EARLIER = (
    f'{{"key": "{A}", "scenario": "F1", "method": "paper", "seed": 0, "max_labels": 32, '
    '"js_original": 0.3, "curve": [[32, 0.1, 1, 4]]}\n'
)


def test_curves_of_an_earlier_version_are_taken_in_unless_they_are_to_be_forgotten(tmp_path):
    (tmp_path / "curves.jsonl").write_text(EARLIER + EARLIER.replace("32", "64") + EARLIER[:50])
    found = curves_in(tmp_path).all()
    assert [(each.key, each.method, each.max_labels, each.person) for each in found.values()] == [
        (A, "paper", n, "exact") for n in (32, 64)
    ]
    assert curves_in(tmp_path, fresh=True).all() == {}
    assert curves_in(tmp_path).all() == {}


def test_measurements_of_an_earlier_version_are_taken_in(tmp_path):
    (tmp_path / "samples.jsonl").write_text(json.dumps({"key": f"{A}-32", "values": {"js": 0.5}}) + "\n")
    assert measurements_in(tmp_path, "samples").all() == {f"{A}-32": {"js": 0.5}}
    assert measurements_in(tmp_path, "samples", fresh=True).all() == {}
