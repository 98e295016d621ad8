from dataclasses import replace

import pyarrow.parquet as pq
import pytest

from grammarlab.evaluation.curves import Curve, Point
from grammarlab.evaluation.scenario import Target, load
from grammarlab.runs.evaluate.find import shipped_scenarios
from grammarlab.runs.evaluate.plots import FLOOR, Series, draw_curves, quantiles
from grammarlab.runs.evaluate.report import Picture, ScenarioResults, write_page, write_table
from grammarlab.runs.evaluate.store import CurveRecord


def record(seed, *divergences, method="default"):
    points = tuple(Point(16 * (k + 1), js, 1 - js, k) for k, js in enumerate(divergences))
    return CurveRecord(f"{method}{seed}", "B3", method, seed, 64, 0.1, Curve(points))


RECORDS = (
    record(0, 0.05, 0.009, 0.02, 0.001),
    record(1, 0.009, 0.008, 0.0, 0.0),
    record(2, 0.05, 0.04, 0.03, 0.02),
    record(0, 0.05, 0.04, 0.03, 0.02, method="paper"),
)


def test_the_table_holds_every_round_of_every_curve(tmp_path):
    write_table(tmp_path / "results.parquet", RECORDS)
    rows = pq.read_table(tmp_path / "results.parquet").to_pylist()
    assert len(rows) == 16
    expected = {"scenario": "B3", "method": "default", "seed": 0, "labels": 32, "js": 0.009, "correlation": 0.991}
    assert rows[1] == expected | {"liked": 1, "js_original": 0.1}


def test_the_page_has_medians_and_spreads_beside_targets_and_the_paper(tmp_path):
    scenario = replace(load(shipped_scenarios()["B3"]), target=Target(0.01, 32, 16))
    results = ScenarioResults(scenario, RECORDS)
    (tmp_path / "docs").mkdir()
    picture = Picture(tmp_path / "plots" / "a.png", "A | picture", "Paper: something.")
    write_page(tmp_path / "docs" / "page.md", [results], [picture], "grammarlab evaluate x")
    text = (tmp_path / "docs" / "page.md").read_text(encoding="utf-8")
    assert "Written by `grammarlab evaluate x`" in text
    assert f"| B3 | {scenario.title} | 0.100 | 0.099 | +1 % |" in text
    assert (
        "| B3 | default | **32** (16–never; 2/3) | **64** (16–never; 2/3) | 32 | 16 |  | 0.0010 | 0.999 | 64 |" in text
    )
    assert "| B3 | paper | never (0/1) | never (0/1) | 32 | 16 |" in text
    assert "](../plots/a.png)" in text
    lengths = {line.count("|") for line in text.split("## Labels")[1].splitlines() if line.startswith("|")}
    assert len(lengths) == 1


def test_the_line_of_a_picture_is_the_median_of_staircases_and_starts_before_learning():
    labels, (low, median, high) = quantiles(RECORDS[:3])
    assert labels.tolist() == [0, 16, 32, 48, 64]
    assert median.tolist() == [0.1, 0.05, 0.009, 0.02, 0.001]
    assert (low <= median).all()
    assert (median <= high).all()
    assert low[0] == 0.1
    assert quantiles(RECORDS[1:2])[1].min() == FLOOR


def test_equal_curves_give_equal_pictures_in_both_formats(tmp_path):
    series = [Series("default", RECORDS[:3]), Series("paper", RECORDS[3:])]
    one = draw_curves(tmp_path / "a" / "B3", "Title", series)
    two = draw_curves(tmp_path / "b" / "B3", "Title", series)
    assert [path.suffix for path in one] == [".png", ".svg"]
    assert [path.read_bytes() for path in one] == [path.read_bytes() for path in two]
    assert "<svg" in one[1].read_text(encoding="utf-8")
    assert one[0].read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", ["4.7a", "figure.with.dots"])
def test_dots_in_the_name_of_a_picture_are_not_taken_for_a_suffix(tmp_path, name):
    png, svg = draw_curves(tmp_path / name, "Title", [Series("default", RECORDS[:1])])
    assert (png.name, svg.name) == (f"{name}.png", f"{name}.svg")
