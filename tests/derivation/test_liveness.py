"""Derivations without leaves: operations that only leaves show are left out, and everything else is the same."""

from __future__ import annotations

import pytest

from grammarlab.derivation import derive
from grammarlab.derivation.derive import derive_chunks
from grammarlab.errors import DerivationError
from grammarlab.language.grammar import Grammar
from tests.derivation.engine.test_every_feature import SEQUENCES
from tests.oracle.comparison import assert_same_records

READERS = (
    "scope.sx + 3 * scope.sy + 7 * scope.sz",
    "scope.tx + 3 * scope.ry + material.color.r + split.index",
)
"""Properties on which no other ones depend, and others; everything else is dead."""
HEAD = "attr height = 3\nWall(x) --> extrude(x) A\nWall(x, y) --> extrude(x + y) B\n"


def test_whatever_is_read_after_an_operation_is_the_same_without_leaves():
    bodies = [f"extrude(2) r(5, 20, 30) {sequence} " for sequence in SEQUENCES if not sequence.startswith("case")]
    rules = [f'R{i}_{k} --> {body} report("{i}", {READERS[k]})' for i, body in enumerate(bodies) for k in (0, 1)]
    rules += [
        f"P{i} --> {body} comp(f) {{ top : T. | side : split(x) {{ ~1 : S. }}* }}" for i, body in enumerate(bodies)
    ]
    names = " ".join(rule.partition(" ")[0] for rule in rules)
    grammar = Grammar.parse("\n".join([HEAD, "@StartRule\nLot --> " + names, *rules]))
    assert_same_records(*(derive(grammar, 1, 1, footprint=(12.0, 8.0), leaves=leaves) for leaves in (True, False)))


@pytest.mark.parametrize(
    ("text", "num_missing"),
    [
        ('Lot --> extrude(3) [ s(1, 1, 1) i("none.obj") A. ] B', 0),
        ('Lot --> A A --> case split.index > 3 : color("x") i("none.obj") else : i("none.obj") B B --> Leaf.', 0),
        ('Lot --> i("none.obj") comp(f) { top : T. }', 1),
        ('Lot --> i("none.obj") A A --> B B --> case scope.sx > 2 : S. else : A', 1),
        ('Lot --> [ i("none.obj") report("a", 3) ] A.', 0),
        ('Lot --> [ i("none.obj") report("a", scope.sx) ] A.', 1),
        ('Lot --> inline(append) A comp(f) { all : F. } A --> i("none.obj")', 1),
    ],
)
def test_an_operation_whose_result_nothing_reads_is_left_out(tmp_path, text, num_missing):
    text = text.replace(" A -->", "\nA -->").replace(" B -->", "\nB -->")
    forests = [derive(Grammar.parse(text), 2, 1, assets=tmp_path, leaves=leaves) for leaves in (True, False)]
    assert_same_records(*forests)
    assert [len(forest.missing_assets) for forest in forests] == [1, num_missing]


def test_operations_that_are_left_out_still_draw_and_print():
    grammar = Grammar.parse(
        """
        Lot --> s(2, 3, 4) color(f(1)) [ t(rand(g), 0, 0) A ] s(print(rand(3)), 1, 1) B.
        f(x) = 40% : "#ff0000" else : "#00ff00"
        g = scope.sy
        """
    )
    whole, bare = (derive(grammar, 5, 1, leaves=leaves) for leaves in (True, False))
    assert_same_records(whole, bare)
    assert bare.prints == whole.prints
    assert len(bare.draws.node) == 15


def test_indices_are_there_for_operations_that_only_leaves_show():
    grammar = Grammar.parse(
        "Lot --> split(x) { ~2 : A }* A --> t(0, split.index, 0) Leaf.".replace(" A -->", "\nA -->")
    )
    forest = derive(grammar, 1, 1, footprint=(6.0, 2.0))
    assert forest.leaves.position[:, 1].tolist() == [0.0, 1.0, 2.0]


def test_parts_of_a_block_may_need_geometry_or_not():
    text = """
    Lot --> extrude(6) split(y) { 1 : A | { ~2 : B }* | 1 : X. } comp(f) { top : B | side = C | all =: A }
    A --> color("#102030") Leaf
    B --> case split.index % 2 == 0 : split(x) { 2 : A | ~1 : C }* else : 50% : A else : B2
    B2 --> report("size", scope.sy) A
    C --> comp(e) { all : A }
    """
    whole, bare = (derive(Grammar.parse(text), 9, 1, leaves=leaves) for leaves in (True, False))
    assert_same_records(whole, bare)
    assert len(bare.leaves) == 0


def test_errors_of_operations_that_are_carried_out_are_raised():
    with pytest.raises(DerivationError, match="expects true or false"):
        derive(Grammar.parse("Lot --> roofHip(30, 1, 3) comp(f) { all : A }"), 1, 1, leaves=False)
    forest = derive(Grammar.parse("Lot --> roofHip(30, 1, 3) A"), 2, 1, leaves=False)
    assert forest.nodes.model.tolist() == [0, 1, 0, 1]


def test_chunks_without_leaves_have_twice_as_many_nodes():
    grammar = Grammar.parse("Lot --> split(x) { 5 : A. }*")
    sizes = [
        [
            forest.num_models
            for forest in derive_chunks(grammar, 72, 1, footprint=(20.0, 5.0), nodes_per_chunk=50, leaves=leaves)
        ]
        for leaves in (True, False)
    ]
    assert sizes == [[32, 10, 10, 10, 10], [32, 20, 20]]
