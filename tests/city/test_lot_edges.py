"""Rings of outlines as columns equal those of shapely, whatever the order of their corners."""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.city.lot_edges import SIMPLIFIED, LotEdges, merged_edges, simplified
from tests.city.lot_maps import lot_map

COURT = shapely.Polygon(
    [(0, 0), (40, 0), (40, 40), (0, 40)], [[(10, 10), (30, 10), (30, 30)], [(2, 2), (2, 4), (4, 2)]]
)


def test_rings_are_those_of_the_polygons():
    outlines = np.array([COURT, *lot_map(1).parcels.outline, COURT.reverse()], dtype=object)
    edges = LotEdges.of(outlines)
    assert shapely.equals(edges.polygons(edges.points), outlines).all()
    rings = shapely.get_rings(edges.polygons(edges.points))
    first = np.isin(np.arange(len(rings)), edges.outline_offsets[:-1])
    assert (shapely.is_ccw(rings) == first).all()
    assert np.allclose(np.bincount(edges.outline, edges.length), shapely.length(outlines))
    middle = shapely.points(edges.points + 0.5 * edges.along + 1e-6 * edges.normal)
    assert not shapely.contains(outlines[edges.outline], middle).any()


def test_a_choice_of_outlines_has_their_corners():
    outlines = np.array([COURT, *lot_map(1).parcels.outline], dtype=object)
    edges = LotEdges.of(outlines)
    rows = np.array([3, 0, 5])
    taken, corners = edges.take(rows)
    assert (taken.points == edges.points[corners]).all()
    assert shapely.equals(taken.polygons(taken.points), outlines[rows]).all()


def test_parts_one_after_the_other_are_the_whole():
    outlines = np.array([COURT, *lot_map(1).parcels.outline], dtype=object)
    edges = LotEdges.of(outlines)
    joined = LotEdges.concatenate([LotEdges.of(outlines[:3]), LotEdges.of(outlines[3:3]), LotEdges.of(outlines[3:])])
    assert joined.points.tobytes() == edges.points.tobytes()
    assert joined.ring_offsets.tolist() == edges.ring_offsets.tolist()
    assert joined.outline_offsets.tolist() == edges.outline_offsets.tolist()


def test_another_first_corner_is_the_same_ring():
    edges = LotEdges.of(np.array([COURT, *lot_map(2).parcels.outline], dtype=object))
    first = edges.ring_offsets[edges.outline_offsets[:-1]] + 2
    turned = edges.reordered(edges.starting_at(first))
    assert (turned.points[turned.ring_offsets[turned.outline_offsets[:-1]]] == edges.points[first]).all()
    assert shapely.equals(turned.polygons(turned.points), edges.polygons(edges.points)).all()
    hole = edges.is_hole
    assert (turned.points[hole] == edges.points[hole]).all()


def test_the_drawing_of_an_outline_does_not_matter():
    outlines = np.array([COURT, *lot_map(3).parcels.outline], dtype=object)

    def redrawn(polygon: shapely.Polygon) -> shapely.Polygon:
        ring = shapely.get_coordinates(polygon.exterior)[:-1]
        return shapely.Polygon(np.roll(ring, 2, axis=0)[::-1], polygon.interiors[::-1])

    others = np.array([redrawn(polygon) for polygon in outlines], dtype=object)
    assert shapely.to_wkb(simplified(others)).tolist() == shapely.to_wkb(simplified(outlines)).tolist()


def test_corners_that_change_little_are_left_out():
    line = np.column_stack([np.linspace(0, 30, 100), 0.04 * np.sin(np.arange(100))])
    outline = shapely.Polygon([*line, (30, 20), (0, 20)])
    result = simplified(np.array([outline], dtype=object))[0]
    assert len(result.exterior.coords) == 5
    assert shapely.hausdorff_distance(result, outline) <= SIMPLIFIED


def test_edges_that_turn_little_are_one():
    angle = np.radians(np.array([0, 5, 10, 100, 190, 280]))
    ring = shapely.Polygon(np.column_stack([np.cos(angle), np.sin(angle)]))
    edges = LotEdges.of(np.array([ring], dtype=object))
    assert len(np.unique(merged_edges(edges, np.zeros(6, np.int64), 10.0))) == 5
    assert len(np.unique(merged_edges(edges, np.arange(6), 10.0))) == 6
