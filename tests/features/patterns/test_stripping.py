"""Forests without geometry: the same features, and nothing of the geometry kept in memory."""

from pathlib import Path

import numpy as np

from grammarlab.derivation import derive
from grammarlab.features.columns.vocabulary import extract
from grammarlab.features.patterns.tree_index import without_geometry
from grammarlab.language.grammar import Grammar

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
