"""What remains of lots lies inside them, far enough from each edge, and equals CGA's setback where no edge vanishes."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from grammarlab.arrays import Flags, Floats
from grammarlab.city.lot_edges import LotEdges, simplified
from grammarlab.city.moved_edges import moved_inwards
from grammarlab.city.packed_outlines import Outlines
from grammarlab.geometry.meshes.mesh import Meshes
from grammarlab.geometry.outlines.setback import REMAINDER, setback
from tests.city.lot_maps import lot_map


def stars(num: int, seed: int, holes: bool = False) -> Outlines:
    """Crooked polygons with reflex corners, some with a hole."""
    rng = np.random.default_rng(seed)
    polygons = []
    for _ in range(num):
        size = rng.integers(3, 12)
        angle = np.sort(rng.uniform(0, 2 * np.pi, size) + np.arange(size) * 1e-3)
        radius = rng.uniform(8, 30, size)
        ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
        polygon = shapely.Polygon(ring)
        if holes and polygon.is_valid:
            polygon = shapely.difference(polygon, shapely.box(-3, -2, 3, 2))
        polygons.append(polygon)
    usable = [polygon for polygon in polygons if isinstance(polygon, shapely.Polygon) and polygon.is_valid]
    return np.array([polygon for polygon in usable if polygon.area > 100.0], dtype=object)


def lots(seed: int) -> Outlines:
    return np.concatenate(
        [stars(60, seed), stars(30, seed + 100, holes=True), simplified(lot_map(seed).parcels.outline)]
    )


def distances_of(edges: LotEdges, seed: int) -> Floats:
    rng = np.random.default_rng(seed)
    return rng.choice([0.0, 1.0, 2.0, 3.0, 5.0], len(edges.points))


@pytest.mark.parametrize("seed", range(3))
def test_what_remains_is_inside_and_as_far_from_each_edge_as_it_moves(seed: int):
    outlines = lots(seed)
    edges = LotEdges.of(outlines)
    distances = distances_of(edges, seed)
    moved = moved_inwards(edges, distances)
    assert shapely.is_valid(moved.outline).all()
    assert (shapely.area(shapely.difference(moved.outline, shapely.buffer(outlines, 1e-6))) < 1e-6).all()
    # The rectangle that an edge sweeps, without the parts of it behind other edges of the lot.
    inwards = -edges.normal * (distances - 0.001)[:, None]
    end = edges.points[edges.next_corner]
    swept = shapely.polygons(np.stack([edges.points, end, end + inwards, edges.points + inwards], axis=1))
    swept = np.asarray(swept, dtype=object)
    swept[distances <= 0.001] = shapely.Polygon()
    whole = moved.is_whole[edges.outline]
    overlap = shapely.area(shapely.intersection(moved.outline[edges.outline], swept))
    assert (overlap[~whole] < 1e-3 * np.maximum(edges.length[~whole], 1.0)).all()
    # Where no edge vanishes, two moved lines may meet a little in front of the end of a third edge.
    assert (overlap[whole] <= 0.01 * shapely.area(swept[whole]) + 1e-3).all()
    assert (overlap[whole] < 1e-3 * np.maximum(edges.length[whole], 1.0)).mean() > 0.99


def has_cut_corners(edges: LotEdges, distances: Floats) -> Flags:
    """[S] whether lots have corners that hardly turn between edges of unequal distance: a setback cuts strips there."""
    after = edges.next_corner
    sine = edges.normal[:, 0] * edges.normal[after, 1] - edges.normal[:, 1] * edges.normal[after, 0]
    cosine = (edges.normal * edges.normal[after]).sum(axis=1)
    turn = np.degrees(np.arctan2(sine, cosine))
    is_cut = (distances != distances[after]) & (turn <= 15.0 + 1e-6) & (turn >= -45.0 - 1e-6)
    return np.bincount(edges.outline, is_cut, minlength=len(edges)) > 0


@pytest.mark.parametrize("seed", range(3))
def test_lots_that_keep_their_edges_are_those_of_the_setback(seed: int):
    outlines = lots(seed)
    outlines = outlines[shapely.get_num_interior_rings(outlines) == 0]
    edges = LotEdges.of(outlines)
    distances = distances_of(edges, seed) * 0.5
    moved = moved_inwards(edges, distances)
    assert moved.is_whole.mean() > 0.2
    compared = 0
    for row in np.flatnonzero(moved.is_whole & ~has_cut_corners(edges, distances)).tolist():
        points = edges.points[edges.outline == row]
        loop = np.column_stack([points[:, 0], np.zeros(len(points)), -points[:, 1]])
        mesh = Meshes.single(loop, [range(len(loop))])
        result = setback(mesh, distances[edges.outline == row])
        faces = np.flatnonzero(result.group == REMAINDER)
        assert len(faces) == 1
        corners = result.meshes.corner_points()[
            result.meshes.face_offsets[faces[0]] : result.meshes.face_offsets[faces[0] + 1]
        ]
        rest = shapely.Polygon(result.meshes.points[corners][:, [0, 2]] * (1, -1))
        assert shapely.area(shapely.symmetric_difference(rest, moved.outline[row])) < 1e-6 * rest.area
        compared += 1
    assert compared > 10


def test_edges_that_remain_are_in_the_order_of_the_lot():
    outlines = lots(1)
    edges = LotEdges.of(outlines)
    distances = distances_of(edges, 1) * 0.5
    moved = moved_inwards(edges, distances)
    whole = np.flatnonzero(moved.is_whole)
    kept, corners = edges.take(whole)
    after = LotEdges.of(moved.outline[whole])
    assert (np.diff(after.ring_offsets) == np.diff(kept.ring_offsets)).all()
    assert np.allclose(after.normal, edges.normal[corners], atol=1e-6)
    away = ((edges.points[corners] - after.points) * edges.normal[corners]).sum(axis=1)
    assert np.allclose(away, distances[corners])


def test_an_edge_that_stays_is_not_moved():
    outlines = lots(2)
    edges = LotEdges.of(outlines)
    moved = moved_inwards(edges, np.zeros(len(edges.points)))
    assert moved.is_whole.all()
    assert shapely.equals(moved.outline, outlines).all()


def test_a_lot_that_is_too_small_has_nothing_left():
    edges = LotEdges.of(np.array([shapely.box(0, 0, 6, 6), shapely.box(0, 0, 30, 30)], dtype=object))
    moved = moved_inwards(edges, np.full(8, 4.0))
    assert shapely.is_empty(moved.outline).tolist() == [True, False]
    assert moved.outline[1].bounds == (4, 4, 26, 26)


def test_a_lot_does_not_depend_on_other_lots():
    outlines = lots(0)
    edges = LotEdges.of(outlines)
    distances = distances_of(edges, 0)
    together = moved_inwards(edges, distances).outline
    for row in range(0, len(outlines), 9):
        alone = moved_inwards(LotEdges.of(outlines[[row]]), distances[edges.outline == row]).outline[0]
        assert shapely.to_wkb(alone) == shapely.to_wkb(together[row])


def test_the_corner_of_two_setbacks_is_sharp():
    """A notch of an L with equal setbacks has a sharp corner, unlike a buffer."""
    notch = shapely.Polygon([(0, 0), (20, 0), (20, 20), (10, 20), (10, 10), (0, 10)])
    edges = LotEdges.of(np.array([notch], dtype=object))
    moved = moved_inwards(edges, np.full(6, 2.0)).outline[0]
    expected = shapely.Polygon([(2, 2), (18, 2), (18, 18), (12, 18), (12, 8), (2, 8)])
    assert shapely.equals(moved, expected)
