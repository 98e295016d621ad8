from typing import Any

import numpy as np
import pytest
import shapely
from scipy.stats import kstest

from grammarlab.arrays import offsets_from_counts
from grammarlab.city.plot_cuts import Plots
from grammarlab.city.shared_corners import with_shared_corners
from grammarlab.city.subdivision import PlotTree, SizeColumns, subdivided
from grammarlab.randomness import root_keys


def blocks_of(*polygons: Any) -> Plots:
    rings = [np.array(shapely.orient_polygons(polygon).exterior.coords)[:-1] for polygon in polygons]
    corners = np.concatenate(rings)
    return Plots(corners, np.ones(len(corners), dtype=bool), offsets_from_counts(np.array([len(r) for r in rings])))


def parcels_of(blocks: Plots, seed: int = 1, **sizes: float) -> PlotTree:
    values = {"area": 250.0, "spread": 0.8, "frontage": 5.0, "aspect": 1.4, "aspect_spread": 0.5} | sizes
    columns = SizeColumns(**{name: np.full(len(blocks), value) for name, value in values.items()})
    return subdivided(blocks, root_keys(seed, np.arange(len(blocks))), columns)


SHAPES = [
    shapely.box(0, 0, 120, 60),
    shapely.box(200, 0, 230, 220),
    shapely.Polygon([(400, 0), (520, 10), (480, 90), (430, 60), (390, 120)]),
    shapely.Polygon([(600, 0), (720, 0), (660, 110)]),
    shapely.Point(900, 0).buffer(60) - shapely.box(860, -30, 2000, 30),
]


def test_parcels_have_streets_and_fill_their_blocks():
    blocks = blocks_of(*SHAPES)
    tree = parcels_of(blocks)
    assert len(tree.path) > 60
    assert tree.plots.frontage.min() >= 5.0
    both = with_shared_corners(Plots.concatenate([tree.plots, blocks]))
    parcels, whole = both.take(np.arange(len(tree.path))), both.take(np.arange(len(tree.path), len(both)))
    assert shapely.coverage_is_valid(parcels.outline)
    assert np.bincount(tree.block, parcels.area) == pytest.approx(whole.area, rel=1e-12)
    # The ends of cuts are rounded to millimetres, beside the outlines of the blocks.
    assert whole.area == pytest.approx(blocks.area, rel=1e-5)
    outside = shapely.difference(parcels.outline, whole.outline[tree.block])
    assert shapely.area(outside).max() == 0


def test_a_block_has_the_same_parcels_alone_and_among_others():
    blocks = blocks_of(*SHAPES)
    together = parcels_of(blocks)
    for row in range(len(blocks)):
        alone = subdivided(
            blocks.take(np.array([row])),
            root_keys(1, np.array([row])),
            SizeColumns(*(np.full(1, value) for value in (250.0, 0.8, 5.0, 1.4, 0.5))),
        )
        rows = np.flatnonzero(together.block == row)
        assert alone.path.tolist() == together.path[rows].tolist()
        assert alone.plots.corners.tobytes() == together.plots.take(rows).corners.tobytes()


def test_areas_follow_their_distribution_where_every_edge_is_a_street():
    """With very small frontages nothing but the draws decides, so areas are log-normal but for the steps of halving."""
    side = np.arange(20)
    squares = [shapely.box(500 * x, 500 * y, 500 * x + 300, 500 * y + 300) for x in side for y in side]
    blocks = blocks_of(*squares)
    tree = parcels_of(blocks, area=2_000.0, spread=0.8, frontage=1.0, aspect=1.4, aspect_spread=1.5)
    assert kstest(np.log(tree.plots.area), "norm", (np.log(2_000.0), 0.8)).statistic < 0.12


def test_paths_are_leaves_of_one_tree():
    tree = parcels_of(blocks_of(SHAPES[0]))
    paths = set(tree.path.tolist())
    inner = {path >> level for path in paths for level in range(1, path.bit_length())}
    assert not paths & inner
    assert {2 * path + side for path in inner for side in (0, 1)} == (paths | inner) - {1}


def test_no_spread_gives_parcels_of_one_size():
    areas = parcels_of(blocks_of(shapely.box(0, 0, 400, 70)), area=450.0, spread=0.0, aspect_spread=0.3).plots.area
    assert areas.max() / areas.min() < 4
