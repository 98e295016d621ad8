"""Edges that meet points of their neighbours: pieces that stand side by side share all points along their seam."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from grammarlab.facade.examples.mesh.surface import Floats, Ints, Surface, naked_edges, split_edges
from grammarlab.facade.examples.mesh.views import Plane

_ROUNDS = 40


def conformed(surface: Surface, planes: Sequence[Plane], tolerance: float) -> Surface:
    """The surface without T-junctions on seams: naked points on naked edges become corners of their triangles.

    Args:
        surface: welded.
        planes: of the seams; T-junctions elsewhere are the example's own, and stay.
        tolerance: metres between an edge and a point on it.
    """
    for _ in range(_ROUNDS):
        edges = seam_edges(surface, planes, tolerance)[0]
        edge, via = _on_edges(surface.points, edges, tolerance)
        if not len(edge):
            return surface
        chosen = edges[edge]
        # An edge may run both ways in triangles that meet nothing else; its points are found twice then.
        key = chosen.min(axis=1) * len(surface.points) + chosen.max(axis=1)
        _, first = np.unique(key, return_index=True)
        surface = split_edges(surface, chosen[first, 0], chosen[first, 1], via[first])
    return surface


def seam_edges(surface: Surface, planes: Sequence[Plane], tolerance: float) -> tuple[Ints, Ints]:
    """[E, 2] directed edges on one of the planes that nothing runs against, and [E] how many times."""
    points = surface.points
    places = [np.unique([each.at for each in planes if each.axis == axis]) for axis in range(3)]
    near = np.zeros(len(points), dtype=bool)
    for axis, at in enumerate(places):
        near |= np.abs(points[:, axis] - _place(points[:, axis], at, tolerance)) <= tolerance
    # Only triangles with two points near planes have such edges; of those edges they are all there is.
    edges, times = naked_edges(surface.triangles[near[surface.triangles].sum(axis=1) >= 2], len(points))
    on = np.zeros(len(edges), dtype=bool)
    for axis, at in enumerate(places):
        start, end = points[edges[:, 0], axis], points[edges[:, 1], axis]
        place = _place(start, at, tolerance)
        on |= (np.abs(start - place) <= tolerance) & (np.abs(end - place) <= tolerance)
    return edges[on], times[on]


def _place(values: Floats, places: Floats, tolerance: float) -> Floats:
    """[N] the lowest of some ascending places that each value is not beyond; infinite where there are no places."""
    if not len(places):
        return np.full(len(values), np.inf)
    return places[np.minimum(np.searchsorted(places, values - tolerance), len(places) - 1)]


def _on_edges(points: Floats, edges: Ints, tolerance: float) -> tuple[Ints, Ints]:
    """Edges that have a point between their ends, and of those points the one nearest to the middle."""
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
