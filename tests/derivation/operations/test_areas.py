"""Divisions by area and along the perimeter: the parts fill the shape and have the areas that were asked for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.derivation import derive
from grammarlab.derivation.state.mesh_table import scaled
from grammarlab.geometry.meshes.measure import areas
from grammarlab.language.grammar import Grammar
from tests.cases import bulk

L_SHAPE = [(0, 0, 12), (8, 0, 12), (8, 0, 22), (26, 0, 22), (26, 0, 0), (0, 0, 0)]
SKEW = [(0, 0, 18), (28, 0, 20), (30, 0, 1), (2, 0, 0)]


def areas_of(text: str, footprint) -> dict[str, float]:
    """Area of all leaves of each symbol."""
    forest = derive(Grammar.parse(text), 1, 1, footprint=footprint)
    leaves = areas(scaled(forest.meshes.take(forest.leaves.mesh), forest.leaves.size))
    names = [forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]]
    return {name: float(sum(a for n, a in zip(names, leaves, strict=True) if n == name)) for name in names}


@pytest.mark.parametrize("footprint", [(30.0, 20.0), L_SHAPE, SKEW])
@pytest.mark.parametrize("axis", ["x", "z"])
def test_parts_of_an_area_split_have_their_areas(footprint, axis):
    whole = areas_of("Lot --> A", footprint)["A"]
    parts = areas_of(f"Lot --> splitArea({axis}) {{ 100 : A | '0.25 : B | ~1 : C }}", footprint)
    assert parts == pytest.approx({"A": 100.0, "B": 0.25 * whole, "C": 0.75 * whole - 100.0}, rel=1e-9)


@given(st.floats(1.0, 400.0), st.sampled_from(["all", "front", "object.side"]))
@bulk(20)
def test_a_setback_to_an_area_leaves_it_if_it_can(area, selector):
    whole = areas_of("Lot --> A", L_SHAPE)["A"]
    text = f"Lot --> setbackToArea({area}) {{ {selector} : Strip | remainder : Rest }}"
    parts = areas_of(text, L_SHAPE)
    assert sum(parts.values()) == pytest.approx(whole, rel=1e-9)
    if selector != "front":  # the front alone cannot sweep the whole shape
        assert parts["Rest"] == pytest.approx(area, rel=1e-9)


def test_a_setback_to_an_area_keeps_within_its_bounds():
    bounded = "Lot --> setbackToArea({}, [1, 1, 1, 1], [2, 2, 2, 2]) {{ all : Strip | remainder : Rest }}"
    assert areas_of(bounded.format(1), (20.0, 20.0))["Rest"] == pytest.approx(16.0 * 16.0)
    assert areas_of(bounded.format(400), (20.0, 20.0))["Rest"] == pytest.approx(18.0 * 18.0)
    assert areas_of(bounded.format(300), (20.0, 20.0))["Rest"] == pytest.approx(300.0)


@pytest.mark.parametrize("footprint", [(30.0, 20.0), L_SHAPE, SKEW])
def test_setback_per_edge_is_a_setback_by_the_values_of_edges(footprint):
    text = "Lot --> {} {{ all : Strip | remainder : Rest }}"
    per_edge = areas_of(text.format("setbackPerEdge(scope.sx / 10)"), footprint)
    assert per_edge == areas_of(text.format("setback(comp(fe) { all : scope.sx / 10 })"), footprint)


@pytest.mark.parametrize("footprint", [(20.0, 20.0), L_SHAPE, SKEW])
@pytest.mark.parametrize("offset", ["0", "3", "'0.3"])
def test_sections_of_a_perimeter_and_the_rest_fill_the_shape(footprint, offset):
    text = f"Lot --> splitAndSetbackPerimeter({offset}) {{ ~5 : 2 : A | 3 : 1 : B }}* {{ remainder : Rest }}"
    parts = areas_of(text, footprint)
    assert sum(parts.values()) == pytest.approx(areas_of("Lot --> A", footprint)["A"], rel=1e-9)


def test_sections_begin_at_an_edge_and_leave_masked_edges_out():
    text = """Lot --> splitAndSetbackPerimeter('0.5, 1, [true, false, true, false]) { 10 : 4 : A | ~1 : 1 : B }
                      { remainder : Rest }"""
    assert areas_of(text, (20.0, 20.0)) == pytest.approx({"A": 40.0, "B": 30.0, "Rest": 330.0})


def test_each_section_is_one_shape_also_around_a_corner():
    text = "Lot --> splitAndSetbackPerimeter(10) { 20 : 2 : A }* { remainder : Rest }"
    forest = derive(Grammar.parse(text), 1, 1, footprint=(20.0, 20.0))
    names = [forest.symbols[symbol] for symbol in forest.nodes.symbol[forest.leaves.node]]
    assert names == ["A"] * 4 + ["Rest"]
    leaves = areas(scaled(forest.meshes.take(forest.leaves.mesh), forest.leaves.size))
    assert np.allclose(leaves, [36.0] * 4 + [256.0])
