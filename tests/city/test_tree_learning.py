"""Intensities are learned from trees: where they stand densely, and where there is nothing to learn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from grammarlab.city import tree_learning
from grammarlab.city.tree_intensity import trees_in
from grammarlab.city.tree_learning import learned_intensity
from grammarlab.errors import UsageError
from tests.city.test_tree_intensity import AREA, FRAME, TINY, intensity


def test_an_intensity_is_learned_from_its_trees():
    model = intensity(30.0, 8.0, slope=1.5)
    trees = trees_in(AREA, model, TINY, 2)
    names = np.array(model.species, object)[trees.species]
    learned = learned_intensity(trees.east_north, names, AREA, FRAME)
    assert learned.species == ("lime", "oak")
    axis = np.arange(25.0, 600, 50)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    error = np.log(learned.at(grid)) - np.log(model.at(grid))[:, ::-1]  # ty: ignore[invalid-argument-type]
    assert np.sqrt((error**2).mean(axis=0)).max() < 0.3


def test_even_trees_have_an_even_intensity():
    trees = trees_in(AREA, intensity(20.0), [0.01], 8)
    learned = learned_intensity(trees.east_north, np.full(len(trees), "oak", object), AREA, FRAME)
    values = learned.at(np.random.default_rng(0).uniform(0, 600, (200, 2)))
    assert values.std() < 0.15 * values.mean()
    assert values.mean() == pytest.approx(len(trees) / 36, rel=0.02)


def test_the_order_of_trees_changes_nothing():
    area = shapely.box(0, 0, 200, 200)
    trees = trees_in(area, intensity(40.0, 15.0, slope=1.0), TINY, 8)
    names, order = np.array(["oak", "lime"], object)[trees.species], np.arange(len(trees))[::-1]
    one = learned_intensity(trees.east_north, names, area, FRAME)
    other = learned_intensity(trees.east_north[order], names[order], area, FRAME)
    np.testing.assert_array_equal(one.weights, other.weights)


def test_some_cells_of_a_large_area_are_enough(monkeypatch: pytest.MonkeyPatch):
    model = intensity(60.0, slope=1.5)
    trees = trees_in(AREA, model, TINY[:1], 2)
    names = np.full(len(trees), "oak", object)
    monkeypatch.setattr(tree_learning, "_MAX_CELLS", 300)
    learned = learned_intensity(trees.east_north, names, AREA, FRAME)
    points = np.random.default_rng(1).uniform(50, 550, (200, 2))
    error = np.log(learned.at(points)) - np.log(model.at(points))
    assert np.sqrt((error**2).mean()) < 0.35
    shift = np.array([1000.0, -2000.0])
    moved = learned_intensity(
        trees.east_north - shift,
        names,
        shapely.transform(AREA, lambda points: points - shift),
        replace(FRAME, origin=(FRAME.origin[0] + 1000.0, FRAME.origin[1] - 2000.0)),
    )
    np.testing.assert_allclose(moved.at(points - shift), learned.at(points), rtol=0.01)  # cells at equal distances
    assert moved.trees == learned.trees


def test_areas_without_room_are_refused():
    oak = np.array(["oak"], object)
    with pytest.raises(UsageError, match="expected 1 to 32 species in the area, found 0"):
        learned_intensity(np.zeros((1, 2)), oak, shapely.Polygon(), FRAME)
    with pytest.raises(UsageError, match="at most 4,000,000 cells"):
        learned_intensity(np.ones((1, 2)), oak, shapely.box(0, 0, 1e5, 1e5), FRAME)
    names = np.array([f"s{number}" for number in range(33)], object)
    with pytest.raises(UsageError, match="expected 1 to 32 species in the area, found 33"):
        learned_intensity(np.ones((33, 2)), names, AREA, FRAME)
