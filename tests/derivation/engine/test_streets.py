"""``street.front`` and its kin, and ``streetWidth``, on lots with known streets."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

from grammarlab.derivation import Forest, Lots, compile_grammar, derive
from grammarlab.derivation.lots import Footprints
from grammarlab.geometry.lot_sides import BACK, FRONT, LEFT, NO_SIDE, RIGHT, edge_sides
from grammarlab.language.grammar import Grammar
from tests.cases import bulk
from tests.derivation.engine.test_addressing import fingerprint
from tests.oracle.comparison import assert_same_trees, tree_of_model, trees_of_forest
from tests.oracle.interpreter import interpret
from tests.oracle.strategies import LOTS, street_files

WALLS = "{ street.front : Front. | street.back : Back. | street.left : Left. | street.right : Right. | all : Other. }"
NAMES = {FRONT: "Front.", BACK: "Back.", LEFT: "Left.", RIGHT: "Right."}
KNOWN = [lot for lot in LOTS if lot[1] is not None]
CORNER: dict[str, Any] = {"footprint": (12.0, 9.0), "street_width": [8.0, 6.0, 0.0, 0.0]}
ISLAND: dict[str, Any] = {"footprint": (30.0, 24.0), "street_width": [8.0, 8.0, 8.0, 8.0]}


def derived(text: str, **options) -> Forest:
    return derive(Grammar.parse(text), 1, 11, **options)


def places(forest: Forest) -> dict[str, list[list[float]]]:
    """Middles of the bounding boxes of leaves by symbol, rounded to 1 mm."""
    result: dict[str, list[list[float]]] = {}
    leaves = forest.leaves
    for node, position, size, frame in zip(leaves.node, leaves.position, leaves.size, leaves.frame, strict=True):
        middle = position + forest.frames[frame] @ size / 2
        result.setdefault(forest.symbols[forest.nodes.symbol[node]], []).append((np.round(middle, 3) + 0.0).tolist())
    return result


@given(street_files(), st.sampled_from(LOTS))
@bulk(60, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
def test_random_grammars_derive_on_lots_as_the_oracle_says(text, lot):
    footprint, widths = lot
    grammar = Grammar.parse(text)
    forest = derive(grammar, 2, 11, footprint=footprint, street_width=widths)
    for index, tree in enumerate(trees_of_forest(forest)):
        model = interpret(grammar, 11, index, footprint=footprint, street_width=widths)
        assert_same_trees(tree, tree_of_model(model, grammar), exact_draws=False)


@given(street_files(), st.permutations(LOTS))
@bulk(10, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
def test_lots_of_all_kinds_together_are_what_each_is_alone(text, order):
    _expect_each_as_alone(text, order)


def _expect_each_as_alone(text, order):
    grammar = Grammar.parse(text)
    lots = Lots.concatenate([Lots.of(1, 3, footprint=footprint, street_width=widths) for footprint, widths in order])
    together = derive(grammar, lots)
    for model, (footprint, widths) in enumerate(order):
        alone = derive(grammar, 1, 3, footprint=footprint, street_width=widths)
        assert fingerprint(together, model) == fingerprint(alone, 0)


def test_pieces_of_a_setback_are_the_same_beside_lots_with_courts():
    text = "Lot --> setback(0.4) { street.front = A. | remainder = A. }"
    _expect_each_as_alone(text, LOTS)


@pytest.mark.parametrize("lot", range(len(KNOWN)))
def test_a_wall_has_the_side_of_the_edge_that_it_was_extruded_from(lot):
    footprint, widths = KNOWN[lot]
    corners = Footprints.of([footprint]).points
    sides = edge_sides(corners[:, [0, 2]], np.array([0, len(corners)]), np.array(widths))
    expected: dict[str, list[list[float]]] = {}
    for side, start, end in zip(sides.tolist(), corners, np.roll(corners, -1, axis=0), strict=True):
        if side != NO_SIDE:
            middle = (start + end) / 2 + [0.0, 2.0, 0.0]
            expected.setdefault(NAMES[side], []).append((np.round(middle, 3) + 0.0).tolist())
    options = {"footprint": footprint, "street_width": widths}
    walls = places(derived(f"Lot --> extrude(4) comp(f) {WALLS}", **options))
    assert len(walls.pop("Other.")) == 2
    assert walls == expected
    # The same edges are found before the extrusion, as strips of setback and as edges of both kinds.
    for kind in ("e", "fe"):
        lines = places(derived(f"Lot --> t(0, 2, 0) comp({kind}) {WALLS}", **options))
        assert lines == expected
    strips = derived(f"Lot --> setback(0.2) {WALLS.replace('all :', 'remainder :')}", **options)
    assert {name: len(found) > 0 for name, found in places(strips).items()} == dict.fromkeys(
        [*expected, "Other."], True
    )


@given(st.floats(0.0, 6.3), st.sampled_from(KNOWN), st.sampled_from([0.0, 5e6]))
@bulk(20)
def test_sides_turn_with_the_lot_and_are_the_same_far_away(angle, lot, distance):
    footprint, widths = lot
    corners = Footprints.of([footprint]).points
    turn = np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]])
    text = f"""
    Lot --> setback(0.5) {{ street.front : A. | remainder : extrude(4) split(x) {{ ~1 : B | ~2 : B }} }}
    B --> comp(f) {WALLS}
    """
    there = derived(text, footprint=corners @ turn + [distance, 0.0, distance], street_width=widths)
    here = derived(text, footprint=footprint, street_width=widths)
    assert there.nodes.symbol.tolist() == here.nodes.symbol.tolist()


@given(street_files(), st.sampled_from(LOTS))
@bulk(10, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
def test_without_widths_the_selectors_mean_those_of_the_object(text, lot):
    unknown = derived(text, footprint=lot[0])
    by_object = derived(text.replace("street.", "object."), footprint=lot[0])
    assert fingerprint(unknown, 0) == fingerprint(by_object, 0)


def test_rules_that_select_no_streets_are_the_same_on_every_lot():
    program = compile_grammar(Grammar.parse("Lot --> extrude(4) comp(f) { object.front : A. | side : B. | all : C. }"))
    assert not program.selects_streets
    assert compile_grammar(Grammar.parse("Lot --> comp(f) { street.side : A. }")).selects_streets
    plain = derive(program, 1, 11, footprint=(12.0, 9.0))
    assert fingerprint(derive(program, 1, 11, **CORNER), 0) == fingerprint(plain, 0)


def test_a_lot_without_streets_has_no_front_and_all_its_other_sides():
    found = places(derived(f"Lot --> extrude(4) comp(f) {WALLS}", footprint=(12.0, 9.0), street_width=[0.0] * 4))
    assert "Front." not in found
    assert [6.0, 2.0, 0.0] in found["Back."]
    assert sum(len(found[name]) for name in NAMES.values() if name in found) == 4


def test_what_remains_of_a_setback_is_still_along_the_street():
    found = places(
        derived(f"Lot --> setback(3) {{ street.front : Garden. | remainder : extrude(4) comp(f) {WALLS} }}", **CORNER)
    )
    assert found["Front."] == [[4.5, 2.0, 6.0], [9.0, 2.0, 3.0]]
    assert (found["Back."], found["Left."]) == ([[4.5, 2.0, 0.0]], [[0.0, 2.0, 3.0]])


@pytest.mark.parametrize("inner", ["offset(-2, inside)", "innerRect", "setback(2) { all : NIL | remainder : B }"])
def test_upper_floors_look_at_the_street_as_the_lower_ones_do(inner):
    body = inner if "{" in inner else f"{inner} B"
    text = f"Lot --> extrude(4) comp(f) {{ top : A }}\nA --> {body}\nB --> extrude(3) comp(f) {WALLS}"
    found = places(derived(text, **CORNER))
    assert (len(found["Front."]), len(found["Back."]), len(found["Left."])) == (2, 1, 1)


def test_walls_of_a_courtyard_are_no_fronts_even_where_all_edges_are_along_streets():
    text = f"Lot --> shapeO(6, 6, 6, 6) {{ shape : extrude(12) comp(f) {WALLS} | remainder : Court. }}"
    found = places(derived(text, **ISLAND))
    assert sorted(found["Front."]) == [[0.0, 6.0, 12.0], [15.0, 6.0, 0.0], [15.0, 6.0, 24.0], [30.0, 6.0, 12.0]]
    assert sum(len(found.get(name, [])) for name in ("Back.", "Left.", "Right.")) == 4


@pytest.mark.parametrize(
    ("operation", "lot", "recessed"),
    [
        ("shapeL(6, 6)", ISLAND, [[6.0, 6.0, 9.0], [18.0, 6.0, 18.0]]),
        ("shapeU(6, 6, 6)", ISLAND, [[15.0, 6.0, 18.0]]),
        ("shapeU(0, 6, 6)", ISLAND, []),
        (
            "rotateScope(0, 180, 0) shapeU(6, 6, 6)",
            {**ISLAND, "street_width": [8.0, 0.0, 0.0, 0.0]},
            [[15.0, 6.0, 6.0]],
        ),
    ],
)
def test_walls_of_wings_that_look_at_the_street_are_fronts(operation, lot, recessed):
    text = f"Lot --> {operation} {{ shape : extrude(12) comp(f) {WALLS} | remainder : Court. }}"
    found = places(derived(text, **lot))
    on_street = {0.0, 30.0}, {0.0, 24.0}
    inner = [wall for wall in found["Front."] if wall[0] not in on_street[0] and wall[2] not in on_street[1]]
    assert sorted(inner) == recessed


def test_party_walls_of_a_row_on_a_corner_are_no_fronts():
    found = places(
        derived(f"Lot --> extrude(4) split(x) {{ ~1 : House | ~1 : House }}\nHouse --> comp(f) {WALLS}", **CORNER)
    )
    assert sorted(found["Front."]) == [[3.0, 2.0, 9.0], [9.0, 2.0, 9.0], [12.0, 2.0, 4.5]]
    assert found["Right."] == [[6.0, 2.0, 4.5]]


@pytest.mark.parametrize(
    "move", ["t(3, 1, 2)", "s('2, '1, '0.5)", "r(0, 40, 0)", "r(scopeCenter, 0, 180, 0)", "center(xz)"]
)
def test_walls_keep_their_edges_when_the_mass_moves(move):
    lots = Lots.of(1, 11, **CORNER)
    one = derive(Grammar.parse(f"Lot --> extrude(4) comp(f) {WALLS}"), lots)
    other = derive(Grammar.parse(f"Lot --> extrude(4) {move} comp(f) {WALLS}"), lots)
    assert other.nodes.symbol.tolist() == one.nodes.symbol.tolist()


def test_a_bay_has_the_side_of_the_wall_that_it_stands_out_of():
    text = f"""
    Lot --> extrude(4) comp(f) {{ street.front : split(x) {{ ~1 : NIL | 2 : Bay | ~1 : NIL }} }}
    Bay --> extrude(1) comp(f) {WALLS}
    """
    found = places(derived(text, footprint=(12.0, 9.0), street_width=[8.0, 0.0, 0.0, 0.0]))
    assert found["Front."] == [[6.0, 2.0, 10.0]]
    assert (found["Left."], found["Right."]) == ([[5.0, 2.0, 9.5]], [[7.0, 2.0, 9.5]])


def test_an_asset_has_the_sides_of_the_edges_that_look_the_same_way():
    text = f"Lot --> s('0.5, 4, '0.5) center(xz) primitiveCube comp(f) {WALLS}"
    found = places(derived(text, **CORNER))
    assert sorted(found["Front."]) == [[6.0, 2.0, 6.75], [9.0, 2.0, 4.5]]
    assert (found["Back."], found["Left."]) == ([[6.0, 2.0, 2.25]], [[3.0, 2.0, 4.5]])


@pytest.mark.parametrize(
    ("block", "rest"), [("comp(f)", "street.back : B. | street.side"), ("comp(fe)", "all"), ("setback(0.5)", "all")]
)
def test_names_of_older_rule_files_are_sides_along_streets_and_all_others(block, rest):
    solid = "extrude(4) " if block == "comp(f)" else ""
    older = places(derived(f"Lot --> {solid}{block} {{ streetSide : A. | noStreetSide : B. }}", **CORNER))
    newer = places(derived(f"Lot --> {solid}{block} {{ street.front : A. | {rest} : B. }}", **CORNER))
    assert {name: sorted(found) for name, found in older.items()} == {n: sorted(found) for n, found in newer.items()}


def test_measures_and_conditions_know_the_streets():
    text = """
    Lot --> extrude(4) report("front", geometry.area(street.front)) report("side", geometry.area(street.side))
            comp(f) { street.front && geometry.area > 40 : Wide. | geometry.isOriented(street.front) : Narrow. }
    """
    forest = derived(text, **CORNER)
    assert dict(zip(forest.reports.keys, forest.reports.value, strict=True)) == {"front": 84.0, "side": 36.0}
    assert places(forest) == {"Wide.": [[6.0, 2.0, 9.0]], "Narrow.": [[12.0, 2.0, 4.5]]}


def test_the_attribute_has_a_width_for_each_edge_or_that_of_the_widest_street():
    court, widths = LOTS[-1]
    many = Grammar.parse(
        'attr streetWidth = [0]\nLot --> report("n", size(streetWidth)) setback(streetWidth) { all : A. }'
    )
    one = Grammar.parse('attr streetWidth = 2\nLot --> report("w", streetWidth) A.')
    lots = [
        Lots.of(1, 1, footprint=court, street_width=widths),
        Lots.of(1, 1),
        Lots.of(1, 1, street_width=[0, 5, 3, 0]),
        Lots.of(1, 1, street_width=[0] * 4),
    ]
    # Bridges to the courtyard have no width, as comp(fe) has no edge for them.
    assert derive(many, Lots.concatenate(lots)).reports.value.tolist() == [8.0, 1.0, 4.0, 4.0]
    assert derive(one, Lots.concatenate(lots)).reports.value.tolist() == [8.0, 2.0, 5.0, 0.0]
    given = Lots.of(1, 1, street_width=[0, 5, 3, 0], attributes={"streetWidth": 7})
    assert derive(one, Lots.concatenate([given, lots[2]])).reports.value.tolist() == [7.0, 5.0]
    constant = Grammar.parse('const streetWidth = 2\nLot --> report("w", streetWidth) A.')
    assert derive(constant, lots[2]).reports.value.tolist() == [2.0]
