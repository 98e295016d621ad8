"""A forest without models goes everywhere that other forests go."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation.derive import derive, derive_chunks
from grammarlab.derivation.selection import join_forests
from grammarlab.errors import UsageError
from grammarlab.features.patterns.counts import count
from grammarlab.features.patterns.pattern_text import parse
from grammarlab.language.grammar import Grammar
from grammarlab.runs.sample.derivations import load_forest, save_forest
from grammarlab.runs.sample.shipped import shipped_examples
from grammarlab.scene import realize, triangles

SOURCES = {source.name: source for source in shipped_examples()}


@pytest.mark.parametrize("name", SOURCES)
def test_no_models_of_a_shipped_grammar_are_an_empty_forest_everywhere(name, tmp_path):
    forest = derive(Grammar.parse(SOURCES[name].text()), 0, seed=3, assets=SOURCES[name].assets)
    assert forest.num_models == len(forest.nodes) == len(forest.leaves) == len(forest.draws.node) == 0
    assert forest.log_probability().shape == forest.shapes_per_model().shape == (0,)
    assert count(forest, [parse(forest.symbols[0]), parse("A > B")]).shape == (0, 2)
    assert triangles(realize(forest)).triangles_per_model().shape == (0,)
    save_forest(forest, tmp_path)
    loaded = load_forest(tmp_path)
    assert (loaded.num_models, loaded.symbols, loaded.rules) == (0, forest.symbols, forest.rules)


RECURSIVE = """
attr height = deep(rand(2, 4))
deep(n) = case n > 1 : deep(n - 1) else : n
Lot --> 50% : s('1, height, '1) A else : extrude(height) comp(f) { all : A }
A --> 30% : A else : t(0, -1, 0) B
"""


def test_nothing_is_carried_out_for_no_models():
    forest = derive(Grammar.parse(RECURSIVE), 0, seed=1)
    some = derive(Grammar.parse(RECURSIVE), 3, seed=1)
    joined = join_forests([forest, some])
    np.testing.assert_array_equal(joined.log_probability(), some.log_probability())
    assert list(derive_chunks(Grammar.parse(RECURSIVE), 0, seed=1)) == []


def test_a_negative_number_of_models_is_refused():
    with pytest.raises(UsageError, match="expected 0 models or more, found -1"):
        derive(Grammar.parse("Lot --> A"), -1, seed=1)
