"""Grammars with more rules, symbols, draws and successors than 16 bits count."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.derivation.selection import join_forests
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.derivations import load_forest, save_forest
from tests.cases import takes_turns
from tests.command_line import invoke
from tests.runs.forests import assert_same

NUM = 33_001
MANY = f"Lot --> split(x) {{ ~1 : R{NUM - 2} | ~1 : R5 }}\n" + "\n".join(f"R{i} --> Leaf." for i in range(NUM - 1))
WIDE = "Lot --> extrude(1) " + "Part " * NUM + "\nPart --> NIL"
DRAWN = "Lot --> " + "t(p(0.5), p(0.5), p(0.5)) " * (NUM // 3 + 1) + "Leaf."


@pytest.fixture(scope="module")
def many():
    return Grammar.parse(MANY)


@takes_turns
def test_rules_beyond_16_bits_are_told_apart_everywhere(many, tmp_path):
    forest = derive(many, 2, 1)
    assert {forest.rules[rule].symbol for rule in forest.nodes.rule if rule >= 0} == {"Lot", f"R{NUM - 2}", "R5"}
    assert {column.dtype for column in (forest.nodes.symbol, forest.nodes.rule, forest.nodes.child)} == {
        np.dtype(np.int32)
    }
    patterns = [parse(f"R{NUM - 2} > Leaf."), parse(f"R{NUM - 3}"), parse("Lot > Leaf.")]
    assert count(join_forests([forest, forest]), patterns).tolist() == [[1.0, 0.0, 0.0]] * 4
    save_forest(forest, tmp_path / "d")
    assert_same(load_forest(tmp_path / "d"), forest)


def test_successors_beyond_16_bits_keep_their_number():
    forest = derive(Grammar.parse(WIDE), 1, 1)
    assert forest.nodes.child.tolist() == [0, *range(NUM)]


@takes_turns
def test_random_expressions_beyond_16_bits_keep_their_number():
    forest = derive(Grammar.parse(DRAWN), 1, 1)
    assert forest.draws.site.tolist() == list(range(len(forest.sites)))
    assert len(forest.sites) > NUM


def test_few_rules_have_narrow_columns():
    forest = derive(Grammar.parse("Lot --> 50% : A else : B"), 3, 1)
    nodes, draws = forest.nodes, forest.draws
    assert {c.dtype for c in (nodes.symbol, nodes.rule, nodes.child, draws.site)} == {np.dtype(np.int16)}


@takes_turns
def test_the_command_line_samples_them(tmp_path):
    path = tmp_path / "many.cga"
    path.write_text(MANY)
    sampled = invoke("sample", path, "-n", 2, "-o", tmp_path / "out", "--no-image")
    assert sampled.exit_code == 0, sampled.output
    assert load_forest(tmp_path / "out" / "derivations" / "00000").nodes.rule.max() == NUM - 1


def test_more_words_than_a_rule_file_may_have_are_refused(tmp_path):
    path = tmp_path / "more.cga"
    path.write_text(MANY.replace("Leaf.", "extrude(1) t(0, 1, 0) Leaf."))
    refused = invoke("sample", path, "-o", tmp_path / "out", "--no-image")
    assert refused.exit_code == 1
    assert "too many words" in refused.output
    assert "Traceback" not in refused.output
