"""Merged triangles are the scene: the same surface, ordered by model, one model as if alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grammarlab.assets.mesh_files import AssetFolder
from grammarlab.derivation import derive
from grammarlab.geometry.meshes import measure
from grammarlab.language.importing import load
from grammarlab.scene import realize, triangles
from grammarlab.scene.triangles import leaf_of_triangle
from tests.derivation.operations.leaves import world_meshes

GRAMMARS = Path(__file__).parents[2] / "grammars"
ASSETS = AssetFolder(GRAMMARS / "assets")


def forest_of(name: str, num_models: int = 3, first_model: int = 0):
    return derive(load(GRAMMARS / f"{name}.cga"), num_models, 5, first_model=first_model, assets=ASSETS)


def triangle_areas(batch) -> np.ndarray:
    a, b, c = (batch.vertices[batch.triangles[:, i]].astype(float) for i in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


@pytest.mark.parametrize("name", ["toy", "furniture", "building", "airplane"])
def test_triangles_have_the_surface_of_the_leaves(name):
    forest = forest_of(name)
    model = forest.nodes.model[forest.leaves.node]
    expected = np.bincount(model, measure.areas(world_meshes(forest)), minlength=3)
    batch = triangles(realize(forest))
    found = [triangle_areas(batch.model(index)).sum() for index in range(3)]
    assert found == pytest.approx(expected.tolist(), rel=1e-4)


@pytest.mark.parametrize("name", ["toy", "furniture", "building", "airplane"])
def test_the_triangles_of_a_leaf_have_its_surface(name):
    forest = forest_of(name)
    areas = triangle_areas(triangles(realize(forest)))
    found = np.bincount(leaf_of_triangle(forest), areas, minlength=len(forest.leaves))
    assert np.allclose(found, measure.areas(world_meshes(forest)), rtol=1e-3, atol=1e-4)


def test_one_model_of_a_batch_is_the_model_alone():
    together = triangles(realize(forest_of("furniture", 4))).model(2)
    alone = triangles(realize(forest_of("furniture", 1, first_model=2))).model(0)
    assert np.allclose(together.vertices, alone.vertices, atol=1e-5)
    assert np.array_equal(together.triangles, alone.triangles)


@pytest.mark.parametrize("name", ["furniture", "building"])
def test_normals_are_unit_vectors_on_the_side_of_their_triangles(name):
    batch = triangles(realize(forest_of(name, 1)))
    a, b, c = (batch.vertices[batch.triangles[:, i]].astype(float) for i in range(3))
    flat = np.cross(b - a, c - a)
    large = np.linalg.norm(flat, axis=1) > 1e-6
    normal = batch.normals[batch.triangles[:, 0]]
    assert np.allclose(np.linalg.norm(batch.normals, axis=1), 1.0, atol=1e-4)
    assert (np.einsum("ij,ij->i", flat, normal)[large] > 0.0).all()
