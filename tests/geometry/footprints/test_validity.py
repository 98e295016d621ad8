"""Bad outlines: repaired if hardly anything changes, otherwise listed with reason and position."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints import placing
from grammarlab.geometry.footprints.footprint_text import read_footprint_map, read_footprints
from tests.geometry.footprints.maps import BOW_TIE, SQUARE, area, collection, feature, moved, polygon, written

SPIKE = [[0, 0], [100, 0], [100, 100], [60, 100], [50, 101], [60, 101], [50, 100], [0, 100], [0, 0]]
"""A square of 100 m whose edge crosses itself in a bow tie of 5 square metres."""


def read(folder, *polygons):
    return read_footprint_map(written(folder, collection(*(feature(one) for one in polygons), crs=None)))


def test_of_five_outlines_the_bow_tie_is_listed(tmp_path):
    lots = [polygon(moved(SQUARE, 20 * k, 0)) for k in range(5)]
    plan = read(tmp_path, *lots[:2], polygon(BOW_TIE), *lots[3:])
    assert [area(footprint) for footprint in plan.footprints] == [80] * 4
    (remark,) = plan.remarks
    assert (str(remark), remark.kind) == ("lots.geojson, feature 2: self-intersection at x = 45, y = 4", "outline")


def test_an_outline_that_hardly_changes_is_repaired(tmp_path):
    plan = read(tmp_path, polygon(SPIKE))
    assert [area(footprint) for footprint in plan.footprints] == pytest.approx([10_000], rel=0.001)
    (remark,) = plan.remarks
    assert (remark.kind, remark.reason) == ("repair", "self-intersection at x = 55, y = 100.5")


def test_two_outlines_drawn_as_one_are_two(tmp_path):
    eight = [[0, 0], [10, 0], [10, 8], [20, 8], [20, 16], [10, 16], [10, 8], [0, 8], [0, 0]]
    plan = read(tmp_path, polygon(eight))
    assert sorted(area(footprint) for footprint in plan.footprints) == [80, 80]
    assert plan.remarks[0].reason == "ring self-intersection at x = 10, y = 8, in 2 pieces"


@pytest.mark.parametrize(
    ("rings", "reason"),
    [
        ([SQUARE[:-1] + SQUARE], "self-intersection"),  # twice around
        ([SQUARE, moved(SQUARE, 20, 0)], "hole lies outside"),
        ([SQUARE, moved(SQUARE, 5, 0)], "self-intersection"),
        ([[[0, 0], [5, 0], [9, 0], [0, 0]]], "self-intersection"),
        ([[[0, 0]] * 4], "too few points"),
        ([[[0, 0], [1e-3, 0], [0, 1e-3], [0, 0]]], "too small"),
        ([[[0, 0], [30_000, 0], [0, 10], [0, 0]]], "at most"),
        ([[[0, 0], [1e9, 0], [0, 10], [0, 0]]], "farther away"),
    ],
)
def test_outlines_without_a_meaning_are_listed(tmp_path, rings, reason):
    plan = read(tmp_path, polygon(*rings), polygon(SQUARE))
    assert len(plan.footprints) == 1
    (remark,) = plan.remarks
    assert reason in remark.reason
    assert "x = " in remark.reason


def test_holes_without_an_area_are_left_out(tmp_path):
    holes = [[[2, 2], [3, 2], [3, 2], [2, 2]], [[5, 5], [5.001, 5], [5, 5.001], [5, 5]]]
    for hole in holes:
        (footprint,) = read(tmp_path, polygon(SQUARE, hole)).footprints
        assert len(footprint.polygon) == 4


def test_corners_that_rounding_doubles_are_one(tmp_path):
    ring = [[0, 0], [1e-9, 1e-9], [10, 0], [10, 8], [0, 8], [-1e-9, 1e-9], [0, 0]]
    (footprint,) = read(tmp_path, polygon(ring)).footprints
    assert len(footprint.polygon) == 4
    assert footprint.polygon[1] - footprint.polygon[0] == pytest.approx([10, 0, 0], abs=1e-6)


def test_python_is_warned_of_what_is_left_out(tmp_path):
    file = written(tmp_path, collection(feature(polygon(SQUARE)), feature(polygon(BOW_TIE)), crs=None))
    with pytest.warns(UserWarning, match="feature 1: self-intersection at x = 45, y = 4"):
        assert len(read_footprints(file)) == 1


def test_one_outline_written_by_hand_is_an_error_if_it_is_bad():
    for text in (shapely.Polygon(SPIKE).wkt, shapely.Polygon(BOW_TIE).wkt):
        with pytest.raises(AssetError, match="self-intersection at x ="):
            read_footprint_map(text)


coordinates = st.integers(0, 12)


@given(st.lists(st.tuples(coordinates, coordinates), min_size=4, max_size=8))
def test_repairs_keep_the_area_that_was_drawn(corners):
    """By the shoelace formula, in whole numbers."""
    ring = shapely.Polygon(corners)
    assume(not ring.is_valid)
    drawn = abs(sum(x * v - u * y for (x, y), (u, v) in pairwise([*corners, corners[0]]))) / 2
    try:
        parts, fault = placing.repaired(ring, "metres")
    except placing.BadOutlineError:
        return
    assert fault
    assert all(part.is_valid for part in parts)
    assert sum(part.area for part in parts) == pytest.approx(drawn, rel=2 * placing.AREA_TOLERANCE)
    assert np.isfinite([part.bounds for part in parts]).all()
