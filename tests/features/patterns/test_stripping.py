"""Forests without geometry: the same features, and nothing of the geometry kept in memory."""

from pathlib import Path

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.derivation.derive import derive_chunks
from grammarlab.features.columns.vocabulary import extract
from grammarlab.features.patterns.tree_index import without_geometry
from grammarlab.language.grammar import Grammar
from tests.oracle.comparison import assert_same_records

GRAMMARS = Path(__file__).parents[3] / "grammars"


def test_features_are_the_same_and_no_row_of_a_leaf_is_kept():
    grammar = Grammar.parse((GRAMMARS / "toy.cga").read_text())
    forest = derive(grammar, 50, seed=1, assets=GRAMMARS / "assets")
    stripped = without_geometry(forest)
    one, other = extract([forest]), extract([stripped])
    assert one.names == other.names
    assert np.array_equal(one.rows(), other.rows())
    assert len(forest.leaves) > 0
    assert len(stripped.leaves) == len(stripped.meshes) == len(stripped.reports.value) == 0
    assert stripped.leaves.position.base is None


QUERIES = """
Lot --> split(x) { ~1 : A | ~1 : B }
A --> 50% : B else : t(rand(9), 0, 0) B
B --> case overlaps() : C else : D
"""
EDITED = """
Lot --> extrude(4) modify(f) { top : Cap } comp(f) { top : Top | side : Wall }
Cap --> 50% : s('0.5, '0.5, '1) X. else : X.
Wall --> report("area", geometry.area)
"""


@pytest.mark.parametrize(
    "text", [(GRAMMARS / "toy.cga").read_text(), QUERIES, EDITED], ids=["shipped", "queries", "edited"]
)
def test_derivations_without_leaves_have_the_same_trees(text):
    grammar = Grammar.parse(text)
    whole = derive(grammar, 20, seed=1, assets=GRAMMARS / "assets")
    (bare,) = derive_chunks(grammar, 20, 1, assets=GRAMMARS / "assets", leaves=False)
    assert len(whole.leaves) > 0
    assert len(bare.leaves) == 0
    assert_same_records(whole, bare)
