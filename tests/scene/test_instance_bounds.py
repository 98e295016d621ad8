"""Boxes without placed points are those of the placed points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from grammarlab.scene.instance_bounds import instance_bounds, scene_bounds
from grammarlab.scene.layout import model_bounds
from grammarlab.scene.triangles import triangles
from tests.scene.buildings import house, scene_of


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.0, 90.0, 0.0), (10.0, 37.0, -20.0)])
def test_boxes_are_those_of_the_placed_points(angles):
    scene = scene_of([house(), [], house(12.0, 5)])
    turn = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
    scene = replace(scene, frames=turn @ scene.frames, position=scene.position @ turn.T)
    low, high = scene_bounds(scene)
    target_low, target_high = model_bounds(triangles(scene))
    np.testing.assert_allclose(low, target_low, atol=1e-4)
    np.testing.assert_allclose(high, target_high, atol=1e-4)


def test_boxes_of_instances_contain_them():
    scene = scene_of([house()])
    alone = replace(scene, num_models=len(scene), model=np.arange(len(scene), dtype=np.int32))
    turn = Rotation.from_euler("xyz", (10.0, 37.0, -20.0), degrees=True).as_matrix()
    low, high = instance_bounds(replace(scene, frames=turn @ scene.frames))
    alone = replace(alone, frames=turn @ scene.frames, origins=np.zeros((len(scene), 3)))
    target_low, target_high = model_bounds(triangles(alone))
    assert (low <= target_low + 1e-4).all()
    assert (high >= target_high - 1e-4).all()
