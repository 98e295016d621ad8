"""``grammarlab check``, ``show``, ``format`` and ``list``."""

import json
import os
import re
import stat
from collections import Counter

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from grammarlab.assets.mesh_files import MAX_BYTES
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.shipped import find_rules, shipped_examples, shipped_facades, shipped_species
from grammarlab.runs.sample.shipped_sheet import save_sheet
from grammarlab.runs.work.executors import SERIAL
from tests.runs.grammars import BROKEN, TOWER


def test_check_lists_findings_with_line_and_caret_and_exits_with_1(run, rules):
    result = run("check", rules(BROKEN), code=1)
    assert "house.cga:3:" in result.stdout
    assert "^" in result.stdout
    assert "error" in result.stdout.splitlines()[-1]


def test_check_exits_with_0_when_there_are_only_warnings(run, rules):
    result = run("check", rules("Lot --> extrude(3)\nNever --> color(1, 0, 0)"))
    assert "1 warning" in result.stdout


def test_check_as_json_carries_the_same_findings(run, rules):
    values = json.loads(run("check", rules(BROKEN), "--json", code=1).stdout)
    assert values["error"] == sum(f["severity"] == "error" for f in values["findings"]) > 0
    assert values["findings"][0]["location"]["line"] == 3


def test_check_warns_of_meshes_that_are_not_there(run, rules, tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "oak.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    path = rules(
        'attr tree = "oak.obj"\nLot --> i(tree) i("gone.obj") i("builtin:cube") i("../x.obj") i("a" + "b") Oak'
    )
    rules('Oak --> i("leaf.obj")', "unused.cga")
    found = [
        json.loads(run("check", path, "--json", *options).stdout)["findings"]
        for options in ([], ["--assets", tmp_path / "meshes"])
    ]
    named = [[f["message"].split('"')[1] for f in each if f["code"] == "missing-asset"] for each in found]
    assert named == [["oak.obj", "gone.obj"], ["gone.obj"]]
    assert "--assets DIR" in run("check", path).stdout


def test_check_warns_of_meshes_that_no_model_can_insert(run, rules, tmp_path):
    (tmp_path / "huge.obj").touch()
    os.truncate(tmp_path / "huge.obj", MAX_BYTES + 1)
    path = rules('const tree = "huge.obj"\nLot --> i(tree) Up\nUp --> i("../up.obj") i("loop.obj")')
    (tmp_path / "loop.obj").symlink_to("loop.obj")
    findings = json.loads(run("check", path, "--json").stdout)["findings"]
    assert all(finding["severity"] == "warning" for finding in findings)
    by_name = {finding["message"].split('"')[1]: finding for finding in findings}
    assert by_name.keys() == {"huge.obj", "../up.obj", "loop.obj"}
    assert by_name["huge.obj"]["code"] == by_name["../up.obj"]["code"] == "bad-asset"
    assert "bytes" in by_name["huge.obj"]["message"]
    assert "outside the asset folder" in by_name["../up.obj"]["message"]
    assert by_name["loop.obj"]["location"]["line"] == 3


def test_check_and_sample_find_the_meshes_of_a_project(run, tmp_path):
    for folder in ("assets", "rules/lib"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "assets" / "oak.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    path = tmp_path / "rules" / "lib" / "wood.cga"
    path.write_text('Lot --> i("oak.obj") i("assets/oak.obj") Oak')
    assert json.loads(run("check", path, "--json").stdout)["findings"] == []
    made = json.loads(run("sample", path, "-n", 1, "--no-image", "-o", tmp_path / "out", "--json").stdout)
    assert made["warnings"] == []
    assert [model["triangles"] for model in made["models"]] == [1]  # a box has more


def test_check_reports_a_missing_or_unreadable_file(run, tmp_path):
    assert "no rule file" in run("check", tmp_path / "nowhere.cga", code=2).stderr
    (tmp_path / "big.cga").write_bytes(b" " * 20_000_000)
    assert "expected at most 16,777,216 bytes" in run("check", tmp_path / "big.cga", code=1).stderr
    report = json.loads(run("check", tmp_path / "big.cga", "--json", code=1).stdout)
    assert [finding["code"] for finding in report["findings"]] == ["unreadable-file"]


@settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)
@given(
    st.one_of(st.binary(max_size=200), st.text(alphabet='Lot->:{}()|*~%"#/ extrude\n1.', max_size=200).map(str.encode))
)
def test_check_ends_in_a_report_whatever_the_file_holds(run, run_any, tmp_path, content):
    (tmp_path / "any.cga").write_bytes(content)
    code = run_any("check", tmp_path / "any.cga").exit_code
    assert code in (0, 1)
    values = json.loads(run("check", tmp_path / "any.cga", "--json", code=code).stdout)
    assert {"findings", "error", "warning", "unsupported"} <= set(values)


@pytest.mark.parametrize("name", [example.name for example in shipped_examples()])
def test_show_names_every_rule_and_attribute_with_its_value(run, name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")
    text = run("show", name).stdout
    source = next(example for example in shipped_examples() if example.name == name).text()
    heads = [line.split("-->")[0].split("(")[0].strip() for line in source.splitlines() if "-->" in line]
    for head in heads:
        if head.isidentifier():
            assert head in text


def expect_whole_headings(text, kinds, columns=80):
    headings = {
        "Rules": ["Rule", "Branches", "Probabilities", "Leads", "to", "Line"],
        "Attributes": ["Attribute", "Value", "Range", "Group", "Description", "Line"],
    }
    lines = text.splitlines()
    assert max(map(len, lines[1:])) <= columns  # The first one is a path.
    for kind in kinds:
        start = [line.strip() for line in lines].index(kind) + 1
        assert next(line for line in lines[start:] if line.strip()).split() == headings[kind]


@pytest.mark.parametrize("name", [e.name for e in (*shipped_examples(), *shipped_facades()) if e.suffix == ".cga"])
def test_headings_are_whole_in_80_columns(run, name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = run("show", name).stdout
    tables = re.findall(r"^ *(Rules|Attributes) *\n(?!\n)", text, re.MULTILINE)
    assert tables or name in ("arcade_family", "quarter")  # Their longest names do not fit beside one another.
    expect_whole_headings(text, tables)


@pytest.mark.parametrize("length", [12, 22, 26, 40, 70])
@pytest.mark.parametrize("columns", [40, 80, 120])
def test_names_are_whole_in_a_table_or_where_they_do_not_fit_in_a_list(run, rules, monkeypatch, length, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    name, other, height = "A" * length, "B" * length, "h" * length
    path = rules(
        f'@Group("{name}") @Range(min=1000, max=2000, stepsize=100) @Description("{name[:12]} {other}")\n'
        f"attr {height} = {'7' * 9}\n@StartRule\n{name} --> 40% : {other} 30% : {name} else : {other} {name}\n"
    )
    text = run("show", path).stdout
    rule_table, attribute_table = text[text.index("\nRules") :].split("\nAttributes")
    assert {name, other, "@StartRule", "40", "4"} <= {word.strip(",;") for word in rule_table.split()}
    assert {height, name, "7" * 9, "min=1000", "2"} <= {word.strip(",;") for word in attribute_table.split()}
    # What is wider than the terminal is in a list, and a name alone is.
    assert all(len(line.split()) < 3 for line in text.splitlines()[1:] if len(line.rstrip()) > columns)
    if columns == 120 and length == 22:
        expect_whole_headings(text, ["Rules", "Attributes"], columns)


def test_show_gives_probabilities_and_ranges(run, rules, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    text = run("show", rules(TOWER)).stdout
    assert "60 / 40 %" in text
    assert "min=1, max=9" in text
    assert "rand(3, 9)" in text
    assert "@StartRule Lot" in text


def test_the_tables_are_printed_as_json_with_the_same_values(run, rules, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")
    path = rules(TOWER)
    values, text = json.loads(run("show", path, "--json").stdout), run("show", path).stdout
    grammar = Grammar.parse(path.read_text())
    assert [(row["rule"], len(row["parameters"])) for row in values["rules"]] == list(grammar.rules)
    assert [row["rule"] for row in values["rules"] if row["start"]] == [rule.name for rule in grammar.start_rules]
    free = [attribute.name for attribute in grammar.attributes.values() if not attribute.constant]
    assert [row["attribute"] for row in values["attributes"]] == free
    assert all(f"{name}: {count}" in text for name, count in values["counts"].items())
    cells = [str(cell) for row in (*values["rules"], *values["attributes"]) for cell in row.values()]
    assert all(cell in text for cell in cells if cell not in ("True", "False") and not cell.startswith("["))
    assert "give one of them" in run("show", path, "--json", "--graph", "rules.svg", code=2).stderr


def test_names_are_whole_in_80_columns_and_rules_come_first(run, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = run("show", "building").stdout
    assert max(map(len, text.splitlines()[1:])) <= 80
    values = json.loads(run("show", "building", "--json").stdout)
    names = [name for row in values["rules"] for name in (row["rule"], *row["leads to"])]
    names += [row["attribute"] for row in values["attributes"]]
    assert Counter(name.strip(".") for name in names) <= Counter(re.findall(r"\w+", text))
    assert text.index("Rules") < text.index("Attributes")


def test_a_model_with_many_draws_is_shown_in_80_columns(run):
    arguments = ("show", "building", "--model", 3, "--seed", 1)
    lines = run(*arguments).stdout.splitlines()
    # Deep in a tree a symbol and what is first said about it may take more.
    assert max(map(len, lines[:20])) <= 80
    values = json.loads(run(*arguments, "--json").stdout)["nodes"][0]["draws"]
    text = " ".join(lines)
    assert all(f"  {draw['site']} = {draw['value']:.6g}" in text for draw in values if draw["kind"] == "uniform")


def test_the_sheet_has_a_picture_of_each_file(tmp_path):
    save_sheet([find_rules("toy"), find_rules("limits")], tmp_path / "new" / "sheet.png", SERIAL)
    with Image.open(tmp_path / "new" / "sheet.png") as picture:
        assert picture.width > 2 * 200
        assert picture.height < 400


def test_an_option_taken_as_the_name_of_the_sheet_is_named(run):
    refused = run("list", "--sheet", "--help", code=2)
    assert "--sheet: expected the name of a .png file" in refused.stderr
    assert "found '--help'" in refused.stderr


def test_strangers_share_nothing(run):
    told = run("compare", "toy", "limits", "-n", 5)
    assert "these grammars share nothing" in told.stderr
    assert "significantly" not in told.stderr


@pytest.mark.parametrize("name", [example.name for example in shipped_examples()])
def test_a_rule_graph_has_a_box_for_every_symbol(run, name, tmp_path):
    run("show", name, "--graph", tmp_path / "graph.svg")
    labels = re.findall(r"<text[^>]*>([^<]*)</text>", (tmp_path / "graph.svg").read_text())
    assert len(labels) == len(set(labels))
    assert len(labels) > 5
    run("show", name, "--graph", tmp_path / "graph.png")
    with Image.open(tmp_path / "graph.png") as picture:
        assert picture.width > 200


def test_a_rule_graph_needs_a_known_kind_of_file(run, tmp_path):
    assert ".svg or .png" in run("show", "toy", "--graph", tmp_path / "graph.pdf", code=2).stderr


def test_show_lists_how_a_model_was_derived(run):
    arguments = ("show", "toy", "--model", 17, "--seed", 5)
    lines = run(*arguments).stdout.splitlines()
    assert lines[0].startswith("toy, model 17 of seed 5: 9 shapes")
    values = json.loads(run(*arguments, "--json").stdout)
    assert len(values["nodes"]) == 9 == len(run(*arguments, "--all").stdout.splitlines()) - 2
    values = json.loads(run(*arguments, "--json", "--attr", "h1=2", "--footprint", "9x9").stdout)
    assert "h1" not in {draw["site"] for draw in values["nodes"][0]["draws"]}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--seed", 5), "say which, as in --model 17 --seed 5"),
        (("--all",), "--all is about one model"),
        (("--model", 1, "--graph", "rules.svg"), "give one of them"),
        (("--model", -1), "expected a whole number from 0"),
        (("--model", 1, "--attr", "h1"), "name=value"),
    ],
)
def test_show_says_what_is_missing_to_list_a_model(run, arguments, message):
    assert message in run("show", "toy", *arguments, code=2).stderr


def test_format_prints_checks_and_writes(run, rules):
    path = rules("Lot-->extrude( 3 )Wall // tall\n")
    printed = run("format", path).stdout
    assert printed == "Lot --> extrude(3) Wall  // tall\n"
    run("format", path, "--check", code=1)
    run("format", path, "--in-place")
    assert path.read_text() == printed
    run("format", path, "--check")
    assert "exclude each other" in run("format", path, "--check", "--in-place", code=2).stderr


def test_format_in_place_writes_through_a_link_and_keeps_permissions(run, rules, tmp_path):
    path = rules("Lot-->NIL\n")
    path.chmod(0o640)
    for name, target in (("link.cga", path.name), ("second.cga", "link.cga")):
        (tmp_path / name).symlink_to(target)
    run("format", tmp_path / "second.cga", "--in-place")
    assert path.read_text() == "Lot --> NIL\n"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert [(tmp_path / name).is_symlink() for name in ("link.cga", "second.cga")] == [True, True]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["house.cga", "link.cga", "second.cga"]


def test_format_leaves_a_file_with_errors_alone(run, rules):
    path = rules(BROKEN)
    run("format", path, "--in-place", code=1)
    assert path.read_text() == BROKEN


def test_list_shows_every_shipped_example_with_a_description(run):
    lines = run("list").stdout.splitlines()
    values = json.loads(run("list", "--json").stdout)
    groups = {"examples": shipped_examples(), "facades": shipped_facades(), "species": shipped_species()}
    assert values.keys() == groups.keys()
    assert [line.split()[0] for line in lines] == [source.name for sources in groups.values() for source in sources]
    assert all(find_rules(source.name) == source for sources in groups.values() for source in sources)
    for key, sources in groups.items():
        assert [entry["name"] for entry in values[key]] == [source.name for source in sources]
        assert all(entry["description"] for entry in values[key])
