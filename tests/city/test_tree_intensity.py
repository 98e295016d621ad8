"""Trees are drawn with their intensity, by address."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from scipy.stats import chisquare

from grammarlab.city.tree_intensity import CELL, TreeIntensity, trees_in
from grammarlab.geometry.footprints.frame import Frame

FRAME = Frame("EPSG:32631", (448000.0, 5412000.0))
AREA = shapely.box(0, 0, 600, 600)
TINY = [0.01, 0.01]


def intensity(*per_hectare: float, slope: float = 0.0) -> TreeIntensity:
    return TreeIntensity(
        species=("oak", "lime")[: len(per_hectare)],
        frame=FRAME,
        intercept=np.log(per_hectare),
        places=np.array([[0.0, 0.3]]),
        weights=np.full((1, len(per_hectare)), slope),
        length=np.full(len(per_hectare), 0.4),
        trees="0" * 64,
    )


def test_trees_have_their_intensity_without_crowns():
    """Counts of cells of 100 m are Poisson: chi-squared against their expectation."""
    model = intensity(30.0, 12.0, slope=1.0)
    trees = trees_in(AREA, model, TINY, 5)
    for number in (0, 1):
        points = trees.east_north[trees.species == number]
        counts = np.histogram2d(*points.T, bins=6, range=[[0, 600]] * 2)[0].ravel()
        axis = np.arange(5.0, 600, 10)
        grid = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
        expected = np.histogram2d(*grid.T, bins=6, range=[[0, 600]] * 2, weights=model.at(grid)[:, number] / 100)[0]  # ty: ignore[invalid-argument-type, no-matching-overload]
        assert abs(counts.sum() - expected.sum()) < 4 * np.sqrt(expected.sum())
        scaled = expected.ravel() * counts.sum() / expected.sum()
        assert chisquare(counts, scaled).pvalue > 1e-3


def test_as_many_trees_stand_after_thinning():
    trees = trees_in(shapely.box(0, 0, 2000, 2000), intensity(40.0), [5.0], 1)
    assert abs(len(trees) - 16_000) < 0.04 * 16_000


def test_no_tree_is_within_the_crown_of_another():
    trees = trees_in(shapely.box(0, 0, 300, 300), intensity(80.0, 60.0), [6.0, 3.0], 3)
    radius = np.array([6.0, 3.0])[trees.species]
    distance = np.hypot(*(trees.east_north[:, None] - trees.east_north).transpose(2, 0, 1))
    distance[np.diag_indices(len(trees))] = np.inf
    assert (distance >= (radius[:, None] + radius) / 2).all()


def test_a_part_of_an_area_has_the_trees_of_the_whole_inside_it():
    model = intensity(80.0, 60.0, slope=0.5)
    whole = trees_in(AREA, model, [5.0, 4.0], 3)
    part = shapely.Point(300, 300).buffer(150)
    inside = shapely.contains_xy(part, *whole.east_north.T)
    trees = trees_in(part, model, [5.0, 4.0], 3)
    np.testing.assert_array_equal(trees.model, whole.model[inside])
    np.testing.assert_array_equal(trees.east_north, whole.east_north[inside])
    parts = trees_in(shapely.MultiPolygon([part, shapely.box(0, 0, 50, 50)]), model, [5.0, 4.0], 3)
    assert set(trees.model.tolist()) < set(parts.model.tolist())


def test_another_origin_moves_no_tree():
    model = intensity(50.0)
    other = replace(model, frame=Frame(FRAME.crs, (447000.0, 5410000.0)), places=model.places + np.array([1.0, 2.0]))
    trees = trees_in(AREA, model, [4.0], 9)
    moved = trees_in(shapely.transform(AREA, lambda points: points + np.array([1000.0, 2000.0])), other, [4.0], 9)
    np.testing.assert_array_equal(moved.model, trees.model)
    np.testing.assert_allclose(moved.east_north - [1000.0, 2000.0], trees.east_north, atol=1e-6)


def test_a_denser_forest_has_the_candidates_of_a_sparser_one():
    sparse, dense = (trees_in(AREA, intensity(number), [0.01], 4) for number in (20.0, 60.0))
    assert set(sparse.model.tolist()) <= set(dense.model.tolist())


def test_one_species_keeps_its_candidates_whatever_the_others_are():
    both, alone = trees_in(AREA, intensity(30.0, 10.0), TINY, 4), trees_in(AREA, intensity(30.0), TINY[:1], 4)
    shared = np.isin(alone.model, both.model[both.species == 0])
    assert shared.mean() > 0.99  # crowns of one centimetre


def test_species_along_streets_have_the_shares_of_their_intensities():
    model = intensity(30.0, 10.0)
    points = np.random.default_rng(0).uniform(0, 600, (4000, 2))
    ids = np.array([f"tree {number}" for number in range(4000)], object)
    species = model.species_at(points, ids, 5)
    assert abs((species == 0).mean() - 0.75) < 4 * np.sqrt(0.75 * 0.25 / 4000)
    np.testing.assert_array_equal(model.species_at(points[7:9], ids[7:9], 5), species[7:9])
    assert (model.species_at(points, ids, 6) != species).any()


def test_no_area_has_no_trees():
    assert len(trees_in(shapely.MultiPolygon(), intensity(30.0), [4.0], 1)) == 0


def test_cells_divide_the_grid_of_frames():
    assert 1000.0 % CELL == 0.0
