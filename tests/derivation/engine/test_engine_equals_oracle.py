"""The columnar engine against the plain interpreter: equal forests, shape by shape."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import derive
from grammarlab.language.grammar import Grammar
from grammarlab.language.importing import load
from tests.cases import bulk
from tests.oracle.comparison import assert_same_records, assert_same_trees, tree_of_model, trees_of_forest
from tests.oracle.interpreter import interpret
from tests.oracle.shape import Mesh
from tests.oracle.strategies import rule_files
from tests.whole_grammars import WHOLE

GRAMMARS = WHOLE
ASSETS = AssetFolder(GRAMMARS[0].parent / "assets")


def asset(name: str) -> Mesh:
    return Mesh.from_columns(ASSETS.load(name).meshes)


def test_there_are_example_grammars():
    assert {path.stem for path in GRAMMARS} >= {"toy", "furniture", "building", "skyscraper", "airplane"}


@pytest.mark.parametrize("path", GRAMMARS, ids=lambda path: path.stem)
@pytest.mark.parametrize("seed", [0, 7])
def test_example_grammars_derive_as_the_oracle_says(path, seed):
    grammar = load(path)
    forest = derive(grammar, 2, seed, assets=ASSETS)
    for index, tree in enumerate(trees_of_forest(forest)):
        model = interpret(grammar, seed, index, assets=asset)
        assert_same_trees(tree, tree_of_model(model, grammar))
        log_probability = sum(draw.log_density for draw in model.draws)
        assert forest.log_probability()[index] == pytest.approx(log_probability, rel=1e-12, abs=1e-12)


@given(rule_files())
@bulk(45, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
def test_random_grammars_derive_as_the_oracle_says(text):
    grammar = Grammar.parse(text)
    forest = derive(grammar, 3, 11, footprint=(8.0, 6.0))
    for index, tree in enumerate(trees_of_forest(forest)):
        model = interpret(grammar, 11, index, footprint=(8.0, 6.0))
        assert_same_trees(tree, tree_of_model(model, grammar), exact_draws=False)
    assert_same_records(forest, derive(grammar, 3, 11, footprint=(8.0, 6.0), leaves=False))


@pytest.mark.parametrize(
    "text",
    [
        """Lot with (h := rand(3, 9)  n := rint(h / 2)) --> extrude(h) split(y) { ~n : Part(n) }*
           Part(a) with (b := a + rand(a)) --> 50% : s(b, '1, '1) A else : B(b)  B(c) --> t(c, 0, 0) C""",
        """attr a with (x := rand(2)  y := x * x) = x + y
           f(z) with (w := rand(z)) = w * w
           Lot --> extrude(a + f(3) + f(1)) A""",
    ],
)
def test_local_variables_are_evaluated_once_in_order(text):
    grammar = Grammar.parse(text)
    for index, tree in enumerate(trees_of_forest(derive(grammar, 3, 5))):
        assert_same_trees(tree, tree_of_model(interpret(grammar, 5, index), grammar))
