"""Areas, bounds and faces that another CGA runtime has measured for the same operations on the same two footprints."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import derive
from grammarlab.language.grammar import Grammar
from grammarlab.scene import realize, triangles
from tests.derivation.operations.leaves import world_meshes

RECTANGLE = np.array([[0.0, 0, 0], [0, 0, 20], [30, 0, 20], [30, 0, 0]])
L_SHAPE = np.array([[0.0, 0, 0], [0, 0, 12], [8, 0, 12], [8, 0, 22], [26, 0, 22], [26, 0, 0]])


def measured(rules: str, footprint: np.ndarray) -> tuple[int, float, list[list[float]]]:
    """Polygons, square metres, and the smallest and largest coordinates of the only model."""
    forest = derive(Grammar.parse(rules), 1, seed=0, footprint=footprint)
    batch = triangles(realize(forest))
    a, b, c = (batch.vertices[batch.triangles[:, corner]].astype(float) for corner in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    bounds = [batch.vertices.min(axis=0).tolist(), batch.vertices.max(axis=0).tolist()]
    return world_meshes(forest).num_faces, float(area), bounds


@pytest.mark.parametrize(
    ("rules", "footprint", "polygons", "area", "far_corner"),
    [
        ("Lot --> extrude(10)", RECTANGLE, 6, 2200.0, [30, 10, 20]),
        ("Lot --> extrude(10)", L_SHAPE, 8, 1944.0, [26, 10, 22]),
        ("Lot --> extrude(1) comp(f) { all : A }", RECTANGLE, 6, 1300.0, [30, 1, 20]),
        ("Lot --> extrude(1) comp(f) { all : A }", L_SHAPE, 8, 1080.0, [26, 1, 22]),
        ('Lot --> i("builtin:cube")', RECTANGLE, 6, 3700.0, [30, 25, 20]),
        ('Lot --> i("builtin:cube")', L_SHAPE, 6, 3448.0, [26, 24, 22]),
        ("Lot --> alignScopeToAxes() t(0, 0, 0)", RECTANGLE, 1, 600.0, [30, 0, 20]),
        ("Lot --> alignScopeToAxes() t(0, 0, 0)", L_SHAPE, 1, 492.0, [26, 0, 22]),
        ("Lot --> extrude(15.456175208091736)", RECTANGLE, 6, 2745.6175208091736, [30, 15.456175208091736, 20]),
        ("Lot --> extrude(15.456175208091736)", L_SHAPE, 8, 2467.7928199768066, [26, 15.456175208091736, 22]),
    ],
)
def test_simple_masses_are_as_the_other_runtime_measured_them(rules, footprint, polygons, area, far_corner):
    found = measured(rules, footprint)
    assert found[0] == polygons
    assert found[1] == pytest.approx(area, rel=1e-6)
    assert np.allclose(found[2], [[0, 0, 0], far_corner], atol=1e-5)


@pytest.mark.parametrize(
    ("footprint", "area", "low", "high"),
    [(RECTANGLE, 2100.0, [0, 0, 0], [30, 3, 20]), (L_SHAPE, 1428.0, [8, 0, 0], [26, 3, 22])],
)
def test_the_largest_inner_rectangle_is_the_one_that_the_other_runtime_finds(footprint, area, low, high):
    rules = "Lot --> innerRectangle(edge) { shape : A extrude(world.up, 3) comp(f) { all : B } | remainder : NIL }"
    polygons, found, bounds = measured(rules, footprint)
    assert polygons == 7
    assert found == pytest.approx(area, rel=1e-4)
    assert np.allclose(bounds, [low, high], atol=0.01)
