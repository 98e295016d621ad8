"""Footprints keep their setbacks, courts and smallest sizes, and begin at their widest street."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from grammarlab.city.building_footprints import (
    LARGE,
    BuildingFootprints,
    FootprintRequest,
    building_footprints,
    joined_rings,
)
from grammarlab.city.lot_edges import LotEdges, simplified
from grammarlab.city.lot_fronts import CORNER_LOT, INNER_LOT, LOT, first_edges, lot_kinds
from grammarlab.city.packed_outlines import Outlines, PackedOutlines
from grammarlab.city.parcel_reasons import NARROW, SMALL
from grammarlab.city.plan import LotRules
from grammarlab.city.street_edges import street_widths
from grammarlab.geometry.lot_sides import FRONT, edge_sides
from tests.city.lot_maps import lot_map

SQUARE = [(0, 0), (40, 0), (40, 40), (0, 40)]
COURT = shapely.Polygon(SQUARE, [[(12, 12), (28, 12), (28, 28), (12, 28)]])


def request(num: int, setbacks: tuple[float, float, float] = (3.0, 2.0, 5.0), **rules: float) -> FootprintRequest:
    return FootprintRequest(
        setbacks=np.tile(setbacks, (num, 1)),
        is_ring=np.zeros(num, bool),
        is_park=np.zeros(num, bool),
        rules=replace(LotRules(), **rules),
    )


def built(
    outlines: list[shapely.Polygon] | Outlines, widths: list[float], wish: FootprintRequest
) -> BuildingFootprints:
    """Footprints on outlines with widths by edge, from the south-west corner counter-clockwise."""
    edges = LotEdges.of(np.array(outlines, dtype=object))
    assert len(widths) == len(edges.points)
    return building_footprints(edges, np.array(widths), wish)


def polygons(result: BuildingFootprints) -> Outlines:
    return result.edges.polygons(result.edges.points)


def test_setbacks_are_by_kind_of_edge():
    result = built([shapely.box(0, 0, 20, 30, ccw=True)], [0.0, 0.0, 0.0, 8.0], request(1))
    assert len(result.edges.points) == 4
    (polygon,) = polygons(result)
    # The box begins in the south-east and goes north: the last edge, in the south, is the front.
    assert polygon.bounds == (2.0, 3.0, 18.0, 25.0)
    assert result.street_width.tolist() == [8.0, 0.0, 0.0, 0.0]
    assert result.edges.points[0].tolist() == [2.0, 3.0]


def test_a_lot_without_a_street_has_its_longest_edge_first():
    result = built([shapely.Polygon([(0, 0), (50, 0), (50, 30), (0, 30)])], [0.0] * 4, request(1))
    assert result.street_width.tolist() == [0.0] * 4
    assert polygons(result)[0].bounds == (2.0, 2.0, 48.0, 25.0)


def test_the_first_edge_is_along_the_widest_street_and_then_the_longest():
    lot = np.array([shapely.Polygon([(0, 0), (50, 0), (50, 30), (0, 30)])], dtype=object)
    edges = LotEdges.of(lot)
    for widths, first in (([8, 12, 0, 0], 1), ([8, 8, 0, 0], 0), ([0, 8, 0, 8], 1), ([0, 0, 0, 0], 0)):
        assert first_edges(edges, np.array(widths, float)).tolist() == [first]


def test_a_building_behind_another_lot_looks_to_the_street():
    """A flag lot touches the street only with a drive that is too narrow for a building."""
    flag = shapely.Polygon([(0, 0), (3, 0), (3, 30), (25, 30), (25, 70), (0, 70)])
    result = built([flag], [8.0] + [0.0] * 5, request(1))
    assert result.street_width.tolist() == [0.0] * 4
    assert result.edges.normal[0].tolist() == [0.0, -1.0]
    assert polygons(result)[0].bounds == pytest.approx((2.0, 32.0, 23.0, 65.0), abs=0.05)


def test_collinear_edges_count_as_one():
    bent = shapely.Polygon([(0, 0), (15, 0), (30, 0.5), (30, 28), (0, 28)])
    edges = LotEdges.of(np.array([bent], dtype=object))
    assert first_edges(edges, np.array([8.0, 8.0, 8.0, 0.0, 0.0])).tolist() == [1]
    # The two parts of the front have one setback, even if only one of them is along the street.
    result = built([bent], [8.0, 0.0, 0.0, 0.0, 0.0], request(1))
    assert np.allclose(shapely.distance(polygons(result)[0], shapely.LineString([(0, 0), (15, 0), (30, 0.5)])), 3.0)


@pytest.mark.parametrize("seed", range(3))
def test_footprints_of_a_map_are_valid_and_inside_their_setbacks(seed: int):
    quarter = lot_map(seed)
    outlines = simplified(quarter.parcels.outline)
    edges = LotEdges.of(outlines)
    widths = street_widths(
        edges, PackedOutlines.of(outlines), np.arange(len(outlines)), quarter.streets, np.zeros(len(outlines), bool)
    )
    wish = request(len(outlines))
    result = building_footprints(edges, widths, wish)
    shapes = polygons(result)
    assert shapely.is_valid(shapes).all()
    lots = outlines[result.lot]
    assert (shapely.area(shapely.difference(shapes, shapely.buffer(lots, -1.97, join_style="mitre"))) < 0.01).all()
    has_front, group = np.unique(edges.outline[widths > 0], return_inverse=True)
    ends = np.stack([edges.points, edges.points[edges.next_corner]], axis=1)[widths > 0]
    lines = np.asarray(shapely.linestrings(ends), dtype=object)
    front = np.array(shapely.multilinestrings(lines, indices=group), dtype=object)
    both = np.intersect1d(has_front, result.lot)
    distance = shapely.distance(shapes[np.searchsorted(result.lot, both)], front[np.searchsorted(has_front, both)])
    assert (distance > 2.97).all()
    # Each front edge of a footprint is parallel to a front edge of its lot, and has its width.
    for row in np.flatnonzero(result.street_width > 0).tolist():
        own = np.flatnonzero((edges.outline == result.lot[result.edges.outline[row]]) & (widths > 0))
        cosine = edges.normal[own] @ result.edges.normal[row]
        assert result.street_width[row] in widths[own[cosine > 0.98]]
    assert (np.bincount(result.edges.outline, result.street_width > 0) > 0).sum() >= 0.9 * len(both)


def test_small_narrow_and_large_lots_stay_empty():
    lots = [shapely.box(0, 0, w, d) for w, d in ((8, 8), (7, 100), (7.5, 40), (90, 90), (20, 20))]
    result = built(lots, [0.0] * 20, request(5, (0.0, 0.0, 0.0), least_side=7.5, most_area=6_000.0))
    assert result.reason.tolist() == ["", NARROW, "", LARGE, ""]
    assert result.lot.tolist() == [0, 2, 4]
    result = built(lots, [0.0] * 20, request(5, (3.0, 3.0, 3.0), least_area=30.0, least_side=1.0))
    assert result.reason.tolist() == [SMALL, "", "", LARGE, ""]


def test_what_is_narrower_than_the_smallest_side_is_cut_off():
    wings = shapely.Polygon([(0, 0), (60, 0), (60, 9), (30, 9), (30, 34), (27, 34), (27, 30), (0, 30)])
    shape = polygons(built([wings], [8.0] + [0.0] * 7, request(1, (3.0, 3.0, 3.0))))[0]
    assert shapely.hausdorff_distance(shape, shapely.box(3, 3, 27, 27)) < 0.05
    whole = polygons(built([wings], [8.0] + [0.0] * 7, request(1, (0.0, 0.0, 0.0))))[0]
    assert shapely.equals(whole, wings)


def test_holes_are_courts_with_the_setback_of_sides():
    result = built([COURT], [8.0] + [0.0] * 7, request(1, (0.0, 1.0, 0.0)))
    (polygon,) = polygons(result)
    assert polygon.exterior.bounds == (1.0, 0.0, 39.0, 40.0)
    assert polygon.interiors[0].bounds == (11.0, 11.0, 29.0, 29.0)
    slit = shapely.Polygon(SQUARE, [[(12, 12), (12.9, 12), (12.9, 12.9)]])
    result = built([slit], [0.0] * 7, request(1, (0.0, 0.0, 0.0)))
    assert len(polygons(result)[0].interiors) == 0


def test_rings_have_a_court_where_there_is_room():
    lots = [shapely.box(0, 0, 40, 50), shapely.box(0, 0, 31.9, 31), shapely.box(0, 0, 20, 50), COURT]
    wish = replace(request(4, (0.0, 0.0, 0.0)), is_ring=np.array([True, True, True, True]))
    shapes = polygons(built(lots, [8.0] * 20, wish))
    assert shapes[0].interiors[0].bounds == (12.0, 12.0, 28.0, 38.0)
    assert [len(shape.interiors) for shape in shapes] == [1, 0, 0, 1]
    assert [shape.area for shape in shapes[1:3]] == pytest.approx([31.9 * 31, 1000.0])


def test_doubled_edges_join_courts_to_the_outline():
    result = built([COURT, shapely.box(50, 0, 90, 30)], [8.0] + [0.0] * 11, request(2, (1.0, 1.0, 1.0)))
    cycle, widths, offsets = joined_rings(result.edges, result.street_width)
    shapes = polygons(result)
    for row in range(2):
        ring = result.edges.points[cycle[offsets[row] : offsets[row + 1]]]
        x, y = ring.T
        area = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
        assert area == pytest.approx(shapes[row].area)
    assert offsets.tolist() == [0, 10, 14]
    first = result.edges.ring_offsets[result.edges.outline_offsets[:-1]]
    assert cycle[offsets[:-1]].tolist() == first.tolist()
    assert cycle[offsets[:-1] + 1].tolist() == (first + 1).tolist()
    assert widths.tolist() == [8.0] + [0.0] * 13
    south = result.edges.points[cycle] * (1.0, -1.0)
    assert (edge_sides(south, offsets, widths) == FRONT).tolist() == (widths > 0).tolist()


def test_a_court_that_touches_the_outline_keeps_the_widths_of_its_edges():
    lot = shapely.from_wkt("POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (10 0, 5 3, 8 4, 10 0))")
    edges = LotEdges.of(np.array([lot], dtype=object))
    cycle, widths, offsets = joined_rings(edges, np.arange(1.0, 8.0))
    ends = edges.points[np.roll(cycle, -1)]
    assert offsets.tolist() == [0, 7]
    assert widths.tolist() == (cycle + 1.0).tolist()
    assert ends.tolist() == edges.points[edges.next_corner[cycle]].tolist()


def test_start_rules_are_those_of_corner_inner_and_other_lots():
    lots = np.array([shapely.Polygon(SQUARE)] * 5, dtype=object)
    edges = LotEdges.of(lots)
    widths = np.array([[8, 0, 0, 0], [0, 0, 0, 0], [8, 8, 0, 0], [8, 0, 8, 0], [8, 8, 8, 8]], float).ravel()
    assert lot_kinds(edges, widths).tolist() == [LOT, INNER_LOT, CORNER_LOT, LOT, CORNER_LOT]


def test_a_footprint_does_not_depend_on_other_lots():
    outlines = simplified(lot_map(1).parcels.outline)
    edges = LotEdges.of(outlines)
    widths = street_widths(
        edges, PackedOutlines.of(outlines), np.arange(len(outlines)), None, np.zeros(len(outlines), bool)
    )
    wish = replace(request(len(outlines)), is_ring=np.arange(len(outlines)) % 2 == 0)
    together = building_footprints(edges, widths, wish)
    for index, row in enumerate(together.lot.tolist()):
        alone = building_footprints(
            LotEdges.of(outlines[[row]]), widths[edges.outline == row], replace(request(1), is_ring=wish.is_ring[[row]])
        )
        corners = together.edges.outline == index
        assert alone.edges.points.tobytes() == together.edges.points[corners].tobytes()
        assert alone.street_width.tolist() == together.street_width[corners].tolist()
