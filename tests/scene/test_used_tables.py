"""Scenes without unused tables show the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from grammarlab.scene.joined import joined, of_models
from grammarlab.scene.triangles import triangles
from grammarlab.scene.used_tables import with_used_tables
from tests.scene.buildings import BOX, STEEL, UPRIGHT, house, scene_of


def test_triangles_stay_and_tables_shrink():
    scene = joined(
        [scene_of([house()]), scene_of([[(BOX, STEEL, (0, 0, 0), (1, 2, 3), UPRIGHT)]]), scene_of([house()])]
    )
    scene = replace(scene, materials=replace(scene.materials, thin=frozenset([10, 3])))
    alone = of_models(scene, np.array([1]))
    small = with_used_tables(alone)
    assert (len(small.meshes), len(small.materials), len(small.frames)) == (1, 1, 1)
    assert small.materials.thin == {0}
    for part in (scene, alone):
        before, after = triangles(part), triangles(with_used_tables(part))
        np.testing.assert_array_equal(before.vertices, after.vertices)
        np.testing.assert_array_equal(before.triangles, after.triangles)
        colors, target = (batch.materials.color[batch.material_of_triangle()] for batch in (after, before))
        np.testing.assert_array_equal(colors, target)
