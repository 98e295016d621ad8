"""Normals set by rules: the surface stays, and triangles get them through scopes, cuts and batches."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.derivation import Forest
from grammarlab.geometry.meshes import measure
from grammarlab.scene import realize, triangles
from tests.derivation.operations.leaves import sampled, world_meshes


def facets(rule: str, num_models: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Normals of triangles [T, 3] and those of their corners [T, 3, 3]."""
    batch = triangles(realize(sampled(rule, num_models=num_models)))
    a, b, c = (batch.vertices[batch.triangles[:, corner]].astype(float) for corner in range(3))
    flat = np.cross(b - a, c - a)
    return flat / np.linalg.norm(flat, axis=1, keepdims=True), batch.normals[batch.triangles].astype(float)


@pytest.mark.parametrize("mode", ["setNormals(hard)", "softenNormals(0)", "setNormals(conform)"])
def test_hard_normals_are_those_of_the_faces(mode):
    flat, corners = facets(f"Lot --> s(6, 4, 2) primitiveSphere(24, 24) {mode} r(20, 30, 0) A")
    assert np.einsum("ij,ikj->ik", flat, corners) == pytest.approx(np.ones((len(flat), 3)), abs=1e-5)


def test_soft_normals_of_a_sphere_are_radial_and_those_of_an_ellipsoid_are_not():
    def off_radial(size: str) -> float:
        batch = triangles(realize(sampled(f"Lot --> s({size}) primitiveSphere(64, 64) setNormals(soft) A")))
        radial = batch.vertices - batch.vertices.mean(axis=0)
        radial = radial / np.linalg.norm(radial, axis=1, keepdims=True)
        return float(1.0 - np.einsum("ij,ij->i", radial, batch.normals).min())

    assert off_radial("4, 4, 4") < 0.002
    assert off_radial("4, 1, 4") > 0.05


def test_a_limit_below_which_edges_are_soft():
    """The sides of an octagonal prism meet at 45 degrees, its ends at 90."""
    turns = {}
    for angle in (45, 46, 91):
        flat, corners = facets(f"Lot --> primitiveCylinder(8, 4, 6) softenNormals({angle}) A")
        turns[angle] = np.einsum("ij,ikj->ik", flat, corners)
    assert turns[45] == pytest.approx(np.ones_like(turns[45]), abs=1e-6)
    ends = np.abs(flat[:, 1]) > 0.5
    assert turns[46][ends] == pytest.approx(np.ones_like(turns[46][ends]), abs=1e-6)
    assert turns[46][~ends] == pytest.approx(np.full_like(turns[46][~ends], np.cos(np.radians(22.5))), abs=1e-6)
    assert (turns[91] < 0.99).all()


def surface(forest: Forest) -> tuple[list[float], list[float]]:
    meshes = world_meshes(forest)
    return measure.areas(meshes).tolist(), measure.volumes(meshes).tolist()


@pytest.mark.parametrize(
    "rest",
    [
        "A",
        "split(y) { '0.3 : A | ~1 : B }",
        "comp(f) { side : A | top : extrude(1) B }",
        "mirrorScope(true, false, false) s('2, '1, '0.5) A",
    ],
)
def test_normals_change_no_surface(rest):
    rule = "Lot --> primitiveCylinder(8, 4, 6) {} " + rest
    for mode in ("setNormals(soft)", "setNormals(auto)", "softenNormals(50)"):
        for one, other in zip(*(surface(sampled(rule.replace("{}", each, 1))) for each in (mode, "")), strict=True):
            assert one == pytest.approx(other, rel=1e-12)


def test_conform_turns_single_faces_back():
    text = """
    Lot --> inline(append) Mixed setNormals(conform) cleanupGeometry(vertices, 0) A
    Mixed --> extrude(4) comp(f) { top : reverseNormals X. | all : X. }
    """
    assert surface(sampled(text))[1][0] < 2399.0
    joined = text.replace(
        "setNormals(conform) cleanupGeometry(vertices, 0)", "cleanupGeometry(vertices, 0) setNormals(conform)"
    )
    assert surface(sampled(joined))[1] == pytest.approx([2400.0])


def test_models_of_a_batch_have_the_normals_of_each():
    rule = "Lot --> s(rand(2, 9), 4, 4) primitiveSphere(12, 12) softenNormals(rand(0, 180)) A"
    flat, corners = facets(rule, num_models=3)
    whole, alone = sampled(rule, num_models=3), sampled(rule)
    assert len(flat) % 3 == 0
    one = facets(rule)
    assert np.array_equal(corners[: len(one[1])], one[1])
    assert whole.leaves.size[0].tolist() == alone.leaves.size[0].tolist()
