"""``grammarlab learn``."""

import json

import pytest

from grammarlab.language.grammar import Grammar

RULES = """version "2023.0"
attr height = rand(3, 9)
@StartRule
Lot --> 40% : extrude(height) Low else : extrude(height) High
Low --> NIL
High --> 70% : color("#ff0000") Wall. else : Wall.
"""
SCENARIO = """name = "Test"
title = "High and red"
grammar = "house.cga"
num_models = 200

[[preference]]
score = 80
when = "{High:0}"
"""


@pytest.fixture
def files(rules, tmp_path):
    path = tmp_path / "test.toml"
    path.write_text(SCENARIO)
    return rules(RULES), path


def test_json_is_one_object_about_the_result(run, files, tmp_path):
    grammar, scenario = files
    out = tmp_path / "new" / "red.cga"
    result = run("learn", grammar, "--scenario", scenario, "--method", "compile", "-o", out, "--json")
    values = json.loads(result.stdout)
    assert set(values) == {"scenario", "method", "js", "correlation", "rules_before", "rules_after", "seconds"}
    assert (values["scenario"], values["method"]) == ("Test", "compile")
    assert (values["rules_before"], values["rules_after"]) == (5, 2)
    assert values["js"] <= 1e-12
    text = out.read_text()
    assert "// Scenario Test: High and red\n// Method compile, base grammar\n" in text
    assert "Lot --> extrude(height) High" in text
    assert Grammar.parse(text).rules.keys() == {("Lot", 0), ("High", 0)}


def test_an_even_base_is_reached_as_well(run, files, tmp_path):
    grammar, scenario = files
    scenario.write_text(SCENARIO.replace("num_models", 'base = "uniform"\nnum_models').replace("{High:0}", "{High}"))
    out = tmp_path / "even.cga"
    values = json.loads(run("learn", grammar, "--scenario", scenario, "-o", out, "--json").stdout)
    assert values["js"] <= 1e-12
    assert "High --> \n" not in out.read_text()
    assert "50% : color" in out.read_text()


def test_a_learned_shipped_grammar_samples_from_where_it_lies(run, tmp_path):
    out = tmp_path / "b3.cga"
    scenario = tmp_path / "one.toml"
    scenario.write_text('name = "One"\ntitle = "L"\ngrammar = "building"\nnum_models = 20\n'
                        '[[preference]]\nscore = 9\nwhen = "{MassL}"\n')  # fmt: skip
    run("learn", "building", "--scenario", scenario, "-o", out)
    run("sample", out, "-n", "1", "--no-image", "-o", tmp_path / "models", "--jobs", "1")
    assert (tmp_path / "models" / "b3-00000.glb").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["--method", "magic"], 2, "no method is called 'magic'"),
        (["--scenario", "missing.toml"], 2, "no scenario file"),
    ],
)
def test_mistakes_are_told(run, files, options, code, message):
    grammar, scenario = files
    result = run("learn", grammar, "--scenario", scenario, *options, code=code)
    assert message in result.stderr


def test_a_scenario_about_another_grammar_is_refused(run, files):
    _, scenario = files
    assert "not about toy" in run("learn", "toy", "--scenario", scenario, code=2).stderr


def test_nothing_to_like_is_told(run, files, tmp_path):
    grammar, _ = files
    scenario = tmp_path / "none.toml"
    scenario.write_text(SCENARIO.replace("{High:0}", "{High:0} and {Low}"))
    result = run("learn", grammar, "--scenario", scenario, "-o", tmp_path / "x.cga", code=1)
    assert "nothing to sample" in result.stderr
    assert not (tmp_path / "x.cga").exists()


@pytest.fixture
def labelled(run, files, tmp_path):
    """A rule file, a scenario, and labels that a simulated person gave."""
    grammar, scenario = files
    labels = tmp_path / "labels.csv"
    values = json.loads(run("label", scenario, "-n", "32", "-o", labels, "--json").stdout)
    assert (values["labels"], values["factors"]) == (32, ["overall"])
    return grammar, scenario, labels


def test_labels_of_a_simulated_person_become_a_grammar(run, labelled, tmp_path):
    grammar, scenario, labels = labelled
    out, report = tmp_path / "red.cga", tmp_path / "report"
    options = ("--labels", labels, "--scenario", scenario, "-o", out, "--report", report, "--json")
    values = json.loads(run("learn", grammar, *options).stdout)
    assert values["labels"] == 32
    assert values["scenario"]["js"] < 1e-6
    assert values["scenario"]["js_before"] > 0.1
    assert "Lot --> extrude(height) High" in out.read_text()
    assert (report / "before-after.png").stat().st_size > 1000
    assert "| labels | 32 |" in (report / "report.md").read_text()
    told = run("learn", grammar, "--labels", labels, "-o", out).stderr
    assert "looked at: High" in told


def test_labels_of_a_changed_rule_file_are_refused(run, labelled, rules):
    _, _, labels = labelled
    changed = rules(RULES.replace("70%", "60%"), "other.cga")
    assert "about another grammar" in run("learn", changed, "--labels", labels, code=2).stderr


def test_without_anything_to_learn_from_help_is_given(run, files):
    assert "--labels FILE" in run("learn", files[0], code=2).stderr


def test_grammars_are_compared(run, labelled, tmp_path):
    grammar, scenario, _ = labelled
    out, picture = tmp_path / "red.cga", tmp_path / "both.png"
    run("learn", grammar, "--scenario", scenario, "-o", out)
    values = json.loads(run("compare", grammar, out, "-n", "300", "--picture", picture, "--json").stdout)
    assert values["js"] is None
    assert values["js_at_least"] > 0.1
    assert "Low" in values["only_first"]
    assert picture.stat().st_size > 1000
    assert "only the first made: Low" in run("compare", grammar, out, "-n", "300").stderr
