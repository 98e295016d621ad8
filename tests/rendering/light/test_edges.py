"""Edges and smoothing on small hand-made pictures."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.rendering.light.breaks import edge_strength, find_breaks, smooth


def plane(height=12, width=16):
    """A flat wall that faces the eye, one unit between samples."""
    row, column = np.mgrid[:height, :width].astype(np.float32)
    points = np.stack([column, -row, np.zeros_like(row)], axis=2)
    normals = np.zeros_like(points)
    normals[..., 2] = 1
    return np.ones((height, width), bool), points, normals


def test_a_flat_wall_has_no_edges():
    shows, points, normals = plane()
    assert not edge_strength(shows, find_breaks(shows, points, normals, 1.0)).any()


@pytest.mark.parametrize("change", ["silhouette", "jump", "crease"])
def test_an_edge_is_drawn_on_the_model_along_the_line_where_it_changes(change):
    shows, points, normals = plane()
    if change == "silhouette":
        shows[:, 8:] = False
    elif change == "jump":
        points[:, 8:, 2] -= 50
    else:
        normals[:, 8:] = (1, 0, 0)
        points[:, 8:, 2] = -(points[:, 8:, 0] - 8)
    strength = edge_strength(shows, find_breaks(shows, points, normals, 1.0))
    drawn = {7} if change == "silhouette" else {7, 8}
    assert set(np.flatnonzero(strength.any(axis=0)).tolist()) == drawn
    assert (strength[:, 7] == strength[0, 7]).all()


def test_smoothing_levels_whatever_repeats_every_four_samples():
    shows, points, normals = plane()
    pattern = np.random.default_rng(1).random((4, 4)).astype(np.float32)
    values = np.tile(pattern, (3, 4))
    levelled = smooth(values, find_breaks(shows, points, normals, 1.0))[2:-2, 2:-2]
    assert levelled == pytest.approx(np.full(levelled.shape, pattern.mean()), abs=1e-6)


def test_smoothing_never_crosses_a_break():
    shows, points, normals = plane()
    points[:, 8:, 2] -= 50
    values = np.zeros(shows.shape, np.float32)
    values[:, 8:] = 1
    assert np.array_equal(smooth(values, find_breaks(shows, points, normals, 1.0)), values)
