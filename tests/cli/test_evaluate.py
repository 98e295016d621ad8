"""``grammarlab evaluate``."""

import json
import re

import pyarrow.parquet as pq
import pytest
from PIL import Image

from grammarlab.cli.evaluate import PERSONS_HELP
from grammarlab.evaluation.respondents import RESPONDENTS
from grammarlab.runs.evaluate import plots as grid_pictures
from grammarlab.runs.evaluate.curve_store import STORE
from tests.cases import takes_turns

SCENARIO = """
name = "tiny"
title = "Boxes rather than cylinders"
grammar = "small.cga"
num_models = 200

[[preference]]
score = 100
when = "{Block:0} == 2"

[[preference]]
score = 40
when = "{Block:0} == 1"

[paper]
original = 0.2
"""
RULES = """
Lot --> extrude(6) split(y) { ~1 : Block | ~1 : Block }
Block --> 40% : i("builtin:cube") Paint  else : i("builtin:cylinder") Paint
Paint --> 50% : color("#bb8866") Brick.  else : color("#8899aa") Glass.
"""
FIGURES = """
[[figures]]
name = "mine"
title = "Grids"
scenario = "tiny"
max_labels = 24
curves = [{ label = "2x2", method = "kde", batch = 8 }, { label = "4x4", method = "kde", batch = 16 }]
"""


@pytest.fixture
def folder(tmp_path):
    """A folder with one scenario, its grammar and an experiment."""
    scenarios = tmp_path / "scenarios"
    (scenarios / "figures").mkdir(parents=True)
    (scenarios / "tiny.toml").write_text(SCENARIO)
    (scenarios / "small.cga").write_text(RULES)
    (scenarios / "figures" / "mine.toml").write_text(FIGURES)
    return scenarios


@pytest.fixture
def evaluate(run, folder, tmp_path):
    """Runs the command on the folder's scenario with few labels; further arguments are its options."""

    def call(*options, scenario="tiny.toml", code=0):
        few = ["--seeds", "2", "--max-labels", "32", "--methods", "kde", "--workers", "1"]
        path = folder / scenario if scenario else folder
        return run("evaluate", path, *few, "-o", tmp_path / "out", *options, code=code)

    return call


def test_the_help_names_every_person():
    assert f"How models are scored: {', '.join(RESPONDENTS)}." == PERSONS_HELP


def test_json_is_one_object_about_the_scenario(evaluate):
    values = json.loads(evaluate("--json").stdout)
    assert values["scenario"] == "tiny"
    assert values["person"] == "exact"
    assert 0.05 < values["js_original"] < 0.4
    originals = [curve["js_original"] for curve in values["curves"]]
    assert min(originals) < values["js_original"] < max(originals)
    assert [(curve["method"], curve["seed"]) for curve in values["curves"]] == [("kde", 0), ("kde", 1)]
    for curve in values["curves"]:
        assert [labels for labels, _ in curve["curve"]] == [32]
        assert all(0 <= js <= 0.7 for _, js in curve["curve"])
        close = [labels for labels, js in curve["curve"] if js <= 0.01]
        assert curve["labels_to_0.01"] == (close[0] if close else None)
        assert curve["labels_before_first_liked"] == 0
        for name in ("labels_to_0.01", "labels_until_below_0.01"):
            assert curve[f"{name}_since_first_liked"] == curve[name]


FEW = ("--max-labels", "16", "--batch", "8")


@takes_turns
def test_the_same_command_says_the_same_with_any_number_of_workers(evaluate, tmp_path):
    options = (*FEW, "--json", "--person", "exact,blunders10")
    one = evaluate(*options, "-o", tmp_path / "one").stdout
    two = evaluate(*options, "-o", tmp_path / "two", "--workers", "2").stdout
    assert one == two
    for item in json.loads(one)["scenarios"]:
        assert [labels for labels, _ in item["curves"][0]["curve"]] == [8, 16]


def test_persons_who_err_have_curves_of_their_own(evaluate, tmp_path):
    exact, noisy = (json.loads(evaluate(*FEW, "--json", "--person", name).stdout) for name in ("exact", "blunders10"))
    assert (exact["person"], noisy["person"]) == ("exact", "blunders10")
    assert exact.keys() == noisy.keys()
    assert exact["js_original"] == noisy["js_original"]
    both = evaluate(*FEW, "--json", "--person", "exact,blunders10").stdout
    assert json.loads(both)["scenarios"] == [exact, noisy]
    sd20 = json.loads(evaluate(*FEW, "--json", "--person", "sd20").stdout)
    assert [curve["curve"] for curve in sd20["curves"]] != [curve["curve"] for curve in exact["curves"]]
    assert {path.name for path in (tmp_path / "out" / "plots").glob("*.png")} == {
        *("needed.png", "tiny.png", "tiny.blunders10.png", "tiny.sd20.png")
    }
    page = (tmp_path / "out" / "results.md").read_text(encoding="utf-8")
    assert "--person sd20 --seeds 2" in page
    assert "| sd20 | kde | tiny |" in page


def test_stars_are_measured_against_what_they_mean(evaluate):
    exact, stars = (json.loads(evaluate(*FEW, "--json", "--person", name).stdout) for name in ("exact", "stars"))
    # 100 and 40 become 100 and 50.
    assert exact["js_original"] != stars["js_original"]


def test_each_seed_has_models_of_its_own(evaluate):
    curves = json.loads(evaluate(*FEW, "--json").stdout)["curves"]
    assert curves[0]["js_original"] != curves[1]["js_original"]


@takes_turns
def test_grammars_are_made_of_the_scores_of_each_person(evaluate):
    options = (*FEW, "--seeds", "1", "--grammar-labels", "16", "--person", "exact,stars", "--json")
    for item in json.loads(evaluate(*options).stdout)["scenarios"]:
        (grammar,) = item["grammars"]
        assert (grammar["person"], grammar["labels"]) == (item["person"], 16)
        assert grammar["js"] < item["js_original"]


def test_a_run_leaves_tables_and_pictures_and_a_report_elsewhere(evaluate, tmp_path, monkeypatch):
    monkeypatch.setattr(grid_pictures, "SIZES", {1: 20_000, 2: 10_000})
    result = evaluate("--figures", "all", "--grids", "--report", tmp_path / "docs" / "results.md", scenario="")
    assert result.stdout == ""
    assert "tiny kde: JS" in result.stderr
    out = tmp_path / "out"
    plots = {path.name for path in (out / "plots").iterdir()}
    assert plots == {f"{name}.{kind}" for name in ("needed", "tiny", "figure-mine") for kind in ("png", "svg")}
    grids = {path.name for path in (out / "grids").iterdir()}
    samples = {f"tiny-{stage}-{size}.jpg" for stage in ("before", "after") for size in ("1x1", "2x2")}
    assert grids == {"tiny-scores.jpg", *samples}
    rows = pq.read_table(out / "results.parquet").to_pylist()
    assert {row["method"] for row in rows} == {"kde", "2x2", "4x4"}
    page = (tmp_path / "docs" / "results.md").read_text(encoding="utf-8")
    assert "| tiny | Boxes rather than cylinders |" in page
    for picture in ("tiny.png", "figure-mine.png", "tiny-scores.jpg", "tiny-after-1x1.jpg", "tiny-before-2x2.jpg"):
        assert f"](results/{picture})" in page
        with Image.open(tmp_path / "docs" / "results" / picture) as opened:
            assert opened.width > 100
    for text in (page, (out / "results.md").read_text(encoding="utf-8")):
        assert "| samples before learning | samples after 32 labels (kde, seed 0) |" in text
        assert re.search(r"(?<!!)\[2x2 samples after\]\(\w+/tiny-after-2x2.jpg\)", text)


def test_samples_before_and_after_have_one_shape(evaluate, tmp_path, monkeypatch):
    monkeypatch.setattr(grid_pictures, "SIZES", {2: 10_000})
    evaluate("--grids")
    sizes = []
    for stage in ("before", "after"):
        with Image.open(tmp_path / "out" / "grids" / f"tiny-{stage}-2x2.jpg") as opened:
            sizes.append(opened.size)
    assert sizes[0] == sizes[1]


def test_a_target_may_count_from_the_first_liked_model(evaluate, folder, tmp_path):
    rare = SCENARIO.replace("[paper]", '[target]\njs = 0.7\nlabels = 8\nsince = "first liked"\nask = 24\n[paper]')
    (folder / "tiny.toml").write_text(rare.replace("{Block:0} == 1", "{Block:0} == 5"))
    options = ("--batch", "8", "--max-labels", "0")
    assert "at most 0.7 after 8 to 8 labels from the first liked model on (2 of 2 seeds)" in evaluate(*options).stderr
    page = (tmp_path / "out" / "results.md").read_text(encoding="utf-8")
    assert "| tiny | exact | kde | **8** (8–8; 2/2) | **8** (8–8; 2/2) | 8 from the first liked model on |" in page
    assert "Before that round, **0** (0–0; 2/2) labels had been given." in page
    assert "labels from the first liked model on" in (tmp_path / "out" / "plots" / "tiny.svg").read_text()
    curves = json.loads(evaluate(*options, "--json").stdout)["curves"]
    assert {curve["curve"][-1][0] for curve in curves} == {24}


@takes_turns
def test_a_second_run_goes_on_from_the_first_unless_it_is_to_begin_anew(evaluate, tmp_path):
    first = evaluate("--json").stdout
    store = tmp_path / "out" / STORE
    kept = {file: file.read_bytes() for file in store.iterdir()}
    times = [file.stat().st_mtime_ns for file in kept]
    assert len(kept) == 2
    assert evaluate("--json").stdout == first
    assert [file.stat().st_mtime_ns for file in kept] == times
    for damage in (b"", b"not ours", b"{}", kept[next(iter(kept))][:40]):
        next(iter(kept)).write_bytes(damage)
        assert evaluate("--json").stdout == first
        assert {file: file.read_bytes() for file in store.iterdir()} == kept
    assert evaluate("--json", "--fresh").stdout == first
    assert [file.stat().st_mtime_ns for file in kept] > times


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["--methods", "defualt"], 2, "Did you mean 'default'?"),
        (["--methods", "kde,kde"], 2, "given twice"),
        (["--methods", ","], 2, "which methods"),
        (["--person", "sd7"], 2, "unknown person 'sd7'. Did you mean"),
        (["--person", "sd5,sd5"], 2, "person 'sd5' is given twice"),
        (["--person", ""], 2, "which persons"),
        (["--seeds", "0"], 2, "--seeds"),
        (["--seeds", "three"], 2, "--seeds"),
        (["--max-labels", "-1"], 2, "--max-labels"),
        (["--batch", "5000"], 2, "batch is a number from 1 to 1024"),
        (["--figures", "4.7a"], 2, "unknown figure"),
    ],
)
def test_bad_options_end_in_one_message(evaluate, options, code, message):
    assert message in evaluate(*options, code=code).stderr


@pytest.mark.parametrize(
    ("name", "message"),
    [("nothing.toml", "no scenario file"), ("small.cga", "small.cga"), ("figures/mine.toml", "mine.toml")],
)
def test_what_is_no_scenario_is_refused(evaluate, name, message):
    assert message in evaluate(scenario=name, code=2).stderr


def test_without_methods_each_scenario_has_its_own(evaluate, folder):
    (folder / "tiny.toml").write_text('methods = ["kde", "nothing"]' + SCENARIO)
    assert "unknown method 'nothing'" in evaluate("--methods", "", code=2).stderr
    (folder / "tiny.toml").write_text('methods = ["kde"]' + SCENARIO)
    values = json.loads(evaluate("--methods", "", "--json").stdout)
    assert {curve["method"] for curve in values["curves"]} == {"kde"}


def test_two_scenarios_of_one_name_are_refused(evaluate, folder):
    (folder / "other.toml").write_text(SCENARIO)
    assert "both have the name 'tiny'" in evaluate(scenario="", code=2).stderr


def test_a_folder_of_scenarios_is_one_object_too(evaluate, folder):
    (folder / "other.toml").write_text(SCENARIO.replace('"tiny"', '"other"'))
    values = json.loads(evaluate("--json", scenario="").stdout)
    assert [item["scenario"] for item in values["scenarios"]] == ["other", "tiny"]


def test_a_preference_that_nothing_meets_is_refused_with_advice(evaluate, folder):
    (folder / "tiny.toml").write_text(SCENARIO.replace("== 2", "== 7").replace("== 1", "== 8"))
    assert "Raise num_models" in evaluate(code=2).stderr


def test_a_missing_grammar_is_an_error_about_the_grammar(evaluate, folder):
    (folder / "small.cga").unlink()
    assert "small.cga" in evaluate(code=2).stderr


def test_an_unwritable_folder_is_an_error(evaluate, tmp_path):
    (tmp_path / "file").write_text("in the way")
    assert str(tmp_path / "file") in evaluate("-o", tmp_path / "file" / "out", code=1).stderr
