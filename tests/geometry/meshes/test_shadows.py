"""Footprints cover what the geometry covers seen from above; faces without holes have the area of their outline."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grammarlab.geometry.footprints.footprint_text import read_footprints
from grammarlab.geometry.meshes import primitives
from grammarlab.geometry.meshes.edges import num_holes
from grammarlab.geometry.meshes.measure import areas, face_normals
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.shadows import shadow, without_holes
from tests.derivation.operations.leaves import L_SHAPE, sampled, world_meshes
from tests.geometry.bodies import FRAME


@pytest.mark.parametrize(
    ("solid", "area"),
    [
        ("extrude(5)", 492.0),
        ("taper(4)", 492.0),
        ("offset(-2, border) extrude(3)", 176.0),
        ("extrude(3) t(0, 9, 0)", 492.0),
        ("roofGable(30, 1, 1)", 582.622),  # from the runtime
    ],
)
def test_a_footprint_has_the_area_that_is_covered(solid: str, area: float) -> None:
    mesh = world_meshes(sampled(f"Lot --> {solid} footprint() A.", L_SHAPE))
    assert areas(mesh) == pytest.approx([area], abs=1e-3)
    assert face_normals(mesh) == pytest.approx(np.tile([0.0, 1.0, 0.0], (mesh.num_faces, 1)))


def test_the_shadow_of_a_turned_box_is_its_convex_outline() -> None:
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    box = primitives.box()
    corners = box.points @ turn.T
    expected = np.abs(turn[1]).sum()  # each pair of faces covers the size of its normal's height
    assert areas(shadow(box.with_points(corners))) == pytest.approx([expected])


def test_walls_have_no_footprint_and_stay() -> None:
    rule = "Lot --> extrude(4) comp(f) { front : footprint() A. }"
    assert areas(world_meshes(sampled(rule))) == pytest.approx([120.0])
    assert shadow(Meshes.united([])).num_faces == 0


def test_faces_without_holes_are_their_outlines() -> None:
    ring = world_meshes(sampled("Lot --> shapeO(3, 3, 3, 3) { shape : A. }", L_SHAPE))
    filled = without_holes(ring)
    assert num_holes(ring).tolist() == [1]
    assert num_holes(filled).tolist() == [0]
    assert areas(filled) == pytest.approx([492.0])
    assert without_holes(filled) is filled


def test_the_outline_of_a_face_that_begins_on_its_hole_is_the_outer_one() -> None:
    walk = FRAME.corners
    for turn in range(len(walk)):
        filled = without_holes(replace(FRAME, corners=np.roll(walk, turn)))
        assert areas(filled) == pytest.approx([81.0])
        assert face_normals(filled) == pytest.approx(face_normals(FRAME))


def test_a_pyramid_over_the_strip_around_a_court_rises() -> None:
    (lot,) = read_footprints("POLYGON ((0 0, 30 0, 30 20, 0 20, 0 0), (10 8, 20 8, 20 12, 10 12, 10 8))")
    rule = "Lot --> setback(2) { all : roofPyramid(30) A. | remainder : NIL }"
    mesh = world_meshes(sampled(rule, lot.polygon))
    assert mesh.points[:, 1].min() == pytest.approx(0.0)
