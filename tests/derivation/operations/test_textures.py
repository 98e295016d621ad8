"""Splits between values of a texture coordinate."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.arrays import Floats
from grammarlab.derivation import Forest, derive
from grammarlab.derivation.state.shapes import BOX, FACE
from grammarlab.geometry.meshes.measure import areas
from grammarlab.language.grammar import Grammar
from tests.cases import bulk
from tests.derivation.operations.leaves import L_SHAPE, TRIANGLE, areas_by_symbol, sampled, symbols, world_meshes

SIZES = [
    "{ 2 : A | ~1 : B }",
    "{ { ~3 : A | 1 : B }* | '0.1 : C }",
    "{ 1.5 : A | { ~2 : B | { 0.5 : C | ~0.7 : D }* }* }",
    "{ ~1 : A | 100 : B }",
    "{ { 2 : A }* }",
    "{ 0 : A | '0 : B | ~1 : C | 2 : NIL }",
]


def corners_by_part(forest: Forest) -> list[tuple[str, Floats]]:
    """The symbol of each leaf and its corners in order, in the order of the derivation."""
    meshes = world_meshes(forest)
    ends = meshes.mesh_points
    parts = [meshes.points[start:end] for start, end in pairwise(ends)]
    ordered = [part[np.lexsort(part.round(6).T)] for part in parts]
    return list(zip(symbols(forest), ordered, strict=True))


@pytest.mark.parametrize("footprint", [(30.0, 20.0), L_SHAPE, TRIANGLE])
@pytest.mark.parametrize("sizes", SIZES)
@pytest.mark.parametrize("solid", ["", "extrude(4)", "roofHip(30)"])
def test_a_split_along_u_in_metres_is_one_along_x_where_u_runs_along_x(footprint, sizes, solid):
    projection = "setupProjection(0, scope.xz, 7, 3, 11, 0) projectUV(0)"
    along_u = sampled(f"Lot --> {solid} {projection} split(u, uvSpace, 0) {in_sevenths(sizes)}", footprint)
    along_x = sampled(f"Lot --> {solid} split(x) {sizes}", footprint)
    expected = corners_by_part(along_x)
    found = corners_by_part(along_u)
    assert [symbol for symbol, _ in found] == [symbol for symbol, _ in expected]
    for (_, one), (_, other) in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-6)
    for name in along_x.nodes.__slots__:
        np.testing.assert_array_equal(getattr(along_u.nodes, name), getattr(along_x.nodes, name))


def in_sevenths(sizes: str) -> str:
    """Sizes in metres as parts of a texture 7 m wide; shares stay what they are."""
    words = sizes.split()
    return " ".join(
        f"{word[0] if word[0] == '~' else ''}{float(word.lstrip('~'))} / 7" if word.lstrip("~")[0].isdigit() else word
        for word in words
    )


@pytest.mark.parametrize("footprint", [(30.0, 20.0), L_SHAPE])
@pytest.mark.parametrize("sizes", SIZES)
def test_unit_space_is_metres_on_the_surface(footprint, sizes):
    """The initial shape's v runs from its first edge to the other side."""
    backwards = sampled(f"Lot --> scaleUV(0, 3, -5) split(v, unitSpace, 0) {sizes}", footprint)
    assert areas_by_symbol(backwards) == pytest.approx(areas_by_symbol(sampled(f"Lot --> split(z) {sizes}", footprint)))
    plain = corners_by_part(sampled(f"Lot --> split(u, unitSpace, 0) {sizes}", footprint))
    along_x = corners_by_part(sampled(f"Lot --> split(x) {sizes}", footprint))
    for (name, one), (other_name, other) in zip(plain, along_x, strict=True):
        assert name == other_name
        np.testing.assert_allclose(one, other, atol=1e-6)


@given(
    st.integers(-179, 179),
    st.sampled_from([(30.0, 20.0), L_SHAPE, TRIANGLE]),
    st.sampled_from(["", "extrude(5)", "roofGable(40)"]),
    st.sampled_from(["u", "v"]),
)
@bulk(60)
def test_oblique_parts_fill_the_whole_and_have_the_widths_asked_for(angle, footprint, solid, axis):
    rules = f"""
        Lot --> {solid} setupProjection(0, world.xz, 4, 3) projectUV(0) rotateUV(0, {angle}) [ Whole ]
                split({axis}, uvSpace, 0) {{ 0.7 : Part | {{ ~0.9 : Part }}* | '0.25 : Part }}
        Part --> report("low", geometry.{axis}Min(0)) report("high", geometry.{axis}Max(0)) P
    """
    forest = sampled(rules, footprint)
    measured = {key: forest.reports.value[forest.reports.key == place] for place, key in enumerate(forest.reports.keys)}
    low, high = measured["low"], measured["high"]
    np.testing.assert_allclose(low[1:], high[:-1], atol=1e-6)
    whole = high[-1] - low[0]
    widths = high - low
    assert (widths[0], widths[-1]) == pytest.approx((0.7, whole / 4), abs=1e-6)
    np.testing.assert_allclose(widths[1:-1], (0.75 * whole - 0.7) / (len(widths) - 2), atol=1e-6)
    if solid == "":
        found = areas_by_symbol(forest)
        assert found["P"] == pytest.approx(found["Whole"])


def test_boxes_and_rectangles_stay_what_they_are():
    rules = """
        Lot --> extrude(4) setupProjection(0, scope.zy, 2, 2) projectUV(0)
                split(u, unitSpace, 0) { 3 : A | ~1 : comp(f) { top : split(u, unitSpace, 0) { 2 : A | ~1 : A } } }
    """
    forest = sampled(rules)
    assert len(forest.leaves) == 3
    assert set(forest.leaves.mesh.tolist()) == {BOX, FACE}


def test_parts_know_their_places():
    rules = """
        Lot --> split(v, uvSpace, 0) { { ~0.2 : report("place", split.index + 10 * split.total) A }* }
    """
    assert sampled(rules).reports.value.tolist() == [50.0, 51.0, 52.0, 53.0, 54.0]


def test_a_part_has_the_same_draws_as_that_of_a_split_along_x():
    parts = '{ { ~3 : report("draw", rand()) A | 1 : NIL }* | ~1 : report("draw", rand()) B }'
    along_u = sampled(f'Lot --> split("u", "unitSpace", 0) {parts}', num_models=4)
    along_x = sampled(f'Lot --> split("x") {parts}', num_models=4)
    np.testing.assert_array_equal(along_u.draws.value, along_x.draws.value)


def test_a_surface_that_the_coordinate_does_not_change_on_has_no_parts():
    forest = sampled("Lot --> extrude(4) comp(f) { right : split(u, unitSpace, 0) { ~1 : A } | top : Top }")
    assert symbols(forest) == ["Top"]


def test_models_of_a_batch_are_cut_as_alone():
    rules = """
        attr w = rand(1, 4)
        Lot --> r(0, 360 * w, 0) scaleUV(0, w, 1) rotateUV(0, 9 * w) split(u, uvSpace, 0) { w / 3 : A | ~1 : B }
    """
    batch = derive(Grammar.parse(rules), 8, 2, footprint=L_SHAPE)
    whole = areas(world_meshes(batch))
    model = batch.nodes.model[batch.leaves.node]
    for index in range(8):
        alone = derive(Grammar.parse(rules), 1, 2, first_model=index, footprint=L_SHAPE)
        np.testing.assert_array_equal(areas(world_meshes(alone)), whole[model == index])
