"""Trees along streets: at their distance from the middle, clear of everything, and independent of other streets."""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.city.street_lines import StreetLines
from grammarlab.city.street_trees import street_tree_places

RULES = {"spacing": 10.0, "offset": 1.5, "least_width": 8.0}
NOTHING = np.zeros(0, object)


def streets(*rows: tuple[list[tuple[float, float]], float]) -> StreetLines:
    lines = np.array([shapely.LineString(points) for points, _ in rows], dtype=object)
    return StreetLines(lines, np.array([width for _, width in rows]))


def test_trees_stand_on_both_sides_at_equal_distances():
    places = street_tree_places(streets(([(0, 0), (100, 0)], 12.0)), NOTHING, **RULES)
    expected = [(x, y) for y in (4.5, -4.5) for x in range(5, 100, 10)]
    assert np.allclose(places, expected)


def test_narrow_streets_and_those_of_unknown_width_have_none():
    narrow = streets(([(0, 0), (100, 0)], 7.9), ([(0, 50), (100, 50)], np.nan))
    assert len(street_tree_places(narrow, NOTHING, **RULES)) == 0


def test_no_tree_stands_on_a_crossing_street_or_on_a_parcel():
    crossing = streets(([(0, 0), (100, 0)], 12.0), ([(50, -60), (50, 60)], 10.0))
    parcel = shapely.box(20, 3, 40, 30)
    places = street_tree_places(crossing, np.array([parcel], object), **RULES)
    points = shapely.points(places)
    assert shapely.distance(points, parcel).min() > 1.0
    along = np.abs(places[:, 1]) < 5
    assert np.abs(places[along, 0] - 50).min() > 5.0
    assert len(places)


def test_another_street_far_away_changes_nothing():
    one = streets(([(0, 0), (70, 30)], 12.0))
    two = streets(([(0, 0), (70, 30)], 12.0), ([(500, 0), (500, 90)], 12.0))
    alone, both = (street_tree_places(lines, NOTHING, **RULES) for lines in (one, two))
    assert {tuple(place) for place in alone} < {tuple(place) for place in both}
