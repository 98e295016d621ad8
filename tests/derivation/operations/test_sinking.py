"""Negative heights of ``extrude`` and ``taper``: scopes that reach down from their face."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.geometry.meshes import measure
from tests.derivation.operations.leaves import L_SHAPE, sampled, symbols, volumes_by_symbol, world_meshes

LOTS = {"rectangle": ((30.0, 20.0), 600.0), "L": (L_SHAPE, 492.0)}


@pytest.mark.parametrize("lot", LOTS)
@pytest.mark.parametrize(
    ("rule", "volume", "low", "high"),
    [
        ("extrude(-6) A", 6.0, -6.0, 0.0),
        ("extrude(world.up, -6) A", 6.0, -6.0, 0.0),
        ("extrude(-6) s('1, '0.5, '1) A", 3.0, -3.0, 0.0),
        ("extrude(-6) t(0, '1, 0) A", 6.0, -12.0, -6.0),
        ("extrude(-6) split(y) { 2 : A | ~1 : A }", 6.0, -6.0, 0.0),
        ("extrude(-6) split(x) { 2 : A | ~1 : A }", 6.0, -6.0, 0.0),
        ("extrude(-6) rotateScope(0, 20, 0) A", 6.0, -6.0, 0.0),
        ("extrude(-6) mirror(true, false, false) A", 6.0, -6.0, 0.0),
        ("taper(-6) A", 2.0, -6.0, 0.0),
        ("taper(6) A", 2.0, 0.0, 6.0),
    ],
)
def test_solids_below_their_face_look_outwards(lot, rule, volume, low, high):
    footprint, area = LOTS[lot]
    forest = sampled(f"Lot --> {rule}", footprint)
    meshes = world_meshes(forest)
    assert volumes_by_symbol(forest)["A"] == pytest.approx(volume * area)
    assert measure.is_closed(meshes).all()
    assert (forest.leaves.size >= 0.0).all()
    assert meshes.points[:, 1].min() == pytest.approx(low)
    assert meshes.points[:, 1].max() == pytest.approx(high)


@pytest.mark.parametrize("operation", ["extrude(-6)", "taper(-6)", "extrude(world.up, -6)"])
def test_the_height_of_the_scope_is_negative(operation):
    text = f"Lot --> {operation} case scope.sy < -5.9 : A else : B".replace("case", "C\nC --> case")
    assert symbols(sampled(text)) == ["A"]


def test_sunk_and_raised_models_of_one_batch_are_sized_alike():
    grammar = "Lot --> 50% : extrude(6) A else : extrude(-6) A   A --> s('1, '0.5, '1) B"
    leaves = sampled(grammar, num_models=16).leaves
    assert np.allclose(leaves.size[:, 1], 3.0)
    assert set(leaves.position[:, 1]) == {0.0, -3.0}


def test_a_box_that_was_sunk_is_a_box_again():
    sunk, raised = sampled("Lot --> extrude(-6) A"), sampled("Lot --> t(0, -6, 0) extrude(6) A")
    assert np.array_equal(sunk.leaves.mesh, raised.leaves.mesh)
    assert np.array_equal(sunk.leaves.position, raised.leaves.position)


@pytest.mark.parametrize("insert", ["primitiveCube()", 'i("builtin:cylinder")'])
def test_what_is_inserted_fills_the_sunk_scope_from_its_lower_end(insert):
    forest = sampled(f"Lot --> extrude(-6) {insert} A")
    assert volumes_by_symbol(forest)["A"] > 0.0
    assert np.allclose(world_meshes(forest).bounds()[0][:, 1], -6.0)


def test_a_taper_stands_on_the_first_face_over_the_mean_of_its_corners():
    meshes = world_meshes(sampled("Lot --> taper(9) A", L_SHAPE))
    tip = meshes.points[meshes.points[:, 1].argmax()]
    centre = np.asarray(L_SHAPE).mean(axis=0)
    assert np.allclose(tip, [centre[0], 9.0, centre[2]])
    boxed = sampled("Lot --> extrude(4) taper(3) A")
    assert volumes_by_symbol(boxed)["A"] == pytest.approx(30 * 20 * 3 / 3)
