"""Shapes derived at once: ``inline``, ``union``, ``subtract`` and ``intersect``."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.derivation.state.mesh_table import scaled
from grammarlab.errors import BudgetError
from grammarlab.geometry.meshes.booleans import Operation, combined
from grammarlab.geometry.meshes.edges import is_closed_surface
from grammarlab.geometry.meshes.measure import areas, face_areas, volumes
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import box
from grammarlab.language.grammar import Grammar
from tests.cases import bulk

HALVES = "A --> X  B --> t(0, 1, 0) Y"


def geometry(forest) -> Meshes:
    return scaled(forest.meshes.take(forest.leaves.mesh), forest.leaves.size)


def volume_of(text: str, **options) -> float:
    return float(volumes(geometry(derive(Grammar.parse(text), 1, 1, footprint=(4.0, 4.0), **options))).sum())


def cuboid(low, size) -> Meshes:
    mesh = box()
    return mesh.with_points(np.array(low, float) + mesh.points * np.array(size, float))


@given(st.lists(st.integers(0, 6), min_size=6, max_size=6), st.lists(st.integers(1, 4), min_size=6, max_size=6))
@bulk(40)
def test_boolean_operations_on_boxes_count_their_unit_cubes(lows, sizes):
    def cells(low, size):
        ranges = [range(a, a + b) for a, b in zip(low, size, strict=True)]
        return {(x, y, z) for x in ranges[0] for y in ranges[1] for z in ranges[2]}

    first, second = (cells(lows[i : i + 3], sizes[i : i + 3]) for i in (0, 3))
    boxes = [cuboid(lows[i : i + 3], sizes[i : i + 3]) for i in (0, 3)]
    expected_cells: dict[Operation, set] = {
        "union": first | second,
        "subtract": first - second,
        "intersect": first & second,
    }
    for operation, expected in expected_cells.items():
        result = combined(boxes, 1, operation)
        assert result is not None
        assert volumes(result.mesh)[0] == pytest.approx(len(expected), abs=1e-9)


def test_a_tunnel_is_a_face_with_a_hole_on_both_sides():
    result = combined([cuboid([0, 0, 0], [4, 4, 4]), cuboid([1, 1, -1], [2, 2, 6])], 1, "subtract")
    assert result is not None
    mesh = result.mesh
    assert mesh.num_faces == 10
    assert result.source.tolist() == [0] * 6 + [1] * 4
    assert areas(mesh)[0] == pytest.approx(96.0 - 8.0 + 32.0)
    assert is_closed_surface(mesh)[0]


def test_faces_that_meet_stay_closed_where_a_corner_lies_on_an_edge():
    result = combined([cuboid([0, 0, 0], [4, 4, 4]), cuboid([4, 0, 0], [2, 2, 2])], 1, "union")
    assert result is not None
    assert is_closed_surface(result.mesh)[0]
    assert Counter(result.source.tolist()) == {0: 6, 1: 5}  # edges between flat faces of two solids stay


def test_inlined_shapes_become_the_current_shape():
    forest = derive(Grammar.parse(f"Lot --> inline split(x) {{ '0.5 : A | ~1 : B }} extrude(2) C {HALVES}"), 2, 1)
    names = [forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]]
    assert names == ["C", "C"]
    assert volumes(geometry(forest)).tolist() == pytest.approx([20.0 * 20.0 * 2.0] * 2)


def test_a_single_inlined_shape_is_taken_as_it_is():
    text = 'Lot --> inline R report("y", scope.sy) C  R --> 50% : extrude(5) color("#ff0000") X else : extrude(2) X'
    forest = derive(Grammar.parse(text), 20, 1)
    assert set(forest.reports.value.tolist()) == {5.0, 2.0}
    red = forest.materials.channels[forest.leaves.material, 1] == 0.0
    assert (red == (forest.leaves.size[:, 1] == 5.0)).all()


@pytest.mark.parametrize(("strategy", "volume"), [("append", 96.0), ("unify", 72.0)])
def test_overlapping_shapes_are_appended_or_unified(strategy, volume):
    text = f"Lot --> extrude(4) inline({strategy}) {{ P Q }} R  P --> s('1, '1, '0.75) X  Q --> s('0.75, '1, '1) Y"
    expected = volume if strategy == "append" else 64.0 - 4.0
    assert volume_of(text) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("operation", "volume"),
    [("union", 64 + 64 - 16), ("subtract", 64 - 16), ("intersect", 16), ("subtract(swap)", 32 - 16)],
)
def test_boolean_operations_of_the_current_shape_and_a_rule(operation, volume):
    moved = "t(2, 0, 2)" + (" s('1, '0.5, '1)" if "swap" in operation else "")
    volume = volume if "swap" not in operation else 4 * 2 * 4 - 2 * 2 * 2
    assert volume_of(f"Lot --> extrude(4) {operation} Q R  Q --> {moved} Y") == pytest.approx(volume)
    assert volume_of(f"Lot --> extrude(4) {operation} {{ {moved} Y }} R") == pytest.approx(volume)


@pytest.mark.parametrize("operation", ["union", "subtract", "intersect"])
@pytest.mark.parametrize("order", ["A. | Q", "Q | A."])
def test_two_operands_are_as_the_current_shape_and_a_rule(operation, order):
    rules = "Q --> [ t(2, 0, 2) s('1, '0.5, '1) Y ] t(1, 0, 1) s('1, '0.5, '1) Y"
    swap = "" if order.startswith("A") else "(swap)"
    of_two = volume_of(f"Lot --> extrude(4) {operation} {{ {order} }} R\n{rules}")
    assert of_two == pytest.approx(volume_of(f"Lot --> extrude(4) {operation}{swap} Q R\n{rules}"))


@pytest.mark.parametrize(("operands", "area"), [("s('0.5, '1, '1) A | B", 12), ("B | s('0.5, '1, '1) A", 12)])
def test_both_operands_are_made_of_the_current_shape_and_the_first_has_the_material(operands, area):
    text = f"""Lot --> union {{ {operands} }} comp(f) {{ isTagged("bool.A") : First | all : Second }}
               A --> color("#ff0000") X  B --> color("#0000ff") t(1, 0, 0) s(2, 0, '1) X"""
    forest = derive(Grammar.parse(text), 1, 1, footprint=(4.0, 4.0))
    names = [forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]]
    colors = forest.materials.color[forest.leaves.material]
    first = [1.0, 0.0, 0.0] if operands.endswith("B") else [0.0, 0.0, 1.0]
    assert {tuple(color) for color, name in zip(colors.tolist(), names, strict=True) if name == "First"} == {(*first,)}
    assert areas(geometry(forest)).sum() == pytest.approx(area)


def test_the_only_shape_of_the_first_operand_gives_the_result_its_attributes_and_scope():
    text = """attr a = 1
              attr text = "none"
              Lot --> extrude(4) split(x) { 1 : Block(1) | ~1 : Block(2) }
              Block(n) --> union { Wide(n) | set(a, 9) t(1, 0, 1) B. } Rep
              Wide(n) --> case n == 1 : set(a, 5) set(text, "one") r(0, 90, 0) A.
                          else : set(a, 6) split(y) { '0.5 : A. | ~1 : A. }
              Rep --> s(a, a, a) print(text + rint(scope.ry + 1)) R."""
    forest = derive(Grammar.parse(text), 1, 1, footprint=(4.0, 4.0))
    assert forest.leaves.size.tolist() == [[5.0] * 3, [1.0] * 3]
    assert forest.prints == ("one91", "none1")


@pytest.mark.parametrize(("operation", "faces"), [("union", [8, 8, 12, 16]), ("subtract", [8]), ("intersect", [8])])
def test_boolean_operations_in_a_plane_keep_all_edges(operation, faces):
    mesh = geometry(derive(Grammar.parse(f"Lot --> {operation} {{ t(2, 0, 2) Y }} R"), 1, 1, footprint=(4.0, 4.0)))
    expected = {"union": [4.0, 12.0, 12.0], "subtract": [12.0], "intersect": [4.0]}[operation]
    assert sorted(face_areas(mesh).tolist()) == pytest.approx(expected)


def test_a_frame_in_a_plane_has_a_hole():
    mesh = geometry(derive(Grammar.parse("Lot --> subtract { s('0.5, 0, '0.5) center(xz) Y } R"), 1, 1))
    assert mesh.num_faces == 1
    assert areas(mesh)[0] == pytest.approx(300.0)


def test_faces_keep_the_materials_and_tags_of_their_operand():
    red, blue = 'color("#ff0000")', 'color("#0000ff")'
    text = f"""Lot --> {red} extrude(4) subtract {{ {blue} tag("hole") t(1, 1, 1) s(2, 9, 2) Y }}
               comp(f) {{ isTagged("hole") && isTagged("bool.B") : H | isTagged("bool.A") : A }}"""
    forest = derive(Grammar.parse(text), 1, 1, footprint=(4.0, 4.0))
    names = [forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]]
    colors = forest.materials.color[forest.leaves.material].tolist()
    expected = {"A": [1.0, 0.0, 0.0], "H": [0.0, 0.0, 1.0]}
    assert colors == [expected[name] for name in names]
    assert Counter(names) == {"A": 6, "H": 5}


def test_inlined_leaves_keep_their_materials():
    halves = 'split(x) { ~1 : color("#ff0000") X | ~1 : color("#0000ff") Y }'
    forest = derive(Grammar.parse(f"Lot --> extrude(4) inline {{ {halves} }} R"), 1, 1)
    parts = areas(geometry(forest)).tolist()
    assert forest.materials.color[forest.leaves.material].tolist() == [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    assert parts == pytest.approx([2 * (10 * 20 + 10 * 4 + 20 * 4)] * 2)


def test_what_is_not_closed_stays_with_a_warning():
    forest = derive(Grammar.parse("Lot --> extrude(2) subtract { comp(f) { side = Y } } R"), 1, 1)
    assert [warning.message for warning in forest.warnings] == [
        "subtract expects closed geometry; what is not closed stays as it is"
    ]
    assert areas(geometry(forest)).sum() == pytest.approx(800.0 + 160.0)


def test_a_model_with_inlined_chance_does_not_depend_on_its_batch():
    text = """Lot --> extrude(rand(2, 5)) inline { split(x) { ~rand(1, 3) : Part }* } comp(f) { all : F }
              Part --> 30% : NIL else : s('1, '(rand(1)), '1) X"""
    batch = derive(Grammar.parse(text), 4, 3)
    alone = derive(Grammar.parse(text), 1, 3, first_model=2)
    rows = batch.nodes.model[batch.leaves.node] == 2
    assert np.array_equal(batch.leaves.position[rows], alone.leaves.position)
    assert np.array_equal(batch.leaves.size[rows], alone.leaves.size)


def test_rules_that_inline_themselves_end():
    with pytest.raises(BudgetError, match="contain each other"):
        derive(Grammar.parse("Lot --> inline Lot A"), 1, 1)


@pytest.mark.parametrize("body", ["intersect { NIL }", "inline { NIL }", "inline { NIL } union { NIL }"])
def test_nothing_is_left_of_nothing(body):
    forest = derive(Grammar.parse(f"Lot --> {body} A"), 2, 1)
    assert len(forest.leaves) == 0
