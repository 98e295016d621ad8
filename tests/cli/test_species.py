"""Species of trees on the command line: the same commands, objects and exit codes as for grammars."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from PIL import Image

from grammarlab.runs.sample.shipped import shipped_species
from grammarlab.trees.measures import MEASURES
from grammarlab.trees.parameters import PARAMETERS
from grammarlab.trees.species_file import parse, write
from tests.cases import some, takes_turns
from tests.trees.small_species import SMALL


@pytest.fixture
def species(tmp_path: Path) -> Path:
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    return file


def test_sample_prints_the_object_of_grammars_and_writes_the_same_files(run, species, tmp_path):
    trees = json.loads(run("sample", species, "-n", 2, "--seed", 3, "-o", tmp_path / "trees", "--json").stdout)
    models = json.loads(run("sample", "toy", "-n", 2, "-o", tmp_path / "toys", "--json", "--no-image").stdout)
    assert trees.keys() == models.keys()
    assert trees["models"][0].keys() == models["models"][0].keys()
    assert {path.name for path in (tmp_path / "trees").iterdir()} == {
        "small-00000.glb",
        "small-00001.glb",
        "small.png",
        "derivations",
        "manifest.json",
    }
    with Image.open(trees["sheet"]) as sheet:
        assert sheet.width > 300


@pytest.mark.parametrize("file_format", ["obj", "ply", "glb"])
def test_trees_are_written_in_every_format(run, species, tmp_path, file_format):
    options = ("--format", file_format, "--no-image", "--attr", "detail=low", "-o", tmp_path / "out")
    run("sample", species, "-n", 2, *options)
    assert len(list((tmp_path / "out").glob(f"small-*.{file_format}"))) == 2


def test_instances_make_files_smaller(run, species, tmp_path):
    for reuse in ("none", "nodes", "gpu"):
        run("sample", species, "--no-image", "--instancing", reuse, "-n", 1, "-o", tmp_path / reuse)
    none, gpu = ((tmp_path / reuse / "small-00000.glb").stat().st_size for reuse in ("none", "gpu"))
    assert gpu < none


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--attr", "scal=12"), "Did you mean 'scale'?"),
        (("--attr", "scale=500"), "expected 0.05 to 120 m, found '500'"),
        (("--attr", "scale"), "expected name=value"),
        (("--attr", "scale=4", "--attr", "scale=5"), "given twice"),
        (("--attr", "levels=9"), "expected a whole number from 1 to 4"),
        (("--attr", "detail=lo"), "expected one of full, medium, low, cards"),
        (("--start", "Lot"), "trees have no rules"),
    ],
)
def test_wrong_options_of_sample_are_explained(run, species, tmp_path, arguments, message):
    assert message in run("sample", species, *arguments, "-o", tmp_path / "out", code=2).stderr
    assert not (tmp_path / "out").exists()


def test_a_misspelt_species_is_answered_with_the_nearest(run):
    assert "Did you mean 'birch'?" in run("sample", "brch", code=2).stderr
    assert "Did you mean 'birch'?" in run("show", "Birch.toml", code=2).stderr


def test_a_species_with_errors_is_explained_with_line_and_caret(run, species, tmp_path):
    species.write_text(SMALL.replace("value = 5.0", "value = -5.0").replace("levels = 2", "levels = 9"))
    for command in (("check", species), ("sample", species, "-o", tmp_path / "out"), ("show", species)):
        result = run(*command, code=1)
        text = result.stdout + result.stderr
        assert "small.toml:5:" in text
        assert "^" in text or command[0] != "check"
    values = json.loads(run("check", species, "--json", code=1).stdout)
    assert values["error"] == len(values["findings"]) == 2


def test_check_warns_of_pictures_that_are_not_there(run, species, tmp_path):
    species.write_text(SMALL + '\n[look]\nbark = "gone.png"\nleaf = "leaf.png"\n')
    (tmp_path / "assets").mkdir()
    Image.new("RGB", (8, 8)).save(tmp_path / "assets" / "leaf.png")
    (finding,) = json.loads(run("check", species, "--json").stdout)["findings"]
    assert finding["code"] == "missing-asset"
    assert "gone.png" in finding["message"]
    assert "no such image" in run("sample", species, "--no-image", "-n", 1, "-o", tmp_path / "out").stderr


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.xml", '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;&b;">]><arbaro>&c;</arbaro>'),
        ("a.xml", "<arbaro>"),
        ("a.xml", '<arbaro><species name="a"><param name="Levels" value="9"/></species></arbaro>'),
        ("a.xml", '<arbaro><species name="a"><param name="Scale" value="nan"/></species></arbaro>'),
        ("a.toml", "[tree]\nscale = nan\n"),
        ("a.toml", "[tree]\nbranches_1 = 1000000000\n"),
        ("a.toml", "[tree]\nlevels = 4\nscale = [" + "[" * 5000),
        ("a.toml", "name = 'T1'\ngrammar = 'toy'\n"),
        ("a.toml", "\ud800"),
    ],
)
def test_hostile_files_end_in_a_message(run, tmp_path, name, content):
    (tmp_path / name).write_bytes(content.encode("utf-8", "surrogatepass"))
    for command in ("check", "sample", "show", "format"):
        output = ("-o", tmp_path / "out") if command == "sample" else ()
        result = run(command, tmp_path / name, *output, code=1)
        assert "error" in result.stdout + result.stderr
        assert len(result.stdout + result.stderr) < 10_000


def test_trees_of_a_billion_stems_are_refused(run, species, tmp_path):
    levels = "".join(f"\n[level_{n}]\nbranches_{n} = 2000\ncurve_res_{n} = 1\n" for n in (2, 3))
    text = SMALL.replace("levels = 2", "levels = 4").replace("{ value = 6, range = [4, 9] }", "2000")
    species.write_text(text + levels)
    result = run("sample", species, "--no-image", "-o", tmp_path / "out", code=2)
    assert "are possible" in result.stderr


@takes_turns
def test_show_lists_parameters_with_unit_range_and_reason(run, species, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    text = run("show", species).stdout
    line = next(line for line in text.splitlines() if line.startswith("scale "))
    assert re.split(" {2,}", line.strip()) == ["scale", "5", "3 to 8", "m", "it is small"]
    assert "leaf_bend" not in text
    assert all(name in run("show", species, "--all").stdout for name in PARAMETERS)
    values = json.loads(run("show", species, "--json").stdout)
    assert [entry["name"] for entry in values["parameters"]] == list(PARAMETERS)
    scale = next(entry for entry in values["parameters"] if entry["name"] == "scale")
    assert (scale["value"], scale["range"], scale["unit"], scale["why"]) == (5.0, [3.0, 8.0], "m", "it is small")
    assert (scale["spread"], scale["limits"]) == (0.0, [0.05, 120.0])


def test_show_lists_kinds_and_the_acceptance_rule(run, species):
    kinds = "".join(
        f'\n[[kinds]]\nweight = {weight}\nmeans = "{means}"\n[kinds.ranges]\nscale = {ends}\n'
        for weight, means, ends in ((0.25, "tall ones", "[7.0, 8.0]"), (0.75, "low ones", "[3.0, 4.0]"))
    )
    species.write_text(f'acceptance = "choose($ratio < 0.02, 1, 0.5)"\n{SMALL}{kinds}')
    text = run("show", species).stdout
    assert all(word in text for word in ("tall ones", "scale 7 to 8", "choose($ratio < 0.02, 1, 0.5)"))
    values = json.loads(run("show", species, "--json").stdout)
    assert [kind["ranges"] for kind in values["kinds"]] == [{"scale": [7.0, 8.0]}, {"scale": [3.0, 4.0]}]


def test_show_lists_the_parameters_and_measures_of_a_tree(run, species, tmp_path):
    arguments = ("show", species, "--model", 1, "--seed", 3, "--attr", "leaves=2")
    values = json.loads(run(*arguments, "--json").stdout)
    assert values["parameters"]["leaves"] == 2
    options = ("-n", 2, "--seed", 3, "--attr", "leaves=2", "--no-image", "--json", "-o", tmp_path / "out")
    model = json.loads(run("sample", species, *options).stdout)["models"][1]
    assert {name: report["mean"] for name, report in model["reports"].items()} == values["measures"]
    assert model["shapes"] == values["parts"]
    assert model["log_probability"] == values["log_probability"]
    text = run(*arguments).stdout
    assert text.startswith("small, model 1 of seed 3: 1, ")
    assert all(name in text for name in MEASURES)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--graph", "a.svg"), "--graph is about rules"),
        (("--model", 1, "--start", "Lot"), "--start is about rules"),
        (("--model", 1, "--footprint", "9x9"), "--footprint is about rules"),
        (("--seed", 1), "say which, as in --model 17 --seed 5"),
        (("--model", -1), "expected a whole number from 0"),
    ],
)
def test_show_refuses_options_that_trees_do_not_have(run, species, arguments, message):
    assert message in run("show", species, *arguments, code=2).stderr


def test_format_prints_checks_and_writes_species(run, species):
    canonical = write(parse(SMALL, "small"))
    species.write_text("# Mine.\n" + SMALL)
    assert run("format", species).stdout == f"# Mine.\n\n{canonical}"
    run("format", species, "--check", code=1)
    run("format", species, "--in-place")
    run("format", species, "--check")
    assert "comments at the top only" in run("format", _with(species, "levels = 2 # two\n"), code=2).stderr
    assert run("format", _with(species, 'about = "a # sign"\n')).stdout == 'about = "a # sign"\n'


def _with(file: Path, text: str) -> Path:
    file.write_text(text if text.startswith("about") else f"[tree]\n{text}")
    return file


def test_trees_are_converted_to_arbaro_and_back(run, species, tmp_path):
    file = tmp_path / "small.xml"
    file.write_text(run("format", species, "--to", "arbaro").stdout)
    converted = run("format", file).stdout
    old, new = parse(SMALL, "small"), parse(converted, "small")
    assert new.typical.tolist() == old.typical.tolist()
    assert "leave out --check and --in-place" in run("format", file, "--in-place", code=2).stderr
    assert "cannot be written as .xml files" in run("format", "toy", "--to", "arbaro", code=2).stderr
    assert "nothing to complain about" in run("check", file).stdout


def test_species_of_one_text_do_not_differ_and_others_do(run, species, tmp_path):
    other, constant = tmp_path / "other.toml", tmp_path / "constant.toml"
    other.write_text(SMALL.replace("range = [3.0, 8.0]", "range = [4.0, 8.0]"))
    constant.write_text(SMALL.replace(", range = [3.0, 8.0]", ""))
    same = json.loads(run("compare", species, species, "--json").stdout)
    assert (same["js"], same["numbers"], same["only_first"]) == (0.0, [], [])
    values = json.loads(run("compare", species, other, "--json", "-n", 4000).stdout)
    assert values.keys() == json.loads(run("compare", "toy", "toy", "--json", "-n", 8).stdout).keys()
    # An even density on 5 m against one on its upper 4 m, which are log-uniform.
    assert values["js"] == pytest.approx(_js_of_nested(1.0 - LOG_4_OVER_3 / LOG_8_OVER_3), abs=0.01)
    assert [number["attribute"] for number in values["numbers"]] == ["scale"]
    assert json.loads(run("compare", species, constant, "--json").stdout)["js"] == pytest.approx(0.693147, abs=1e-5)
    assert "different kinds" in run("compare", species, "toy", code=2).stderr
    run("compare", species, other, "-n", 50, "--picture", tmp_path / "two.png")
    with Image.open(tmp_path / "two.png") as picture:
        assert picture.width > picture.height


LOG_4_OVER_3, LOG_8_OVER_3 = 0.28768207245178085, 0.9808292530117262


def _js_of_nested(share: float) -> float:
    """Divergence of an even density from one on a share of its range, in nats."""
    from math import log

    return 0.5 * (log(2.0) * (1.0 - share) + share * log(2.0 * share / (1.0 + share)) + log(2.0 / (1.0 + share)))


def test_completion_knows_species():
    from grammarlab.cli.sample import complete_grammar

    names = {source.name for source in shipped_species()}
    assert names <= set(complete_grammar(""))
    assert complete_grammar("bir") == ["birch"]


@pytest.mark.parametrize("name", some([source.name for source in shipped_species()]))
def test_words_of_species_are_whole_in_80_columns(run, name, monkeypatch):
    for options in ((), ("--all",), ("--model", 2)):
        texts = []
        for columns in (80, 400):
            monkeypatch.setenv("COLUMNS", str(columns))
            texts.append(run("show", name, *options).stdout.splitlines()[1:])
        assert max(map(len, texts[0])) <= 80
        narrow, wide = ("\n".join(text).replace("─", "").split() for text in texts)
        assert sorted(narrow) == sorted(wide)
