"""Closed shells of buildings from their roofs: the roofs, the walls below their edges, and the ground."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from grammarlab.export.city_roofs import RoofMap, RoofPlane
from grammarlab.export.city_surfaces import MILLIMETRES, CityGeometry, solid, to_grid
from grammarlab.export.surface_labels import GROUND, ROOF, WALL

_OUTSIDE = -1
"""Region outside all others."""
_SAME_HEIGHT = 10
"""Largest difference in millimetres of heights that become one point; faces stay planar within it."""
Place: TypeAlias = tuple[int, int]
"""Millimetres to the east and to the north."""
Point: TypeAlias = tuple[int, int, int]
"""Millimetres to the east, to the north and up."""
Edge: TypeAlias = tuple[Place, Place]
Outline: TypeAlias = list[list[Place]]
"""Rings of a region, which is to the left of their edges."""
Face: TypeAlias = list[list[Point]]


def shell(roofs: RoofMap, ground: float) -> CityGeometry | None:
    """The solid below roofs, down to a height in metres; None if its surface would not be closed and simple.

    Walls have the points of all heights at their ends, so that neighbours share whole edges.
    """
    bottom = to_grid(np.array(ground)).item()
    outlines = [_outline(region) for region in roofs.regions]
    outlines = _with_crossings(outlines, roofs.planes)
    heights = _heights(outlines, roofs.planes)
    outer = _outer_rings(outlines)
    if outer is None or any(height <= bottom for at_place in heights.values() for height in at_place.values()):
        return None
    for ring in outer:
        for place in ring:
            heights[place][_OUTSIDE] = bottom
    roof_faces = [
        [[(*place, heights[place][region]) for place in ring] for ring in outline]
        for region, outline in enumerate(outlines)
    ]
    ground_face = [[(*place, bottom) for place in reversed(ring)] for ring in outer]
    walls = list(_walls(outlines, heights))
    faces = [ground_face, *walls, *roof_faces]
    if not _is_closed(faces):
        return None
    points = sorted({point for face in faces for ring in face for point in ring})
    row = {point: index for index, point in enumerate(points)}
    surfaces = [[[row[point] for point in ring] for ring in face] for face in faces]
    kinds = [GROUND, *[WALL] * len(walls), *[ROOF] * len(roof_faces)]
    return solid(np.array(points, dtype=np.int64), surfaces, kinds)


def _outline(region: shapely.Polygon) -> Outline:
    whole = orient(region)
    rings = [to_grid(shapely.get_coordinates(ring)[:-1]).tolist() for ring in (whole.exterior, *whole.interiors)]
    return [[(east, north) for east, north in ring] for ring in rings]


def _edges(outline: Outline) -> Iterator[Edge]:
    for ring in outline:
        yield from pairwise([*ring, ring[0]])


def _owners(outlines: Sequence[Outline]) -> dict[Edge, int]:
    """The region to the left of each edge."""
    return {edge: region for region, outline in enumerate(outlines) for edge in _edges(outline)}


def _with_crossings(outlines: Sequence[Outline], planes: Sequence[RoofPlane]) -> list[Outline]:
    """The outlines with further points where two roofs cross above a common edge."""
    owners = _owners(outlines)
    middles: dict[Edge, Place] = {}
    for (start, end), region in owners.items():
        other = owners.get((end, start))
        if other is not None and region < other:
            ends = np.array([start, end])
            above, beyond = _height(planes[region], ends) - _height(planes[other], ends)
            if above * beyond < 0 and min(abs(above), abs(beyond)) > _SAME_HEIGHT:
                east, north = to_grid((ends[0] + above / (above - beyond) * (ends[1] - ends[0])) / MILLIMETRES).tolist()
                middles[start, end] = middles[end, start] = (east, north)
    return [[_with_middles(ring, middles) for ring in outline] for outline in outlines]


def _with_middles(ring: list[Place], middles: Mapping[Edge, Place]) -> list[Place]:
    places = []
    for start, end in pairwise([*ring, ring[0]]):
        places.append(start)
        middle = middles.get((start, end), start)
        if middle not in (start, end):
            places.append(middle)
    return places


def _height(plane: RoofPlane, places: np.ndarray) -> np.ndarray:
    """[n] heights in millimetres at places [n, 2]."""
    return plane.height(places / MILLIMETRES) * MILLIMETRES


def _heights(outlines: Sequence[Outline], planes: Sequence[RoofPlane]) -> dict[Place, dict[int, int]]:
    """Height in millimetres of each region at its places; heights that are almost the same are the same."""
    exact: dict[Place, list[tuple[float, int]]] = defaultdict(list)
    for region, outline in enumerate(outlines):
        places = [place for ring in outline for place in ring]
        for place, height in zip(places, _height(planes[region], np.array(places)).tolist(), strict=True):
            exact[place].append((height, region))
    return {place: _joined(sorted(heights)) for place, heights in exact.items()}


def _joined(heights: Sequence[tuple[float, int]]) -> dict[int, int]:
    """The heights of regions, ascending, after runs of almost equal ones became their mean."""
    joined: dict[int, int] = {}
    run: list[tuple[float, int]] = []
    for height, region in (*heights, (np.inf, _OUTSIDE)):
        if run and height - run[-1][0] > _SAME_HEIGHT:
            mean = round(sum(value for value, _ in run) / len(run))
            joined |= {member: mean for _, member in run}
            run = []
        run.append((height, region))
    return joined


def _outer_rings(outlines: Sequence[Outline]) -> list[list[Place]] | None:
    """Outline of all regions together, the outer ring first; None if rings touch or there are several parts."""
    owners = _owners(outlines)
    following = {}
    for start, end in owners:
        if (end, start) not in owners:
            if start in following:
                return None
            following[start] = end
    rings = []
    while following:
        start = place = min(following)
        ring = []
        while place in following:
            ring.append(place)
            place = following.pop(place)
        if place != start:
            return None
        rings.append(ring)
    ordered = sorted(rings, key=lambda ring: -shapely.Polygon(ring).area)
    is_outer = [shapely.LinearRing(ring).is_ccw for ring in ordered]
    return ordered if is_outer == [True, *[False] * (len(rings) - 1)] else None


def _walls(outlines: Sequence[Outline], heights: Mapping[Place, Mapping[int, int]]) -> Iterator[Face]:
    """Walls from each edge of a roof down to the roof, or the ground, on the other side."""
    owners = _owners(outlines)
    for (start, end), region in owners.items():
        other = owners.get((end, start), _OUTSIDE)
        at_start, at_end = heights[start], heights[end]
        if at_start[region] >= at_start[other] and at_end[region] >= at_end[other]:
            up = _column(end, at_end, other, region)
            down = _column(start, at_start, other, region)[::-1]
            if len(up) + len(down) > 2:
                yield [[down[-1], *up, *down[:-1]]]


def _column(place: Place, heights: Mapping[int, int], low: int, high: int) -> list[Point]:
    """Points of a place from the height of one region up to that of another."""
    between = {height for height in heights.values() if heights[low] <= height <= heights[high]}
    return [(*place, height) for height in sorted(between)]


def _is_closed(faces: Sequence[Face]) -> bool:
    """Whether each edge is passed once in each direction."""
    edges = [edge for face in faces for ring in face for edge in pairwise([*ring, ring[0]])]
    once = set(edges)
    return len(once) == len(edges) and all((end, start) in once for start, end in edges)
