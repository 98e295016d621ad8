"""What the general geometry path costs: 4,000 hexagons, and 1,000 cylinders and stars of 18 and 12 faces."""

from __future__ import annotations

import numpy as np
import pytest

from grammarlab.geometry.components import edges, faces
from grammarlab.geometry.meshes.clip import slabs
from grammarlab.geometry.meshes.extrude import extrude
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.meshes.primitives import cylinder, star
from grammarlab.geometry.meshes.triangulate import triangulate

NUM_HEXAGONS, NUM_SOLIDS = 4_000, 1_000
ROWS = np.arange(NUM_SOLIDS)
SOLIDS = {"cylinders": cylinder, "stars": star}


def hexagons():
    angles = np.sort(np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (NUM_HEXAGONS, 6)), axis=1)
    corners = np.stack((np.cos(angles), np.sin(angles), np.zeros_like(angles)), axis=2)
    return Meshes.from_polygons(corners.reshape(-1, 3), np.full(NUM_HEXAGONS, 6))


@pytest.mark.parametrize("planes", [0, 1, 2])
def test_clip_hexagons(benchmark, planes):
    rows = np.arange(NUM_HEXAGONS)
    low = np.full(NUM_HEXAGONS, -0.3 if planes else -2.0)
    high = np.full(NUM_HEXAGONS, 0.3 if planes == 2 else 2.0)
    meshes = hexagons()
    benchmark(slabs, meshes, rows, 0, low, high)


@pytest.mark.parametrize("name", SOLIDS)
def test_clip_solids_between_two_planes(benchmark, name):
    meshes = Meshes.concatenate([SOLIDS[name]()] * NUM_SOLIDS)
    benchmark(slabs, meshes, ROWS, 0, np.full(NUM_SOLIDS, 0.3), np.full(NUM_SOLIDS, 0.6))


@pytest.mark.parametrize("name", SOLIDS)
def test_triangulate_solids(benchmark, name):
    benchmark(triangulate, Meshes.concatenate([SOLIDS[name]()] * NUM_SOLIDS))


@pytest.mark.parametrize("take_apart", [faces, edges])
def test_take_cylinders_apart(benchmark, take_apart):
    benchmark(take_apart, Meshes.concatenate([cylinder()] * NUM_SOLIDS))


def test_extrude_hexagons(benchmark):
    benchmark(extrude, hexagons(), np.ones(NUM_HEXAGONS))
