"""Envelopes of buildings: volumes that can be worked out by hand, and bounds on every lot."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.derivation.state.mesh_table import scaled
from grammarlab.geometry.meshes.edges import is_closed_surface
from grammarlab.geometry.meshes.measure import areas, volumes
from grammarlab.language.grammar import Grammar

L_SHAPE = np.array([[0.0, 0, 12], [8, 0, 12], [8, 0, 22], [26, 0, 22], [26, 0, 0], [0, 0, 0]])


def solid_of(arguments: str, footprint=(20.0, 20.0), **options):
    forest = derive(Grammar.parse(f"Lot --> envelope({arguments}) X"), 1, 1, footprint=footprint, **options)
    meshes = scaled(forest.meshes.take(forest.leaves.mesh), forest.leaves.size)
    assert is_closed_surface(meshes).all()
    return float(volumes(meshes).sum()), forest.leaves.size[0], meshes.num_faces


@pytest.mark.parametrize(
    ("arguments", "volume", "height", "num_faces"),
    [
        ("normal, 20, 10, 45", 20 * 20 * 20 - 0.5 * 10 * 10 * 20, 20, 7),
        ("world.up, 20, 30, 45", 20**3, 20, 6),
        ("world.up, 20, 10, 90, 5, 90", 20**3, 20, 6),
        ("world.up, 8, [3, 3, 3, 3], [45, 45, 45, 45]", 3 * 400 + 5 / 3 * (400 + 200 + 100), 8, 10),
        ("world.up, 99, 3, 45, 3, 45, 3, 45", 3 * 400 + 10 / 3 * 400, 13, 9),
        ("99, 3, 45, 3, 45, 3, 45", 3 * 400 + 10 / 3 * 400, 13, 9),
        ("world.up, 8, [3], [45]", 8 * 400 - 0.5 * 5 * 5 * 20, 8, 7),
        ("world.up, 10, 0, 45, 0, 45, 0, 90, 0, 90", 0.5 * 20 * 10 * 20, 10, 5),
    ],
)
def test_an_envelope_has_the_volume_that_its_planes_leave(arguments, volume, height, num_faces):
    actual, size, faces = solid_of(arguments)
    assert actual == pytest.approx(volume, rel=1e-9)
    assert size[1] == pytest.approx(height)
    assert faces == num_faces


def test_the_sides_of_an_envelope_are_those_along_streets():
    front_is_long = solid_of("world.up, 9, 0, 45", (30.0, 10.0), street_width=[8, 0, 0, 0])[0]
    front_is_short = solid_of("world.up, 9, 0, 45", (30.0, 10.0), street_width=[0, 8, 0, 0])[0]
    assert front_is_long == pytest.approx(9 * 300 - 0.5 * 81 * 30)
    assert front_is_short == pytest.approx(9 * 300 - 0.5 * 81 * 10)


@pytest.mark.parametrize("angle", [20, 45, 70])
def test_an_envelope_of_a_concave_lot_lies_between_its_walls_and_its_height(angle):
    area = 8 * 12 + 18 * 22
    volume, size, _ = solid_of(f"world.up, 9, 4, {angle}, 4, {angle}, 4, {angle}", L_SHAPE)
    assert 4 * area < volume < 9 * area
    assert size == pytest.approx([26, 9, 22]) or angle == 20


def test_an_envelope_without_height_is_the_lot():
    forest = derive(Grammar.parse("Lot --> envelope(normal, 0, 1, 45) X"), 1, 1)
    assert forest.leaves.size.tolist() == [[20.0, 0.0, 20.0]]


def test_faces_follow_the_edges_and_the_scope_keeps_its_axes():
    rule = "Lot --> extrude(3) comp(f) { top : envelope(world.up, 9, 3, 60, 3, 60, 3, 60) comp(f) { all : A } }"
    lot = np.array([[0, 0, 0], [0, 0, 20], [30, 0, 20], [30, 0, 0.0]])
    forest = derive(Grammar.parse(rule), 1, 1, footprint=lot)
    sides = areas(scaled(forest.meshes.take(forest.leaves.mesh), forest.leaves.size))
    # from the runtime: the ground, the wall and the slope of each edge, the top
    assert sides == pytest.approx([600, 60, 114.564, 90, 183.846, 60, 114.564, 90, 183.846, 301.590], abs=1e-3)
    whole = derive(Grammar.parse(rule.replace("comp(f) { all : A }", "A")), 1, 1, footprint=lot)
    assert whole.leaves.size[0] == pytest.approx([20.0, 30.0, 9.0])
