"""Planting of trees on areas."""

from __future__ import annotations

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.geometry.footprints.area import read_area
from grammarlab.randomness import Keys, root_keys, uniforms
from grammarlab.trees.planting import Spacing, planted


def _crowns(models: Keys) -> Floats:
    """Radii of 2 to 4 m."""
    return 2.0 + 2.0 * uniforms(root_keys(0, models), 3)


def test_measure_densities(benchmark):
    benchmark(lambda: Spacing(_crowns, 5).densities)


def test_plant_500_trees_on_100_hectares(benchmark):
    spacing, area = Spacing(_crowns, 5), read_area("1000x1000")
    _ = spacing.densities
    assert len(benchmark(planted, area, spacing, limit=500)) == 500


def test_fill_20_hectares(benchmark):
    spacing, area = Spacing(_crowns, 5), read_area("500x400")
    _ = spacing.densities
    planting = benchmark(planted, area, spacing, density=1e4)
    benchmark.extra_info |= {"trees": len(planting), "cover": float(np.pi * (planting.radius**2).sum() / area.size)}
