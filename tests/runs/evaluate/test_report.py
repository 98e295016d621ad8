from bisect import bisect_right
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from grammarlab.evaluation.curves import Curve, Point
from grammarlab.evaluation.respondents import RESPONDENTS
from grammarlab.evaluation.scenario import ScenarioGoal, load
from grammarlab.runs.evaluate.curve_store import CurveRecord
from grammarlab.runs.evaluate.pictures import ReportPicture, Section, draw_answer, draw_results
from grammarlab.runs.evaluate.plots import (
    FLOOR,
    ScenarioResults,
    Series,
    draw_curves,
    learned_shares,
    needed_labels,
    quantiles,
)
from grammarlab.runs.evaluate.report import CHECKPOINTS, TARGETS, write_page, write_table
from grammarlab.runs.evaluate.request import shipped_scenarios


def record(seed, *divergences, method="default"):
    points = tuple(Point(16 * (k + 1), js, 1 - js, k) for k, js in enumerate(divergences))
    return CurveRecord(f"{method}{seed}", "B3", method, seed, 64, 0.1, Curve(points))


def results_of(scenario, records, folder="once"):
    return ScenarioResults(scenario, records, Path("anywhere", folder, f"{scenario.name}.toml"))


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
    expected |= {"person": "exact"}
    assert rows[1] == expected | {"liked": 1, "js_original": 0.1}


def test_the_page_has_medians_and_spreads_beside_targets_and_the_paper(tmp_path):
    scenario = replace(load(shipped_scenarios()["B3"]), target=ScenarioGoal(0.01, 32, 16))
    results = results_of(scenario, RECORDS)
    (tmp_path / "docs").mkdir()
    picture = Section("Plot", ((ReportPicture(tmp_path / "plots" / "a.png", "A picture"),),), "Paper: something.")
    write_page(tmp_path / "docs" / "page.md", [results], [picture], "grammarlab evaluate x")
    text = (tmp_path / "docs" / "page.md").read_text(encoding="utf-8")
    assert "Written by `grammarlab evaluate x`" in text
    assert f"| B3 | {scenario.title} | 0.100 | 0.099 | +1 % |" in text
    labels = "**32** (16–never; 2/3) | **64** (16–never; 2/3) | 32 | 16 |  | 0.0010 | 0.999 | 64 |"
    assert f"| B3 | exact | default | {labels}" in text
    assert "| B3 | exact | paper | never (0/1) | never (0/1) | 32 | 16 |" in text
    assert text.endswith("## Plot\n\n![A picture](../plots/a.png)\n\nPaper: something.\n")
    lengths = {line.count("|") for line in text.split("## Labels")[1].splitlines() if line.startswith("|")}
    assert len(lengths) == 1


def test_the_page_opens_with_a_chart_and_says_how_many_scores_are_needed(tmp_path):
    scenario = load(shipped_scenarios()["B3"])
    noisy = tuple(replace(each, person="sd10") for each in RECORDS[1:3])
    results = [results_of(scenario, RECORDS[:3]), results_of(scenario, noisy)]
    section = draw_answer(results, tmp_path / "plots")
    write_page(tmp_path / "page.md", results, [], "x", answer=section)
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert (tmp_path / "plots" / "needed.png").is_file()
    opening = text[: text.index("Written by")]
    assert [line for line in opening.splitlines() if line][1:3] == [
        "## How many scores do I need?",
        "![Learned runs by the number of scores](plots/needed.png)",
    ]
    # The first run reaches the limit after 32 scores, but is above it after 48.
    assert "- `exact`: 64 scores are needed for half of 3 runs; 2 are learned after 64." in opening
    # One of two never is: half of them are not for sure.
    assert "- `sd10`: more than 64 scores are needed for half of 2 runs; 1 is learned after 64." in opening
    both = draw_answer([results_of(scenario, RECORDS)], tmp_path / "plots").remark
    assert "- `exact, paper`: more than 64 scores are needed for its only run; none are learned after 64." in both


def random_results(seed):
    """Scenarios with limits and starts of their own, and curves of any length that cross them in both directions."""
    rng, scenario = np.random.default_rng(seed), load(shipped_scenarios()["B3"])
    for k in range(3):
        goal = ScenarioGoal(0.005 * (k + 1), since="first liked" if rng.random() < 0.5 else "start")
        records = [record(n, *rng.choice([0.001, 0.007, 0.012, 0.05], rng.integers(1, 9))) for n in range(2)]
        yield results_of(replace(scenario, name=f"s{k}", target=goal), tuple(records))


def is_learned(curve, js, labels):
    """Whether a curve is below a limit after a number of labels, and in all its later rounds."""
    num = sum(point.labels <= labels for point in curve.points)
    return num > 0 and all(point.js <= js for point in curve.points[num - 1 :])


@pytest.mark.parametrize("seed", range(8))
def test_the_chart_counts_the_runs_that_are_learned_for_good_by_the_targets_of_their_scenarios(seed):
    results = list(random_results(seed))
    runs = [(curve, item.scenario.target.js) for item in results for curve in item.counted(item.records)]
    (line,) = needed_labels(results).values()
    counts, shares = learned_shares(line)
    for labels in range(counts[-1] + 1):
        share = shares[bisect_right(counts, labels) - 1]
        assert share == pytest.approx(100 * np.mean([is_learned(*run, labels) for run in runs]))
    assert counts[-1] == max(end.labels for curve, _ in runs for end in curve.points)


def test_each_line_ends_with_its_runs_and_says_what_its_scenarios_count(tmp_path):
    scenario = load(shipped_scenarios()["B3"])
    late = replace(scenario, name="late", target=ScenarioGoal(0.03, since="first liked"))
    short = tuple(replace(each, person="sd10") for each in (record(0, 0.02), record(1, 0.02, 0.001)))
    results = [results_of(scenario, RECORDS[:3]), results_of(late, RECORDS[:1]), results_of(scenario, short)]
    lines = needed_labels(results)
    assert {name: learned_shares(line)[0][-1] for name, line in lines.items()} == {"exact": 64, "sd10": 32}
    remark = draw_answer(results, tmp_path).remark
    assert "stays at most its scenario's 0.01 to 0.03 nats from that preference's." in remark
    assert "Scores count from the first liked model on for `late`." in remark
    assert "- `exact`: 40 scores are needed for half of 4 runs; 3 are learned after 48 to 64." in remark
    assert "- `sd10`: more than 16 scores are needed for half of 2 runs; 1 is learned after 16 to 32." in remark


def test_persons_stand_one_below_the_other_each_with_the_worst_scenario_first(tmp_path):
    scenario = load(shipped_scenarios()["B3"])
    better, worse = (replace(scenario, name=name) for name in ("better", "worse"))
    noisy = [
        replace(found, person="sd10", js_original=0.2) for found in (record(0, *[0.1] * 20), record(1, *[0.2] * 20))
    ]
    results = [
        results_of(better, (record(0, *[0.01] * 20), record(1, *[0.03] * 20))),
        results_of(better, tuple(noisy[:1])),
        results_of(worse, (record(0, 0.5, *[0.04] * 19),)),
        results_of(worse, tuple(noisy)),
    ]
    write_page(tmp_path / "page.md", results, [], "x")
    text = (tmp_path / "page.md").read_text(encoding="utf-8").split("## By person")[1].split("## Labels")[0]
    assert [line for line in text.splitlines() if line.startswith("|")] == [
        "| person | method | scenario | original | after 64 | after 128 | after 256 | after 320 | worst seed |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
        "| exact | default | *all* | 0.1000 | 0.0300 | 0.0300 | 0.0300 | 0.0300 | 0.0400 |",
        "| exact | default | *target* |  | 0.0300 | 0.0050 | 0.0010 |  |  |",
        "| exact | default | worse | 0.1000 | 0.0400 | 0.0400 | 0.0400 | 0.0400 | 0.0400 |",
        "| exact | default | better | 0.1000 | 0.0200 | 0.0200 | 0.0200 | 0.0200 | 0.0300 |",
        "| sd10 | default | *all* | 0.2000 | 0.1000 | 0.1000 | 0.1000 | 0.1000 | 0.2000 |",
        "| sd10 | default | *target* |  | 0.0600 | 0.0200 | 0.0060 |  |  |",
        "| sd10 | default | worse | 0.2000 | 0.1500 | 0.1500 | 0.1500 | 0.1500 | 0.2000 |",
        "| sd10 | default | better | 0.2000 | 0.1000 | 0.1000 | 0.1000 | 0.1000 | 0.1000 |",
    ]
    assert [item.name for item in results] == ["better", "better.sd10", "worse", "worse.sd10"]


def test_scenarios_of_each_folder_have_a_table_and_a_median_of_their_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("tuning/a", "tuning/b", "once/c", "once/not-asked"):
        file = tmp_path / "anywhere" / f"{name}.toml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    scenario = load(shipped_scenarios()["B3"])
    paper = (record(0, *[0.5] * 8, method="paper"),)
    results = [
        results_of(replace(scenario, name=name), (record(0, *[js] * 8), *paper), folder)
        for name, js, folder in (("a", 0.01, "tuning"), ("b", 0.03, "tuning"), ("c", 0.2, "once"))
    ]
    write_page(tmp_path / "page.md", results, [], "x")
    text = (tmp_path / "page.md").read_text(encoding="utf-8").split("## By person")[1].split("## Labels")[0]
    tuning, once = text.split("### Scenarios of `tuning`: 2 of 2\n")[1].split("### Scenarios of `once`: 1 of 2\n")
    assert "| exact | default | *all* | 0.1000 | 0.0200 | 0.0200 | 0.0300 |" in tuning
    assert [line.split(" | ")[1:4] for line in once.splitlines() if line.startswith("| exact")] == [
        ["default", "c", "0.1000"],
        ["paper", "c", "0.1000"],
    ]
    assert tuning.count("*target*") == 1  # of the default only


def test_the_wanted_divergences_are_known_for_every_consistent_person():
    assert RESPONDENTS.keys() - TARGETS.keys() == {"changing", "changing_sd10", "two", "two_sd10"}
    assert TARGETS.keys() < RESPONDENTS.keys()
    assert {len(values) for values in TARGETS.values()} == {len(CHECKPOINTS)}


def test_one_method_has_one_picture_for_all_persons_and_several_have_one_each(tmp_path):
    scenario = load(shipped_scenarios()["B3"])
    exact, noisy = (record(0, 0.05, 0.01), *RECORDS[3:]), (replace(record(0, 0.05), person="sd10"),)
    one = draw_results([results_of(scenario, exact[:1]), results_of(scenario, noisy)], tmp_path / "one")
    assert list(one) == ["B3"]
    text = (tmp_path / "one" / "B3.svg").read_text(encoding="utf-8")
    assert "<!-- exact -->" in text
    assert "<!-- sd10 -->" in text
    more = draw_results([results_of(scenario, exact), results_of(scenario, noisy)], tmp_path / "more")
    assert [section.title for section in more.values()] == [f"{name}: {scenario.title}" for name in ("B3", "B3.sd10")]
    assert {path.stem for path in (tmp_path / "more").iterdir()} == {"B3", "B3.sd10"}


def test_a_row_may_count_from_the_first_liked_model_and_says_so(tmp_path):
    scenario = replace(load(shipped_scenarios()["B3"]), target=ScenarioGoal(0.01, 32, since="first liked"))
    never = replace(RECORDS[0], curve=Curve((Point(16, 0.0, 0.0, 0),)))
    write_page(tmp_path / "page.md", [results_of(scenario, (*RECORDS[:3], never))], [], "x")
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert "| **–** (16–never; 2/4) | **–** (16–never; 2/4) | 32 from the first liked model on |  |" in text
    assert "B3, default: *first* and *stays* count from the first liked model on" in text
    assert "Before that round, **16** (16–never; 3/4) labels had been given.\n" in text


def test_the_line_of_a_picture_is_the_median_of_staircases_and_starts_before_learning():
    labels, (low, median, high) = quantiles(RECORDS[:3])
    assert labels.tolist() == [0, 16, 32, 48, 64]
    assert median.tolist() == [0.1, 0.05, 0.009, 0.02, 0.001]
    assert (low <= median).all()
    assert (median <= high).all()
    assert low[0] == 0.1
    assert quantiles(RECORDS[1:2])[1].min() == FLOOR


def test_a_run_counts_in_a_picture_up_to_its_last_round():
    short = replace(RECORDS[0], curve=RECORDS[0].curve.until(32))
    labels, (_, median, _) = quantiles([short, replace(RECORDS[1], curve=Curve(())), RECORDS[2]])
    assert labels.tolist() == [0, 16, 32, 48, 64]
    assert median.tolist() == pytest.approx([0.1, 0.05, (0.009 + 0.04) / 2, 0.03, 0.02])


def test_a_picture_without_any_round_can_be_drawn(tmp_path):
    png, _ = draw_curves(tmp_path / "a", "Title", [Series("default", (replace(RECORDS[0], curve=Curve(())),))])
    assert png.stat().st_size > 0


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
