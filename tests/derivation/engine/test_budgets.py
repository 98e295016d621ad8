"""Careless and hostile grammars end in an error that names the place, and soon."""

from __future__ import annotations

import gc
import re

import numpy as np
import pytest

from grammarlab.derivation import Budget, derive
from grammarlab.derivation.state.workspace import Workspace
from grammarlab.errors import BudgetError, DerivationError, UsageError
from grammarlab.language.grammar import Grammar

SMALL = Budget(shapes=5_000, depth=100)


def sample(text: str, **options):
    return derive(Grammar.parse(text), 2, seed=1, budget=SMALL, **options)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Lot --> t(0, 1, 0) Lot", "Lot call themselves more than 100 times in model 0 of seed 1"),
        ("Lot --> A\nA --> B\nB --> 50% : A else : A", "A -> B call themselves"),
        ("Lot --> Lot Lot", "model 0 of seed 1 has more than 5000 shapes after the rule Lot"),
        ("Lot --> split(x) { { 0.0001 : A }* }", r"<text>:1:9: one operation would make 400000 parts of 2 shapes"),
        ("Lot --> split(x) { { 0.001 : split(z) { { 0.01 : A }* } }* }", "parts of"),
        ("attr h = h + 1\nLot --> extrude(h) A", r"<text>:1:6: the value of h depends on itself: h -> h"),
        ("f(n) = f(n + 1)\nLot --> extrude(f(1)) A", "f calls itself"),
    ],
)
def test_what_never_ends_is_stopped(text, message):
    with pytest.raises(DerivationError, match=message):
        sample(text)


def test_the_budget_is_for_each_model_not_for_the_batch():
    text = "Lot --> split(x) { { 0.1 : A }* }"
    forest = derive(Grammar.parse(text), 100, seed=1, budget=Budget(shapes=300))
    assert forest.shapes_per_model().tolist() == [201] * 100


def test_the_budget_is_that_of_the_largest_model_however_often_nodes_are_counted():
    grammar = Grammar.parse(
        "Lot --> Step(0) Step(n) --> case n < 12 : 50% : A Step(n + 1) else : A A A Step(n + 1) else : NIL"
    )
    counts = derive(grammar, 40, seed=1).shapes_per_model()
    largest = int(counts.max())
    assert len(derive(grammar, 40, seed=1, budget=Budget(shapes=largest)).nodes) == counts.sum()
    with pytest.raises(BudgetError, match=f"model {counts.argmax()} of seed 1 has more than {largest - 1} shapes"):
        derive(grammar, 40, seed=1, budget=Budget(shapes=largest - 1))


@pytest.mark.parametrize("value", ["0 / 0", "1 / 0", "-(1 / 0)", 'float("abc")'])
@pytest.mark.parametrize("operation", ["t(f, 0, 0)", "s(f, 1, 1)", "r(0, f, 0)", "extrude(f)", "split(x) { f : A }"])
def test_numbers_that_are_not_finite_count_as_zero_with_a_warning_at_their_place(operation, value):
    forest = sample(f"f = {value}\nLot --> {operation}")
    (warning,) = forest.warnings
    assert re.fullmatch(r"\w+ expected a finite number, found (nan|-?inf); 0 is used", warning.message)
    assert (warning.location.line, warning.location.column) == (2, 9)
    with_zero = sample(f"f = 0\nLot --> {operation}")
    assert np.array_equal(forest.leaves.size, with_zero.leaves.size)
    assert np.array_equal(forest.leaves.position, with_zero.leaves.position)


def test_a_split_of_nothing_makes_nothing():
    forest = sample("Lot --> s(0, 0, 0) split(x) { ~1 : A | 2 : B | { 1 : C }* } D")
    assert [forest.symbols[s] for s in forest.nodes.symbol] == ["Lot", "Lot", "D", "D"]


def test_negative_sizes_in_a_split_are_left_out():
    forest = sample("Lot --> split(x) { -3 : A | ~1 : B }")
    assert set(forest.nodes.symbol[2:]) == {forest.symbols.index("B")}


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ("-10% : A else : B", "finite percentages of at least 0, found -10"),
        ("0% : A 0% : B", "a percentage above 0, found only 0"),
        ("(1e308 * 10)% : A 1% : B", "finite percentages of at least 0, found inf"),
        ("(0 / 0)% : A else : B", "finite percentages of at least 0, found nan"),
        ("(scope.sx - 20)% : A (-1)% : B", "finite percentages of at least 0, found -"),
    ],
)
def test_impossible_percentages_are_refused_with_the_value(weights, message):
    with pytest.raises(DerivationError, match=message):
        sample(f"Lot --> {weights}")


@pytest.mark.parametrize("largest", ["1e308", "1e308 + scope.sx"])
def test_percentages_whose_sum_overflows_keep_their_ratios(largest):
    small, large = (
        derive(Grammar.parse(f"Lot --> ({weight})% : A (({weight}) / 3)% : B ({weight})% : C"), 60, seed=4)
        for weight in ("30", largest)
    )
    np.testing.assert_array_equal(small.nodes.symbol, large.nodes.symbol)
    np.testing.assert_allclose(small.log_probability(), large.log_probability(), rtol=1e-12)


def test_an_unknown_attribute_is_a_usage_error():
    with pytest.raises(UsageError, match="unknown attribute hight; expected one of height"):
        sample("attr height = 3\nLot --> extrude(height)", attributes={"hight": 2.0})


def test_an_unknown_start_rule_is_a_usage_error():
    with pytest.raises(UsageError, match="unknown start rule Roof; expected a rule without parameters: Lot"):
        sample("Lot --> A\nRoof(x) --> A", start_rule="Roof")


def test_attributes_and_start_rules_can_be_given():
    forest = sample("attr h = rand(1, 2)\nLot --> A\nTower --> extrude(h) A", attributes={"h": 7.0}, start_rule="Tower")
    assert np.array_equal(forest.leaves.size[:, 1], [7.0, 7.0])
    assert len(forest.draws.node) == 0


def test_errors_of_budgets_are_errors_of_derivations():
    assert issubclass(BudgetError, DerivationError)


def test_assets_outside_their_folder_are_refused(tmp_path):
    (tmp_path / "assets").mkdir()
    (tmp_path / "secret.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(DerivationError, match="lies outside the asset folder"):
        sample('Lot --> i("../secret.obj")', assets=tmp_path / "assets")


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [("broken.glb", b"glTF" + bytes(40), "cannot be read"), ("tree.fbx", b"Kaydara", "export it as OBJ or GLB")],
)
def test_a_box_stands_for_an_asset_that_cannot_be_read(tmp_path, name, content, reason):
    (tmp_path / name).write_bytes(content)
    rules = f'Lot --> s(2, 3, 4) i("{name}") A i("{name}") B'
    forest, boxes = sample(rules, assets=tmp_path), sample(rules.replace(name, "builtin:cube"))
    assert forest.leaves.size.tolist() == boxes.leaves.size.tolist()
    (bad,) = forest.missing_assets
    assert (bad.path, bad.location.line, bad.location.column) == (name, 1, 20)
    assert name in bad.reason
    assert reason in bad.reason


def test_a_box_stands_for_an_unknown_built_in_mesh():
    forest, boxes = sample('Lot --> i("builtin:cube.obj") A'), sample('Lot --> i("builtin:cube") A')
    assert forest.leaves.size.tolist() == boxes.leaves.size.tolist()
    assert ["builtin:cube.obj" in finding.message for finding in forest.warnings] == [True]


def test_an_attribute_of_a_file_that_was_not_read_is_not_set():
    forest = sample('import Tree : "absent.cga"\nLot --> set(Tree.name, "oak") extrude(3) A')
    assert forest.leaves.size[:, 1].tolist() == [3.0, 3.0]
    assert ["Tree.name is not set" in finding.message for finding in forest.warnings] == [True]
    with pytest.raises(DerivationError, match=r"scop\.sx cannot be set"):
        sample('import Tree : "absent.cga"\nLot --> set(scop.sx, 3) A')


def test_nothing_of_a_derivation_waits_for_the_collector_of_cycles():
    grammar = Grammar.parse("Lot --> 50%: extrude(rand(3, 9)) Tower else: inline(Tower)")
    gc.collect()
    gc.disable()
    try:
        derive(grammar, 4, seed=1)
        assert not any(isinstance(value, Workspace) for value in gc.get_objects())
    finally:
        gc.enable()
