"""``comp``: which components a part gets, and the axes they come in."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.errors import DerivationError
from grammarlab.geometry.meshes import measure
from grammarlab.language.grammar import Grammar
from tests.derivation.operations.leaves import (
    L_SHAPE,
    areas_by_symbol,
    sampled,
    symbols,
    world_meshes,
)


def axes(forest):
    return forest.frames[forest.leaves.frame]


@pytest.mark.parametrize(("kind", "count"), [("f", 8), ("e", 18), ("v", 12), ("fe", 36), ("fv", 36)])
def test_a_prism_over_an_l_has_so_many_components(kind, count):
    assert len(sampled(f"Lot --> extrude(7) comp({kind}) {{ all : A }}", L_SHAPE).leaves) == count


def test_edges_of_faces_run_around_their_faces_with_z_out_of_them():
    forest = sampled("Lot --> comp(fe) { all : A }")
    assert np.allclose(forest.leaves.position, [[0, 0, 20], [30, 0, 20], [30, 0, 0], [0, 0, 0]])
    assert np.allclose(axes(forest)[:, :, 0], [[1, 0, 0], [0, 0, -1], [-1, 0, 0], [0, 0, 1]])
    assert np.allclose(axes(forest)[:, :, 1], [0, 1, 0])
    assert np.allclose(axes(forest)[:, :, 2], [[0, 0, 1], [1, 0, 0], [0, 0, -1], [-1, 0, 0]])


def test_corners_of_faces_look_half_way_between_their_edges():
    forest = sampled("Lot --> comp(fv) { all : s(1, 1, 1) primitiveCube() A }")
    half = np.sqrt(0.5)
    assert np.allclose(axes(forest)[:, :, 2], [[-half, 0, half], [half, 0, half], [half, 0, -half], [-half, 0, -half]])


def test_selectors_look_at_the_outward_normals_of_edges_of_faces():
    forest = sampled("Lot --> comp(fe) { front : A | side : B | back : C }")
    assert sorted(symbols(forest)) == ["A", "B", "B", "B"]


def test_without_alignment_components_keep_the_axes_and_the_place():
    turned = sampled("Lot --> r(0, 33, 0) extrude(7) comp(f, noAlign) { all : A }", L_SHAPE)
    aligned = sampled("Lot --> r(0, 33, 0) extrude(7) comp(f, zUp) { all : A }", L_SHAPE)
    assert np.allclose(axes(turned), axes(turned)[0])
    assert np.allclose(measure.area_vectors(world_meshes(turned)), measure.area_vectors(world_meshes(aligned)))
    assert np.allclose(world_meshes(turned).bounds(), world_meshes(aligned).bounds())


def test_an_equals_sign_with_a_colon_makes_one_shape_of_each_connected_set():
    text = "Lot --> extrude(7) comp(f) {{ front || back {} A | all = B }}"
    assert sorted(symbols(sampled(text.format("=:")))) == ["A", "A", "B"]
    assert sorted(symbols(sampled(text.format("=")))) == ["A", "B"]
    forest = sampled("Lot --> extrude(7) comp(f) { side =: A }", L_SHAPE)
    assert symbols(forest) == ["A"]
    assert areas_by_symbol(forest)["A"] == pytest.approx(7 * 96)


def test_joined_edges_are_one_shape_in_the_frame_of_the_first():
    forest = sampled("Lot --> extrude(7) comp(e) { all = A }")
    (low,), (high,) = world_meshes(forest).bounds()
    assert len(forest.leaves) == 1
    assert np.allclose((low, high), [[0, 0, 0], [30, 7, 20]])


def test_only_faces_are_connected():
    with pytest.raises(DerivationError, match="comp with =: joins faces only"):
        sampled("Lot --> extrude(7) comp(e) { all =: A }")


@pytest.mark.parametrize(
    ("condition", "count"),
    [
        ("top || front", 2),
        ("!top && !bottom", 4),
        ("geometry.area() > 200", 4),
        ("geometry.area > 200 && side", 2),
        ("geometry.isOriented(top)", 1),
        ("upright", 4),
        ("true", 6),
        ("second", 1),
        ("1 + 1", 1),
        ("7", 1),
        ("-1", 1),
        ("split.index == 0 && left", 1),
        ("scope.sy == 0", 2),
        ("p(0)", 0),
    ],
)
def test_a_condition_selects_the_components_it_holds_for(condition, count):
    text = "upright = !geometry.isOriented(world.up) && geometry.height > 0\nsecond = 2\nLot --> extrude(7) Box\n"
    forest = sampled(text + f"Box --> comp(f) {{ {condition} : A | all : B }}")
    assert symbols(forest).count("A") == count
    assert symbols(forest).count("B") == 6 - count


def test_a_condition_that_draws_draws_for_each_component():
    forest = sampled("Lot --> extrude(7) split(x) { { 1 : comp(f) { p(0.5) : A | all : B } }* }")
    assert 60 < symbols(forest).count("A") < 120
    assert len(forest.draws.node) == 180


def test_a_part_knows_what_selected_it():
    text = (
        'Lot --> extrude(7) comp(f) { front : F | top || back : G | 5 : H | all : A }\nF --> case comp.sel == "front"'
    )
    text += ' : OkF else : NIL\nG --> case comp.sel == "top || back" : OkG else : NIL\n'
    text += 'H --> case comp.sel == "5" : OkH else : NIL\nA --> case comp.sel == "all" : OkA else : NIL'
    assert sorted(symbols(sampled(text))) == ["OkA", "OkA", "OkF", "OkG", "OkG", "OkH"]


def test_edges_that_climb_a_roof_lead_upwards_and_eaves_around():
    forest = sampled("Lot --> roofHip(40) comp(e) { hip : H | ridge : R | valley : V | eave : E }", L_SHAPE)
    kinds = np.array(symbols(forest))
    along = axes(forest)[:, :, 0]
    assert (along[kinds != "E"][:, 1] > -1e-9).all()
    assert {kind: int((kinds == kind).sum()) for kind in "EHVR"} == {"E": 6, "H": 5, "V": 1, "R": 3}
    starts = forest.leaves.position[kinds == "E"]
    ends = starts + along[kinds == "E"] * forest.leaves.size[kinds == "E"][:, :1]
    area = 0.5 * (starts[:, 2] * ends[:, 0] - starts[:, 0] * ends[:, 2]).sum()
    # Eaves run against their slopes.
    assert area == pytest.approx(-492.0)


def test_conditions_choose_edges_of_setbacks_too():
    text = "Lot --> setback(2) {{ {} : A | remainder : B }}"
    for condition, area in [("front || left", 96.0), ("scope.sx > 25", 120.0), ("!all", 0.0)]:
        areas = areas_by_symbol(sampled(text.format(condition)))
        assert areas.get("A", 0.0) == pytest.approx(area)
        assert sum(areas.values()) == pytest.approx(600.0)


def test_parts_of_mixed_geometry_are_told_apart_shape_by_shape():
    text = "Lot --> split(x) { 10 : extrude(3) M | 10 : primitiveCylinder(6) s('1, 3, '1) M | ~1 : M }\n"
    forest = sampled(text + "M --> comp(f) { side =: S | top : T | all = R }")
    assert sorted(symbols(forest)) == ["R", "R", "S", "S", "T", "T", "T"]


@pytest.mark.parametrize("sign", [":", "="])
@pytest.mark.parametrize(
    ("cut", "piece", "length", "area"),
    [
        ("shapeO(4, 4, 4, 4)", "shape", 100 + 68, 336),
        ("shapeO(1, 2, 3, 4)", "shape", 100 + 80, 216),
        ("setback(4)", "all", 100 + 68, 336),
    ],
)
def test_a_ring_has_one_hole_and_no_walls_where_its_outline_and_its_hole_are_joined(sign, cut, piece, length, area):
    rules = (
        f"Lot --> {cut} {{ {piece} {sign} Ring | remainder : NIL }}\n"
        'Ring --> report("holes", geometry.nHoles) report("edges", geometry.nEdges) report("around", '
        'geometry.boundaryLength()) extrude(5) report("volume", geometry.volume) comp(f) { side : Wall. | all : Cap. }'
    )
    forest = derive(Grammar.parse(rules), 2, seed=1, footprint=(30.0, 20.0))
    names = np.array(forest.reports.keys)[forest.reports.key]
    found = {name: forest.reports.value[names == name].tolist() for name in forest.reports.keys}
    assert found["holes"] == [1, 1]
    assert found["edges"] == [8, 8]
    assert np.allclose(found["around"], length)
    assert np.allclose(found["volume"], 5 * area)
    walls = np.array(forest.symbols)[forest.nodes.symbol[forest.leaves.node]] == "Wall."
    assert walls.sum() == 2 * 8
    assert forest.leaves.size[walls, :2].prod(axis=1).sum() == pytest.approx(2 * 5 * length)
    assert len(forest.leaves) == 2 * (8 + 2)
