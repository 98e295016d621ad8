"""Overlays have a result for every row, and one that fails changes no other."""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.city.outline_overlay import merged, overlaid

BOX = shapely.box(0, 0, 4, 4)
BOW = shapely.Polygon([(0, 0), (4, 4), (4, 0), (0, 4)])


def test_a_row_that_fails_is_repaired_and_others_stay_as_they_are():
    one = np.array([BOX, BOW, shapely.box(1, 1, 9.1, 9.3)], dtype=object)
    other = np.array([shapely.box(2, 0, 9, 9), shapely.box(-1, -1, 9, 1), BOX], dtype=object)
    result = overlaid(shapely.difference, one, other)
    good = [0, 2]
    expected = shapely.difference(one[good], other[good])
    assert shapely.to_wkb(result[good]).tolist() == shapely.to_wkb(expected).tolist()
    assert result[1].is_valid
    assert result[1].area > 3.0


def test_members_of_collections_are_merged():
    groups = np.array([shapely.GeometryCollection([BOX, shapely.box(2, 2, 6, 6)]), shapely.GeometryCollection()])
    assert shapely.area(merged(groups)).tolist() == [28.0, 0.0]
    broken = np.array([shapely.GeometryCollection([BOW, BOX]), groups[0]])
    assert shapely.area(merged(broken)).tolist() == [16.0, 28.0]
