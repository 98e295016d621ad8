"""Outlines of shapes that are not rectangular."""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.facade.tree import Floats

MOST_CORNERS = 10_000
"""Largest number of corners of an outline."""
_RECTANGULAR = 0.999
"""Least part of its box that the polygon of a rectangle fills."""


def outline_of(points: Floats) -> Floats:
    """The points [P, 2]; none if they form a rectangle or have no area.

    A polygon that crosses itself is not an outline, nor is one of more than `MOST_CORNERS`.
    """
    if not 3 <= len(points) <= MOST_CORNERS or not np.isfinite(points).all():
        return np.zeros((0, 2))
    polygon = shapely.Polygon(points)
    extent = np.ptp(points, axis=0).prod()
    if not polygon.is_valid or not 0.0 < polygon.area < _RECTANGULAR * extent:
        return np.zeros((0, 2))
    return points
