"""Polygons cut by squares: the parts fill the polygons, and each is in one square."""

from __future__ import annotations

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from grammarlab.city.map_squares import cut_by_squares

COURT = shapely.box(-13, -7, 22, 31) - shapely.box(-4, 3, 11, 18)
SHAPES = np.array(
    [shapely.box(1, 1, 2, 2), COURT, shapely.Polygon([(-40, -3), (55, 2), (-30, 60)]), shapely.box(-5, 100, 90, 103)],
    dtype=object,
)


@settings(max_examples=20, deadline=None)
@given(st.sampled_from([1.5, 5.0, 12.0, 500.0]), st.floats(-30, 30), st.floats(-30, 30))
def test_parts_fill_their_polygons_square_by_square(side: float, east: float, north: float):
    shapes = shapely.transform(SHAPES, lambda points: points + np.array([east, north]))
    parts, row = cut_by_squares(shapes, side)
    assert (np.diff(row) >= 0).all()
    areas = np.bincount(row, shapely.area(parts), len(shapes))
    assert np.allclose(areas, shapely.area(shapes), atol=0.01 * np.bincount(row).max())
    for number, shape in enumerate(shapes):
        assert shapely.difference(shapely.union_all(parts[row == number]), shapely.buffer(shape, 1e-6)).area < 1e-6
    low, high = shapely.bounds(parts)[:, :2] / side, shapely.bounds(parts)[:, 2:] / side
    assert (np.ceil(high - 1e-9) - np.floor(low + 1e-9) <= 1).all()


def test_nothing_is_cut_into_nothing():
    parts, row = cut_by_squares(np.zeros(0, object), 5.0)
    assert len(parts) == len(row) == 0
