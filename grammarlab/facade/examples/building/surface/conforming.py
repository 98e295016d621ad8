"""Conforming edges along seams: adjacent pieces share all points of their seam."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from grammarlab.facade.examples.mesh.surface import Floats, Ints, Surface, naked_edges, split_edges
from grammarlab.facade.examples.mesh.views import Plane

_ROUNDS = 40


def conformed(surface: Surface, planes: Sequence[Plane], tolerance: float) -> Surface:
    """The surface without T-junctions on seams: points on open edges become corners of the triangles.

    Args:
        surface: a welded surface.
        planes: planes of the seams; T-junctions elsewhere are part of the example, and stay.
        tolerance: largest distance between an edge and a point on it, metres.
    """
    for _ in range(_ROUNDS):
        edges = seam_edges(surface, planes, tolerance)[0]
        edge, via = _on_edges(surface.points, edges, tolerance)
        if not len(edge):
            return surface
        chosen = edges[edge]
        # An edge of isolated triangles may occur in both directions; its points are then found twice.
        key = chosen.min(axis=1) * len(surface.points) + chosen.max(axis=1)
        _, first = np.unique(key, return_index=True)
        surface = split_edges(surface, chosen[first, 0], chosen[first, 1], via[first])
    return surface


def seam_edges(surface: Surface, planes: Sequence[Plane], tolerance: float) -> tuple[Ints, Ints]:
    """[E, 2] directed edges on one of the planes without an opposite edge, and [E] their multiplicities."""
    points = surface.points
    places = [np.unique([each.at for each in planes if each.axis == axis]) for axis in range(3)]
    near = np.zeros(len(points), dtype=bool)
    for axis, at in enumerate(places):
        near |= np.abs(points[:, axis] - _place(points[:, axis], at, tolerance)) <= tolerance
    # Only triangles with two points near planes have such edges, and all edges between such points are theirs.
    edges, times = naked_edges(surface.triangles[near[surface.triangles].sum(axis=1) >= 2], len(points))
    on = np.zeros(len(edges), dtype=bool)
    for axis, at in enumerate(places):
        start, end = points[edges[:, 0], axis], points[edges[:, 1], axis]
        place = _place(start, at, tolerance)
        on |= (np.abs(start - place) <= tolerance) & (np.abs(end - place) <= tolerance)
    return edges[on], times[on]


def _place(values: Floats, places: Floats, tolerance: float) -> Floats:
    """[N] the lowest of some ascending positions not below each value; infinite if there are none."""
    if not len(places):
        return np.full(len(values), np.inf)
    return places[np.minimum(np.searchsorted(places, values - tolerance), len(places) - 1)]


def _on_edges(points: Floats, edges: Ints, tolerance: float) -> tuple[Ints, Ints]:
    """Edges with points between their ends, and for each the point nearest to its middle."""
    none = np.zeros(0, dtype=np.int64)
    if not len(edges):
        return none, none
    candidates = np.unique(edges)
    tree = KDTree(points[candidates])
    start, end = points[edges[:, 0]], points[edges[:, 1]]
    length = np.linalg.norm(end - start, axis=1)
    near = tree.query_ball_point((start + end) / 2.0, length / 2.0 + tolerance, return_sorted=False)
    count = np.array([len(each) for each in near])
    edge = np.repeat(np.arange(len(edges)), count)
    via = candidates[np.concatenate([np.asarray(each, dtype=np.int64) for each in near])]
    other = (via != edges[edge, 0]) & (via != edges[edge, 1])
    edge, via = edge[other], via[other]
    along = end[edge] - start[edge]
    part = ((points[via] - start[edge]) * along).sum(axis=1) / length[edge] ** 2
    miss = np.linalg.norm(points[via] - start[edge] - part[:, None] * along, axis=1)
    inside = np.minimum(part, 1.0 - part) * length[edge] > tolerance
    on = (miss <= tolerance) & inside
    edge, via, part = edge[on], via[on], part[on]
    order = np.lexsort((via, np.abs(part - 0.5), edge))
    first = np.append(True, np.diff(edge[order]) != 0) if len(order) else np.zeros(0, dtype=bool)
    return edge[order][first], via[order][first]
