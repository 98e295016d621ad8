"""Checks and repairs of outlines."""

from __future__ import annotations

import numpy as np
import shapely

from grammarlab.geometry.outlines.footprints.crs import Unit
from grammarlab.geometry.outlines.footprints.ground import LAST_LATITUDE, without_jumps

MAX_CORNERS = 10_000
MAX_REPAIRED_CORNERS = 1_000
"""Most corners of an outline that is repaired: as many edges may cross in half a million places."""
MAX_EXTENT = 20_000.0
"""Largest width or depth of one footprint in metres."""
MAX_DISTANCE = 1e8
"""Largest coordinate in metres: farther than any place on a map."""
MIN_AREA = 1e-4
"""Smallest area of a footprint, or of a hole, in square metres."""
TOLERANCE = 0.01
"""Largest change of the area of an outline by a repair, as a share."""


class BadOutlineError(ValueError):
    """An outline that cannot be used.

    Args:
        reason: why.
        has_position: whether the reason says where.
    """

    def __init__(self, reason: str, *, has_position: bool = False) -> None:
        super().__init__(reason)
        self.has_position = has_position


def checked(polygon: shapely.Polygon, unit: Unit) -> shapely.Polygon:
    """A polygon of a source, without jumps at the date line, if its coordinates can be those of a place.

    Raises:
        BadOutlineError: If they cannot, or are too many.
    """
    if polygon.is_empty:
        raise BadOutlineError("expected a polygon with corners, found an empty one")
    corners = shapely.get_num_coordinates(polygon)
    if corners > MAX_CORNERS:
        raise BadOutlineError(f"{corners} corners; a footprint may have {MAX_CORNERS} at most. Simplify it")
    points = shapely.get_coordinates(polygon)
    if not np.isfinite(points).all():
        raise BadOutlineError("a coordinate is not a finite number")
    if unit == "metres":
        if np.abs(points).max() > MAX_DISTANCE:
            x, y = points[np.abs(points).max(axis=1).argmax()].tolist()
            raise BadOutlineError(f"{position(x, y, unit)} is farther away than any place on a map", has_position=True)
        return polygon
    (west, south), (east, north) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    if not (west >= -180.0 and east <= 360.0 and south >= -90.0 and north <= 90.0):
        raise BadOutlineError(
            f"expected longitude and latitude in degrees, found x from {west:.10g} to {east:.10g} and y from "
            f"{south:.10g} to {north:.10g}",
            has_position=True,
        )
    if max(-south, north) > LAST_LATITUDE:
        raise BadOutlineError(f"latitude {north if north > -south else south:.10g} is too near to a pole")
    joined = without_jumps(polygon)
    if joined is None:
        raise BadOutlineError("it goes around a pole")
    return joined


def repaired(polygon: shapely.Polygon, unit: Unit) -> tuple[list[shapely.Polygon], str]:
    """Valid polygons with the area of a polygon, and the fault that was repaired; an empty text if there is none.

    Raises:
        BadOutlineError: If the polygon is invalid and the area of the repaired one differs by more than 1 %.
    """
    if polygon.is_valid:
        return [polygon], ""
    fault = fault_of(polygon, unit)
    if shapely.get_num_coordinates(polygon) > MAX_REPAIRED_CORNERS:
        raise BadOutlineError(fault, has_position=True)
    pieces = shapely.get_parts(shapely.get_parts(shapely.make_valid(polygon)))  # polygons may be in two levels
    parts = [piece for piece in pieces if isinstance(piece, shapely.Polygon)]
    area = sum(part.area for part in parts)
    drawn = _drawn_area(polygon)
    if not parts or abs(area - drawn) > TOLERANCE * drawn:
        raise BadOutlineError(fault, has_position=True)
    return [part for part in parts if part.area >= TOLERANCE * area], fault


def measured(polygon: shapely.Polygon) -> shapely.Polygon:
    """A polygon in metres without holes that are too small to see.

    Raises:
        BadOutlineError: If it is too small or too large, or no longer valid after rounding.
    """
    west, south, east, north = polygon.bounds
    if not max(abs(west), abs(south), abs(east), abs(north)) <= MAX_DISTANCE:
        raise BadOutlineError("it is on the other side of the earth from the other outlines")
    if max(east - west, north - south) > MAX_EXTENT:
        raise BadOutlineError(
            f"{east - west:g} x {north - south:g} metres; a footprint may have {MAX_EXTENT:g} at most"
        )
    if polygon.area < MIN_AREA:
        raise BadOutlineError(f"an area of {polygon.area:g} square metres is too small to build on")
    holes = [hole for hole in polygon.interiors if shapely.Polygon(hole).area >= MIN_AREA]
    whole = polygon if len(holes) == len(polygon.interiors) else shapely.Polygon(polygon.exterior, holes)
    if not whole.is_valid:
        raise BadOutlineError(fault_of(whole, "metres"), has_position=True)
    return whole


def fault_of(polygon: shapely.Polygon, unit: Unit) -> str:
    """The fault of an invalid polygon with its position: ``self-intersection at x = 45, y = 4``."""
    reason, _, coordinates = shapely.is_valid_reason(polygon).partition("[")
    x, y = (float(value) for value in coordinates.rstrip("]").split()[:2])
    return f"{reason.lower()} at {position(x, y, unit)}"


def position(x: float, y: float, unit: Unit) -> str:
    """A position of a source in words."""
    if unit == "degrees":
        return f"longitude {x:.10g}, latitude {y:.10g}"
    return f"x = {x:.10g}, y = {y:.10g}"


def _drawn_area(polygon: shapely.Polygon) -> float:
    """The area that the rings of a polygon go around, less what they go around in the other direction."""
    outer, *holes = (_shoelace(shapely.get_coordinates(ring)) for ring in (polygon.exterior, *polygon.interiors))
    return abs(outer) - sum(map(abs, holes))


def _shoelace(ring: np.ndarray) -> float:
    x, y = (ring - ring[0]).T
    return float(x[:-1] @ y[1:] - x[1:] @ y[:-1]) / 2
