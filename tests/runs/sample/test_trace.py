"""Models traced to the rule text."""

import re

import numpy as np
import pytest

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import compile_grammar, derive
from grammarlab.errors import UsageError
from grammarlab.language.importing import load
from grammarlab.runs.sample.trace import as_lines, as_values, trace_model
from grammarlab.runs.sample.tree_drawing import save_tree
from tests.whole_grammars import WHOLE

GRAMMARS = WHOLE
TEXT = """\
attr height = rand(2, 4)
Lot --> extrude(height) split(x) { { 5 : Bay }* } [ t(0, 9, 0) Roof ]
Bay --> 50% : Wall. else : split(y) { 1 : Wall. | ~1 : Window }
Window --> case p(0.5) : Glass else : NIL
"""


@pytest.mark.parametrize("path", GRAMMARS, ids=lambda path: path.stem)
def test_every_shape_is_traced_to_the_word_that_made_it_and_to_a_branch_of_its_rule(path):
    grammar, model = load(path), 3
    rows = as_values(trace_model(str(path), model, 8))["nodes"]
    forest = derive(compile_grammar(grammar), 5, 8, assets=AssetFolder(path.parent / "assets"))
    assert len(rows) == forest.shapes_per_model()[model]
    lines = path.read_text(encoding="utf-8").splitlines()
    rules = {name: rule for (name, _), rule in grammar.rules.items()}
    depths = {}
    for row in rows:
        depths[row["node"]] = row["depth"]
        if row["parent"] < 0:
            assert (row["made_at"], row["depth"]) == (None, 0)
        else:
            assert row["depth"] == depths[row["parent"]] + 1
            place = row["made_at"]
            assert lines[place["line"] - 1][place["column"] - 1 :].startswith(row["symbol"])
        if row["rule_at"]:
            assert row["rule_at"]["line"] >= rules[row["symbol"]].location.line
    draws = [draw for row in rows for draw in row["draws"]]
    words = {"choice": "%", "uniform": "rand", "bernoulli": "p(", "file": "fileRandom"}
    assert all(words[draw["kind"]] in lines[draw["line"] - 1] for draw in draws)
    assert len(draws) == np.sum(forest.nodes.model[forest.draws.node] == model)
    leaves = forest.nodes.model[forest.leaves.node] == model
    sizes = np.array([size for row in rows for size in row["sizes"]])
    assert sorted(sizes.tolist()) == sorted(forest.leaves.size[leaves].tolist())


def written(folder, text=TEXT):
    path = folder / "bays.cga"
    path.write_text(text)
    return str(path)


def test_what_became_the_same_is_one_line_with_its_number(tmp_path):
    trace = trace_model(written(tmp_path), 0, 1, footprint="100x20")
    assert list(as_lines(trace)) == [
        "bays, model 0 of seed 1: 64 shapes, 28 visible",
        "   made at   rule at  symbol",
        "         -       2:9   Lot  height = 2.25531",
        "      2:42      3:15     Bay x 5  Bay: branch 1 of 2",
        "      3:15         -       Wall.  5.00 x 2.26 x 20.00 m",
        "      2:42      3:28     Bay x 7  Bay: branch 2 of 2",
        "      3:43         -       Wall.  5.00 x 1.00 x 20.00 m",
        "      3:56      4:26       Window  Window = true",
        "      4:26         -         Glass  5.00 x 1.26 x 20.00 m",
        "      2:42      3:28     Bay x 8  Bay: branch 2 of 2",
        "      3:43         -       Wall.  5.00 x 1.00 x 20.00 m",
        "      3:56      4:39       Window  Window = false",
        "      2:64         -     Roof  100.00 x 2.26 x 20.00 m",
    ]
    listed = list(as_lines(trace, everything=True))[2:]
    words = [line[21:].split("  ")[1:] for line in listed]
    assert [next(filter(None, w)) for w in words] == [row["symbol"] for row in as_values(trace)["nodes"]]


@pytest.mark.parametrize("suffix", [".svg", ".html"])
def test_a_tree_is_written_as_a_drawing_and_as_a_page_with_the_rows_of_the_listing(tmp_path, suffix):
    trace = trace_model(written(tmp_path), 0, 1, footprint="100x20")
    save_tree(trace, tmp_path / f"tree{suffix}")
    content = (tmp_path / f"tree{suffix}").read_text()
    words = " ".join(re.sub("<[^>]+>", " ", content).split())
    assert content.count("<li>") == content.count("</li>")
    places = [words.index(name) for name in ("Lot", "Bay x 5", "Bay x 7", "Glass", "Bay x 8", "Roof")]
    assert places == sorted(places)
    assert "line 2 · height = 2.25531" in words
    with pytest.raises(UsageError, match=r"\.svg or \.html"):
        save_tree(trace, tmp_path / "tree.png")


def test_a_listing_stays_short_where_every_shape_of_a_successor_differs(tmp_path):
    text = "Lot --> split(x) { { 1 : A }* }\nA --> 50% : B A else : 50% : C else : D A"
    lines = list(as_lines(trace_model(written(tmp_path, text), 0, 0, footprint="90x20")))
    assert len(lines) < 200
    counts = [re.match(r".{23}  A(?: x (\d+))?(?:  |$)", line) for line in lines]
    listed = sum(int(count[1] or 1) for count in counts if count)
    (more,) = [int(line.split()[1]) for line in lines if "more A" in line]
    assert listed + more == 90


def test_lines_behind_the_rule_file_are_said_to_be_imported(tmp_path):
    (tmp_path / "roofs.cga").write_text("Roof --> extrude(1) Tile")
    lines = list(as_lines(trace_model(written(tmp_path, 'import r : "roofs.cga"\nLot --> r.Roof'), 0, 0)))
    assert lines[1].startswith("places after line 2 are those of imported rules")
    assert [line.split()[2] for line in lines[3:]] == ["Lot", "r.Roof", "r.Tile"]


def test_options_are_those_of_a_run(tmp_path):
    path = written(tmp_path)
    row = as_values(trace_model(path, 4, 2, ["height=3"], "Bay", "7x5"))["nodes"][0]
    assert (row["symbol"], row["rule_at"]["line"]) == ("Bay", 3)
    assert all(draw["site"] != "height" for draw in row["draws"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"model": -1}, "model: expected a whole number from 0"),
        ({"seed": 2**64}, "seed: expected a whole number from 0"),
        ({"footprint": "MULTIPOLYGON(((0 0,5 0,5 5,0 0)),((9 9,15 9,15 15,9 9)))"}, "one polygon .* found 2"),
        ({"start_rule": "Glass"}, "Glass"),
        ({"attributes": ["width=3"]}, "width"),
    ],
)
def test_options_that_do_not_fit_are_refused(tmp_path, options, message):
    with pytest.raises(UsageError, match=message):
        trace_model(**({"grammar": written(tmp_path), "model": 0, "seed": 0} | options))
