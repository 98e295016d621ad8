"""``grammarlab learn``."""

import json
import re

import pytest

from grammarlab.language.grammar import Grammar
from grammarlab.language.presets import preset
from grammarlab.language.syntax.syntax_tree import Number
from grammarlab.preference.label_files import save_labels
from grammarlab.preference.labels import Label, Labels
from grammarlab.runs.learn import report
from tests.cases import some, takes_turns
from tests.command_line import invoke

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


REPORT = {"report.md", "before-after-1x1.png", "before-after-2x2.png"}


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    monkeypatch.setattr(report, "SIDES", (1, 2))
    monkeypatch.setattr(report, "WIDTH", 100)


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
    assert set(values) == {
        "scenario",
        "method",
        "js",
        "correlation",
        "rules_before",
        "rules_after",
        "seconds",
        "findings",
    }
    assert (values["scenario"], values["method"]) == ("Test", "compile")
    assert (values["rules_before"], values["rules_after"]) == (5, 2)
    assert values["js"] <= 1e-12
    text = out.read_text()
    assert "// Scenario Test: High and red\n// Method compile, base grammar\n" in text
    assert "Lot --> extrude(height) High" in text
    assert Grammar.parse(text).rules.keys() == {("Lot", 0), ("High", 0)}


def test_sizes_are_numbers_of_branches_as_show_counts_them(run, files, tmp_path):
    grammar, scenario = files
    out = tmp_path / "red.cga"
    values = json.loads(run("learn", grammar, "--scenario", scenario, "-o", out, "--json").stdout)
    for file, size in ((grammar, values["rules_before"]), (out, values["rules_after"])):
        assert f"branches: {size}," in " ".join(run("show", file).stdout.split())
    told = run("learn", grammar, "--scenario", scenario, "-o", out).stderr
    assert "2 branches of rules, 5 before" in " ".join(told.split())
    assert "branches of the rules, as grammarlab show" in " ".join(
        re.sub("[│|]", " ", run("learn", "--help").stdout).split()
    )


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
        (["--method", "magic"], 2, "unknown method 'magic'"),
        (["--scenario", "missing.toml"], 2, "no scenario file"),
        (["--base", "uniform"], 2, "--base and --max-rules need --labels"),
        (["--max-rules", "3"], 2, "--base and --max-rules need --labels"),
    ],
)
def test_mistakes_are_told(run, files, options, code, message):
    grammar, scenario = files
    result = run("learn", grammar, "--scenario", scenario, *options, code=code)
    assert message in result.stderr


@pytest.mark.parametrize("command", [("learn", "building", "--scenario"), ("label",), ("evaluate",)])
def test_all_commands_take_the_same_names_of_scenarios(run, command):
    assert "Did you mean 'B1'" in run(*command, "b1", code=2).stderr
    assert "is about building, not about toy" in run("learn", "toy", "--scenario", "B1", code=2).stderr


def test_one_scenario_is_learned_from(run, files):
    assert "expected one scenario, found 2" in run("learn", files[0], "--scenario", "B1,B2", code=2).stderr


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


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """Labels that a simulated person gave, as they are in their file."""
    folder = tmp_path_factory.mktemp("labels")
    (folder / "house.cga").write_text(RULES)
    (folder / "test.toml").write_text(SCENARIO)
    command = ["label", str(folder / "test.toml"), "-n", "32", "-o", str(folder / "labels.csv"), "--json"]
    values = json.loads(invoke(*command).stdout)
    assert (values["labels"], values["factors"]) == (32, ["overall"])
    return (folder / "labels.csv").read_bytes()


@pytest.fixture
def labelled(files, tmp_path, given):
    """A rule file, a scenario, and labels that a simulated person gave."""
    labels = tmp_path / "labels.csv"
    labels.write_bytes(given)
    return *files, labels


@pytest.mark.parametrize("which", [0, 1, 2])
def test_a_file_that_is_read_is_not_written_over(run, labelled, which):
    grammar, scenario, labels = labelled
    before = [path.read_bytes() for path in labelled]
    result = run("learn", grammar, "--labels", labels, "--scenario", scenario, "-o", labelled[which], code=2)
    assert "is the input file" in result.stderr
    assert "is the input file" in run("label", scenario, "-o", scenario, code=2).stderr
    assert [path.read_bytes() for path in labelled] == before


def test_labels_of_a_simulated_person_become_a_grammar(run, labelled, tmp_path):
    grammar, scenario, labels = labelled
    out, folder = tmp_path / "red.cga", tmp_path / "report"
    options = ("--labels", labels, "--scenario", scenario, "-o", out, "--report", folder, "--json")
    values = json.loads(run("learn", grammar, *options).stdout)
    assert values["labels"] == 32
    assert values["js"] == values["scenario"]["js"] < 1e-6
    assert values["js_before"] == values["scenario"]["js_before"]
    assert values["scenario"]["js_before"] > 0.1
    assert values["explained"].keys() == values["kept"].keys()
    assert f"This explains {values['explained']['overall']:.0%} of held-out scores." in out.read_text()
    assert "Lot --> extrude(height) High" in out.read_text()
    assert {file.name for file in folder.iterdir()} == REPORT | {"choice-1.png"}
    assert "| labels | 32 |" in (folder / "report.md").read_text()
    told = run("learn", grammar, "--labels", labels, "-o", out).stderr
    assert re.search(r"^(Likes|Does not like): .*others", told, re.MULTILINE)


def test_a_scenario_beside_labels_is_compared_with_and_changes_nothing(run, labelled, tmp_path):
    grammar, scenario, labels = labelled
    # What the scenario offers to learn from, its seed and its pool are others than those of a person.
    scenario.write_text(
        SCENARIO.replace("num_models = 200", "num_models = 150\nseed = 9")
        + '[features]\npath_length = 1\nfamilies = ["symbols"]\n'
    )
    options = ("--labels", labels, "--json", "-o")
    plain = json.loads(run("learn", grammar, *options, tmp_path / "plain.cga").stdout)
    compared = json.loads(run("learn", grammar, *options, tmp_path / "new.cga", "--scenario", scenario).stdout)
    assert (tmp_path / "new.cga").read_bytes() == (tmp_path / "plain.cga").read_bytes()
    assert plain.keys() | {"scenario"} == compared.keys()
    # Without a scenario the divergence is that from what the labels taught.
    assert {name: plain[name] for name in ("js", "js_before")} == plain["taught"] == compared["taught"]
    assert compared["js_before"] != compared["taught"]["js_before"]


@takes_turns
def test_labels_may_be_compared_with_what_a_person_means(run, labelled, tmp_path):
    grammar, scenario, _ = labelled
    scenario.write_text(SCENARIO + '[[preference]]\nscore = 40\nwhen = "{High}"\n')
    labels = tmp_path / "stars.csv"
    run("label", scenario, "-n", "32", "--person", "stars", "-o", labels)
    options = ("--labels", labels, "--scenario", scenario, "--json", "-o")
    exact = json.loads(run("learn", grammar, *options, tmp_path / "exact.cga").stdout)
    stars = json.loads(run("learn", grammar, *options, tmp_path / "stars.cga", "--person", "stars").stdout)
    assert (tmp_path / "exact.cga").read_bytes() == (tmp_path / "stars.cga").read_bytes()
    # Round percentages cost a little.
    assert stars["js"] < 1e-4 < exact["js"]
    assert exact["taught"] == stars["taught"]


@pytest.mark.parametrize("options", [("--labels", "labels.csv"), ("--scenario", "B1")])
def test_a_person_without_labels_or_something_to_compare_with_is_refused(run, options):
    assert "--labels FILE and --scenario FILE" in run("learn", "building", "--person", "stars", *options, code=2).stderr


@pytest.fixture
def said(run, files, tmp_path):
    """Scores in the file of a person."""

    def call(*options):
        file = tmp_path / "labels.jsonl"
        values = json.loads(run("label", files[1], "-n", "16", "-o", file, "--json", *options).stdout)
        scores = [json.loads(line)["score"] for line in file.read_text().splitlines()]
        assert (values["person"], values["labels"]) == (options[1] if options else "exact", len(scores))
        return scores

    return call


def test_without_a_person_the_scores_are_exact(said):
    assert set(said()) == {0.0, 80.0}


@pytest.mark.parametrize("name", some(["sd10", "blunders10", "stars"]))
@takes_turns
def test_what_a_person_said_is_in_the_file_and_is_said_again(said, name):
    scores = said("--person", name)
    assert scores == said("--person", name)
    assert (set(scores) == {0.0, 75.0}) == (name == "stars")
    assert scores != said("--person", name, "--seed", "2")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--seed", f"{2**64}"), "--seed"),
        (("--seed", "-1"), "--seed"),
        (("--person", "sd"), "unknown person 'sd'"),
        (("--person", "sd5,sd10"), "expected one person, found 2"),
        (("--method", "magic"), "unknown method 'magic'"),
        (("-o", "labels.txt"), "labels.txt"),
    ],
)
def test_bad_options_of_label_end_in_one_message_before_the_work(run, files, options, message):
    assert message in run("label", files[1], *options, code=2).stderr


def test_the_last_seed_is_a_seed(run, files, tmp_path):
    options = ("-n", "8", "--seed", f"{2**64 - 1}", "-o", tmp_path / "labels.csv")
    assert "8 scores" in run("label", files[1], *options).stderr


def test_labels_of_a_changed_rule_file_are_refused(run, labelled, rules):
    _, _, labels = labelled
    changed = rules(RULES.replace("70%", "60%"), "other.cga")
    assert "about another grammar" in run("learn", changed, "--labels", labels, code=2).stderr


def test_a_scenario_is_learned_with_its_choices_and_with_those_of_the_command(run, rules, tmp_path):
    grammar, scenario, out = rules(RULES + "House --> Lot\n"), tmp_path / "test.toml", tmp_path / "red.cga"
    keys = 'start = "House"\n[attributes]\nheight = 4\n\n[[preference]]'
    scenario.write_text(SCENARIO.replace("[[preference]]", keys))
    for choices in ((), ("--start", "House", "--attr", "height=4")):
        run("learn", grammar, *choices, "--scenario", scenario, "-o", out)
        learned = Grammar.parse(out.read_text())
        assert {rule.name.partition("_")[0] for rule in learned.start_rules} == {"House"}
        assert learned.attributes["height"].value == Number(4.0)
    refused = run("learn", grammar, "--start", "Lot", "--scenario", scenario, "-o", out, code=2)
    assert "start rule, values of attributes" in refused.stderr


def test_labels_are_those_of_the_choices(run, rules, tmp_path):
    grammar, labels = rules(RULES), tmp_path / "labels.csv"
    text = preset(Grammar.parse(RULES), "High", {"height": 4})
    save_labels(Labels(tuple(Label(0, model, "overall", 0.0, text.hash) for model in range(8))), labels)
    choices = ("--start", "High", "--attr", "height=4")
    assert "nothing is liked" in run("learn", grammar, *choices, "--labels", labels, code=2).stderr
    assert "about another grammar" in run("learn", grammar, "--labels", labels, code=2).stderr


def test_imports_that_cannot_be_read_are_named_with_the_option_for_them(run, rules, tmp_path):
    grammar = rules('import gone : "/ESRI.lib/rules/gone.cga"\n' + RULES)
    labels = tmp_path / "labels.csv"
    save_labels(Labels((Label(0, 0, "overall", 0.0, "0" * 64),)), labels)
    lines = run("learn", grammar, "--labels", labels, code=2).stderr
    assert re.search('not supported: the import "/ESRI.lib/rules/gone.cga".*\n--library DIR names a folder', lines)
    (tmp_path / "ESRI.lib" / "rules").mkdir(parents=True)
    (tmp_path / "ESRI.lib" / "rules" / "gone.cga").write_text("A --> NIL")
    lines = run("learn", grammar, "--labels", labels, "--library", tmp_path, code=2).stderr
    assert "not supported" not in lines


def test_examples_are_those_of_the_choices(run, rules, tmp_path):
    grammar = rules(RULES)
    choices = ("--start", "High", "--attr", "height=4")
    run("sample", grammar, *choices, "-n", "4", "--no-image", "-o", tmp_path / "run")
    examples = ("--examples", tmp_path / "run", "-o", tmp_path / "red.cga")
    assert "4 examples" in run("learn", grammar, *choices, *examples).stderr
    learned = Grammar.parse((tmp_path / "red.cga").read_text())
    assert {rule.name.partition("_")[0] for rule in learned.start_rules} == {"High"}
    assert "begin with another rule, which --start chooses" in run("learn", grammar, *examples, code=2).stderr


def test_without_anything_to_learn_from_help_is_given(run, files):
    assert "--labels FILE" in run("learn", files[0], code=2).stderr


def test_grammars_are_compared(run, labelled, tmp_path):
    grammar, scenario, _ = labelled
    out, picture = tmp_path / "red.cga", tmp_path / "both.png"
    run("learn", grammar, "--scenario", scenario, "-o", out)
    values = json.loads(run("compare", grammar, out, "-n", "300", "--picture", picture, "--json").stdout)
    # The grammar as it was makes what is left with probability 0.6 x 0.7.
    assert values["js"] == pytest.approx(0.262, abs=0.02)
    assert values["origin"] == "house"
    assert values["choices"][0]["symbol"] == "Lot"
    assert "Low" in values["only_first"]
    assert picture.stat().st_size > 1000
    told = run("compare", grammar, out, "-n", "300").stderr
    assert "only the first makes: Low" in told
    assert "-> 100.0%  High" in told


@pytest.mark.parametrize("method", some(["compile", "tied", "rejection"]))
def test_a_page_says_what_rejection_would_accept(run, files, tmp_path, method):
    grammar, scenario = files
    folder = tmp_path / "report"
    options = ("--method", method, "--samples", "200", "--report", folder, "-o", tmp_path / "new.cga")
    run("learn", grammar, "--scenario", scenario, *options)
    assert {file.name for file in folder.iterdir()} == REPORT
    text = (folder / "report.md").read_text()
    assert "| distance from what is liked | 36" in text
    assert "effective models of the 200 looked at" in text
    assert ("share above the bound, cut off" if method == "rejection" else "that rejection would accept | 4") in text


@pytest.fixture
def examples(run, files, rules, tmp_path):
    """A rule file, and samples of one with other percentages."""
    grammar, _ = files
    changed = rules(RULES.replace("40% : extrude", "90% : extrude"), "mostly_low.cga")
    out = tmp_path / "samples"
    run("sample", changed, "-n", "120", "--no-image", "--jobs", "1", "-o", out)
    return grammar, out


def test_finished_models_are_learned_from(run, examples, tmp_path):
    grammar, samples = examples
    out, folder = tmp_path / "low.cga", tmp_path / "report"
    values = json.loads(run("learn", grammar, "--examples", samples, "-o", out, "--report", folder, "--json").stdout)
    assert (values["examples"], values["method"]) == (120, "tied")
    assert values["held_out"]["examples"] == 24
    assert values["held_out"]["gain"] > 0.3
    assert values["js_before"] > 0.1
    assert {file.name for file in folder.iterdir()} == REPORT
    assert "// Examples samples: 120 models\n// Method tied from examples\n" in out.read_text()
    nodes = samples / "derivations" / "00000" / "nodes.parquet"
    assert "64 examples" in run("learn", grammar, "--examples", nodes, "--method", "parameters", "-o", out).stderr


def test_examples_can_be_compared_with_a_scenario(run, examples, files, tmp_path):
    grammar, samples = examples
    options = ("--examples", samples, "--scenario", files[1], "-o", tmp_path / "low.cga", "--json")
    assert json.loads(run("learn", grammar, *options).stdout)["scenario"]["name"] == "Test"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--method", "compile"], "expected one of tied, structure, parameters"),
        (["--examples", "nowhere"], "no examples at 'nowhere'"),
        (["--labels", "labels.csv"], "one of --labels and --examples"),
    ],
)
def test_mistakes_with_examples_are_told(run, examples, options, message):
    grammar, samples = examples
    assert message in run("learn", grammar, "--examples", samples, *options, code=2).stderr


def test_examples_of_another_grammar_are_refused(run, examples, rules):
    _, samples = examples
    other = rules("Lot --> 50% : A else : B", "other.cga")
    assert "not models of this grammar" in run("learn", other, "--examples", samples, code=2).stderr
