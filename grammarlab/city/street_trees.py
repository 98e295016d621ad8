"""Trees along streets: in rows at equal distances on both sides, clear of crossing streets and of parcels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from grammarlab.arrays import Floats
from grammarlab.city.packed_outlines import Outlines
from grammarlab.city.street_lines import StreetLines

_SIDES = (1.0, -1.0)
_CLEARANCE = 1.0
"""Least distance in metres between a trunk and a parcel."""
_CORNER = 4.0
"""Metres beyond the edge of a crossing street in which no tree stands, so that drivers see around the corner."""


def street_tree_places(
    streets: StreetLines, outlines: Outlines, *, spacing: float, offset: float, least_width: float
) -> Floats:
    """[n, 2] places of trees, x to the east and y to the north of the frame's origin, in metres.

    A row begins half a spacing from the first point of its line, so trees stay where they are if other streets change.

    Args:
        streets: the streets; those of unknown width have no trees.
        outlines: parcels.
        spacing: metres between trees of a row, > 0.
        offset: metres from the edge of the street to the row.
        least_width: metres; narrower streets have no trees.
    """
    wide = np.flatnonzero(streets.width >= least_width)
    places, street = list[Floats](), list[int]()
    for row in wide.tolist():
        for side in _SIDES:
            points = _row(streets.line[row], side * (streets.width[row] / 2 - offset), spacing)
            places.append(points)
            street += [row] * len(points)
    if not street:
        return np.zeros((0, 2))
    points = np.concatenate(places)
    free = ~_near(points, outlines, [_CLEARANCE] * len(outlines)) & ~_on_others(points, np.array(street), streets)
    return points[free]


def _row(line: shapely.LineString, distance: float, spacing: float) -> Floats:
    """Points of one side of a street, at equal distances along its middle."""
    length = shapely.length(line)
    along = np.arange(spacing / 2, length, spacing)
    points, ahead = (
        shapely.get_coordinates(shapely.line_interpolate_point(line, np.minimum(along + step, length)))
        for step in (-0.05, 0.05)
    )
    direction = ahead - points
    direction /= np.maximum(np.hypot(*direction.T), 1e-9)[:, None]
    return (points + ahead) / 2 + distance * np.column_stack([-direction[:, 1], direction[:, 0]])


def _tree(points: Floats) -> shapely.STRtree:
    return shapely.STRtree(np.array(shapely.points(points), dtype=object))


def _near(points: Floats, shapes: Outlines, distances: Sequence[float]) -> np.ndarray:
    """[n] whether a point is at most so far from one of the shapes."""
    near = np.zeros(len(points), np.bool_)
    if len(shapes):
        hits, _ = _tree(points).query(shapes, "dwithin", np.asarray(distances))[::-1]
        near[hits] = True
    return near


def _on_others(points: Floats, street: np.ndarray, streets: StreetLines) -> np.ndarray:
    """[n] whether a point is on a street other than its own, or at its corner."""
    reach = np.nan_to_num(streets.width / 2) + _CORNER
    other, hit = _tree(points).query(streets.line, "dwithin", reach)
    on = np.zeros(len(points), np.bool_)
    on[hit[other != street[hit]]] = True
    return on
