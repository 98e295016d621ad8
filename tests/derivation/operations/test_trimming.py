"""Trim planes: what is inserted on a face ends halfway to the next face. Another runtime measured the numbers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.geometry.meshes.measure import areas
from grammarlab.language.grammar import Grammar
from tests.cases import bulk
from tests.derivation.operations.leaves import L_SHAPE, sampled, world_meshes
from tests.oracle.comparison import assert_same_trees, tree_of_model, trees_of_forest
from tests.oracle.interpreter import interpret

RECTANGLE = np.array([[0.0, 0, 0], [0, 0, 20], [30, 0, 20], [30, 0, 0]])
WIDER = "s('1.2, '1.2, 2) center(xy)"


def measured(rules: str, footprint: np.ndarray) -> tuple[int, int, float]:
    """Leaves, polygons and square metres."""
    meshes = world_meshes(sampled(rules, footprint))
    return len(meshes), meshes.num_faces, float(areas(meshes).sum())


@pytest.mark.parametrize(
    ("rules", "footprint", "expected"),
    [
        (f'Lot --> extrude(5) comp(f) {{ side : {WIDER} i("builtin:cube") A. }}', RECTANGLE, (4, 16, 1728.0)),
        (f"Lot --> extrude(5) comp(f) {{ side : {WIDER} primitiveCube() A. }}", L_SHAPE, (6, 30, 1660.2)),
        ("Lot --> roofHip(30) comp(f) { aslant : s('1, '1, 1) primitiveCube() A. }", RECTANGLE, (4, 24, 1554.984)),
        ("Lot --> roofHip(30) comp(f) { aslant : extrude(1) trim() A. }", L_SHAPE, (6, 34, 1376.597)),
        (
            "Lot --> extrude(5) comp(f) { 2 : set(trim.horizontal, true) s(30, 8, 1) center(xy) primitiveCube() A. }",
            RECTANGLE,
            (1, 2, 254.0),
        ),
        (
            "Lot --> extrude(5) comp(f) { 2 : split(x) { 10 : s(30, 5, 1) primitiveCube() A. | ~1 : NIL } }",
            RECTANGLE,
            (1, 5, 251.0),
        ),
        (
            "Lot --> extrude(5) comp(f) { 2 : s(30, 5, 1) center(xy) primitiveCube() s(40, 5, 1) A. }",
            RECTANGLE,
            (1, 4, 458.18),
        ),
        (
            "Lot --> extrude(5) comp(f) { 2 : alignScopeToAxes(y) s(5, 5, 30) center(xz) primitiveCube() A. }",
            RECTANGLE,
            (1, 5, 487.5),
        ),
        ("Lot --> extrude(5) comp(f) { 2 = s(30, 5, 1) center(xy) primitiveCube() A. }", RECTANGLE, (1, 6, 370.0)),
        (
            "Lot --> extrude(5) comp(f) { 2 : s(30, 5, 1) center(xy) comp(f) { all : primitiveCube() A. } }",
            RECTANGLE,
            (1, 6, 1525.0),
        ),
        ("Lot --> extrude(5) comp(e) { all : s(40, 1, 1) center(x) primitiveCube() A. }", RECTANGLE, (12, 72, 1944.0)),
    ],
)
def test_inserted_meshes_end_where_the_runtime_ends_them(rules, footprint, expected):
    leaves, polygons, area = measured(rules, footprint)
    assert (leaves, polygons) == expected[:2]
    assert area == pytest.approx(expected[2], rel=1e-4)


@given(st.floats(0.1, 5.0), st.floats(1.0, 3.0))
@bulk(25)
def test_without_trim_planes_meshes_stay_whole(depth, wider):
    rules = """Lot --> extrude(5) comp(f) {{ side : {} s('{}, '1, {}) center(x) primitiveCube() A. }}"""
    switched_off = measured(rules.format("set(trim.vertical, false)", wider, depth), RECTANGLE)
    assert switched_off[1] == 24
    trimmed = measured(rules.format("", wider, depth), RECTANGLE)
    assert trimmed[2] <= switched_off[2] + 1e-9


WALLS = "Walls --> comp(f) {{ side : Wall }} Wall --> {} s('1.4, '1, 1) center(x) primitiveCube() A."


@pytest.mark.parametrize(
    ("start", "wall"),
    [
        ("set(trim.vertical, false) Walls", "set(trim.vertical, true)"),
        ("split(x) { ~1 : set(trim.vertical, false) Walls | ~2 : Walls }*", ""),
        ("split(x) { ~1 : set(trim.vertical, split.index > 0) Walls | ~2 : Walls }", "set(trim.horizontal, true)"),
        ("set(trim.horizontal, true) Walls", "50% : set(trim.vertical, false) Tall else : Tall Tall --> s('1, '2, '1)"),
        ("set(trim.vertical, false) Walls", "Part Part --> set(trim.horizontal, true) s('1, '2, '1)"),
    ],
)
def test_planes_apply_where_rules_switch_them_on_and_faces_keep_those_that_are_off(start, wall):
    grammar = Grammar.parse(f"Lot --> extrude(4) {start} {WALLS.format(wall)}")
    for index, tree in enumerate(trees_of_forest(derive(grammar, 3, 2, footprint=(8.0, 6.0)))):
        model = interpret(grammar, 2, index, footprint=(8.0, 6.0))
        assert_same_trees(tree, tree_of_model(model, grammar))


def test_switching_planes_off_changes_no_draw():
    rules = "Lot --> {} extrude(rand(3, 9)) B B --> 50% : A else : s(rand(4), 1, 1) C"
    plain, switched = (derive(Grammar.parse(rules.format(text)), 20, 3) for text in ("", "set(trim.vertical, false)"))
    assert plain.leaves.size.tobytes() == switched.leaves.size.tobytes()
