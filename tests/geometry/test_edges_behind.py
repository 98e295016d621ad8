"""Edges behind and ahead of segments, against brute force."""

from __future__ import annotations

import numpy as np
import shapely
from hypothesis import given
from hypothesis import strategies as st

from grammarlab.geometry.edges_behind import EdgeSets, OutwardSegments, edges_ahead, edges_behind, edges_that_look_alike
from grammarlab.geometry.lot_sides import outward_normals
from tests.cases import bulk

NUMBERS = st.integers(0, 20).map(float)


def convex(seed: int, count: int) -> EdgeSets:
    """One convex outline, counter-clockwise seen from above, whose edges are labelled from 1 on."""
    angles = np.sort(np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, count))
    corners = np.stack([np.cos(angles) * 9, -np.sin(angles) * 7], axis=1)
    label = np.arange(1, count + 1, dtype=np.int8)
    return EdgeSets(corners, np.roll(corners, -1, axis=0), label, np.array([0, count]))


def pieces(edges: EdgeSets, distance: np.ndarray, low: float, high: float) -> OutwardSegments:
    """A piece of each edge, moved outwards."""
    count = len(edges.label)
    normals, _ = outward_normals(edges.start, edges.offsets)
    along = edges.end - edges.start
    shift = normals * distance[:, None]
    start, end = edges.start + low * along + shift, edges.start + high * along + shift
    return OutwardSegments(end, start, normals * 3.0, np.zeros(count, np.int64), np.full(count, 1e-6))


@given(st.integers(0, 99), st.integers(3, 8), st.floats(0.0, 5.0), st.floats(0.0, 0.4), st.floats(0.6, 1.0))
@bulk(60)
def test_a_piece_in_front_of_an_edge_has_that_edge_behind_it(seed, count, distance, low, high):
    edges = convex(seed, count)
    behind = edges_behind(pieces(edges, np.full(count, distance), low, high), edges)
    length = np.hypot(*(edges.end - edges.start).T)
    seen = length * (high - low) > 1e-5
    assert behind.label[seen].tolist() == edges.label[seen].tolist()
    np.testing.assert_allclose(behind.distance[seen], distance, atol=2e-6)
    np.testing.assert_allclose(behind.overlap[seen], (length * (high - low))[seen], atol=1e-9)


@given(st.integers(0, 99), st.integers(3, 8), st.floats(0.01, 5.0))
@bulk(30)
def test_nothing_lies_behind_what_is_inside_a_convex_lot_or_looks_into_it(seed, count, distance):
    edges = convex(seed, count)
    inside = pieces(edges, np.full(count, -distance), 0.0, 1.0)
    assert not edges_behind(inside, edges).label.any()
    inwards = pieces(edges, np.zeros(count), 0.0, 1.0)
    turned = OutwardSegments(inwards.start, inwards.end, -inwards.outward, inwards.outline, inwards.tolerance)
    assert not edges_behind(turned, edges).label.any()


@given(st.integers(0, 99), st.integers(3, 8), st.floats(0.0, 6.3))
@bulk(30)
def test_the_edge_that_looks_alike_has_the_largest_cosine(seed, count, angle):
    edges = convex(seed, count)
    direction = np.array([[np.cos(angle), np.sin(angle)]])
    normals, _ = outward_normals(edges.start, edges.offsets)
    found = edges_that_look_alike(direction, np.zeros(1, np.int64), edges)[0]
    assert normals[found - 1] @ direction[0] >= (normals @ direction[0]).max() - 1e-6


@given(st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS), min_size=1, max_size=12), st.floats(0.0, 6.3))
@bulk(60)
def test_the_first_edge_ahead_is_the_one_that_a_ray_meets_first(lines, angle):
    lines = [line for line in lines if line[:2] != line[2:]]
    table = np.array(lines).reshape(-1, 4)
    edges = EdgeSets(table[:, :2], table[:, 2:], np.ones(len(table), np.int8), np.array([0, len(table)]))
    point, direction = np.array([[10.3, 9.7]]), np.array([[np.cos(angle), np.sin(angle)]])
    nearest, distance = edges_ahead(point, direction, np.zeros(1, np.int64), edges, np.zeros(1))
    ray = shapely.LineString([point[0], point[0] + 100.0 * direction[0]])
    met = [ray.intersection(shapely.LineString(line.reshape(2, 2))) for line in table]
    expected = [shapely.Point(point[0]).distance(each) if not each.is_empty else np.inf for each in met]
    assert np.isclose(distance[0], min(expected, default=np.inf), atol=1e-6)
    assert nearest[0] == -1 or np.isclose(expected[nearest[0]], distance[0], atol=1e-6)
