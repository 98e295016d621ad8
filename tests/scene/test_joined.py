"""Scenes put together and taken apart: the same models with the same triangles."""

from __future__ import annotations

import numpy as np
import pytest

import grammarlab as gl
from grammarlab.errors import UsageError
from grammarlab.scene import realize, triangles
from grammarlab.scene.joined import joined, of_models

TOWERS = 'Lot --> extrude(rand(3, 9)) comp(f) { side : color("#aa3322") Wall. | top : roofHip(30) Roof. }'
BLOCKS = 'Lot --> split(x) { ~1 : extrude(2) A | ~2 : extrude(4) color("#223344") B }'
TEXTURED = 'Lot --> extrude(3) setupProjection(0, scope.xy, 1, 1) texture("wall.png") projectUV(0) Wall.'


def scene(rules: str, num: int, seed: int = 1):
    return realize(gl.derive(gl.Grammar.parse(rules), num, seed=seed))


def model_of(part, index: int):
    batch = triangles(part).model(index)
    return [
        (batch.materials.channels[material].tolist(), batch.materials.textures[material], corners.tolist())
        for material, corners in zip(
            batch.material_of_triangle().tolist(), batch.vertices[batch.triangles], strict=True
        )
    ]


def test_joined_models_have_the_triangles_and_materials_that_they_had():
    parts = [scene(TOWERS, 2), scene(BLOCKS, 1), scene(TEXTURED, 2)]
    whole = joined(parts)
    alone = [model_of(part, index) for part in parts for index in range(part.num_models)]
    assert [model_of(whole, index) for index in range(whole.num_models)] == alone


def test_texture_coordinates_stay():
    parts = [scene(TEXTURED, 1), scene(BLOCKS, 1), scene(TEXTURED, 1, seed=2)]
    whole, last = triangles(joined(parts)).model(2), triangles(parts[2]).model(0)
    assert np.array_equal(whole.texture_maps[whole.texture_map], last.texture_maps[last.texture_map])


@pytest.mark.parametrize("models", [[2], [0, 2], [2, 0], []])
def test_models_of_a_scene_are_those_alone(models: list[int]):
    whole = scene(TOWERS, 3)
    some = of_models(whole, np.array(models, np.int64))
    assert some.num_models == len(models)
    assert [model_of(some, index) for index in range(len(models))] == [model_of(whole, model) for model in models]
    assert np.array_equal(some.origins, whole.origins[models])


def test_a_model_may_be_taken_several_times():
    whole = scene(TOWERS, 2)
    twice = of_models(whole, np.array([1, 1]))
    assert model_of(twice, 0) == model_of(twice, 1) == model_of(whole, 1)


def test_scenes_with_normals_of_their_own_are_not_joined():
    with pytest.raises(UsageError, match="normals follow"):
        joined([])
