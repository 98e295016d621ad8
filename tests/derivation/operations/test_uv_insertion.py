"""Assets along texture coordinates cover the faces that they are bent to, as in the runtime of CityEngine."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.errors import DerivationError
from grammarlab.geometry.meshes import measure
from grammarlab.geometry.meshes.edges import joined
from grammarlab.language.grammar import Grammar
from tests.derivation.operations.leaves import L_SHAPE, sampled, world_meshes

RECTANGLE = np.array([[0, 0, 0], [0, 0, 20], [30, 0, 20], [30, 0, 0.0]])
SKEW = np.array([[0, 0, 0], [-3, 0, 16], [22, 0, 24], [26, 0, 2.0]])
SHARP = np.array([[0, 0, 0], [5, 0, 19], [28, 0, 3.0]])


@pytest.mark.parametrize(
    ("lot", "size", "faces", "area"),
    [  # from the runtime
        (RECTANGLE, "20, 30", 6, 1500.0),
        (RECTANGLE, "10, 15", 16, 1500.0),
        (SHARP, "7, 9", 27, 744.475),
        (SHARP, "20, 30", 5, 744.475),
    ],
)
def test_a_cube_fills_the_prism_over_a_face(lot, size, faces, area):
    rule = f'Lot --> setupProjection(0, scope.xz, {size}) projectUV(0) insertAlongUV(0, "builtin:cube", 3) A'
    meshes = world_meshes(sampled(rule, lot))
    assert (meshes.num_faces, measure.areas(meshes)[0]) == (faces, pytest.approx(area, abs=1e-3))
    assert measure.volumes(meshes)[0] == pytest.approx(measure.areas(world_meshes(sampled("Lot --> A", lot)))[0] * 3.0)


def test_the_height_follows_normals_and_keeps_what_is_outside_outside():
    rule = 'Lot --> extrude(5) setupProjection(0, scope.xy, 4, 2) projectUV(0) insertAlongUV(0, "builtin:cube", {}) A'
    out = world_meshes(sampled(rule.format("-0.5, vertex.normal, keepPosition"), L_SHAPE))
    assert measure.volumes(out)[0] > 0.0
    assert world_meshes(sampled(rule.format("0"), SKEW)).num_faces > 0


def test_a_face_of_six_corners_does_not_change():
    rule = 'Lot --> setupProjection(0, scope.xz, 4, 4) projectUV(0) insertAlongUV(0, "builtin:cube", 1) A'
    assert world_meshes(sampled(rule, L_SHAPE)).num_faces == 1


def test_repeats_without_end_end_with_a_message():
    rule = 'Lot --> setupProjection(0, scope.xz, 1e-5, 1e-5) projectUV(0) insertAlongUV(0, "builtin:cube", 1) A'
    with pytest.raises(DerivationError, match=r"would make .* faces"):
        derive(Grammar.parse(rule), 1, seed=1)


def test_repeats_share_their_points():
    rule = 'Lot --> setupProjection(0, scope.xz, 7, 9) projectUV(0) insertAlongUV(0, "builtin:cube", 3) A'
    assert measure.is_closed(joined(world_meshes(sampled(rule, SKEW)))).all()
