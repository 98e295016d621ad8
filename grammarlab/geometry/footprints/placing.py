"""Outlines of a source as footprints: checked, repaired, in metres, and placed relative to each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from grammarlab.errors import AssetError
from grammarlab.geometry.footprints.crs import Unit
from grammarlab.geometry.footprints.footprint import Footprint, FootprintMap, Georeference, Outline, Remark, Source
from grammarlab.geometry.footprints.projection import LAST_LATITUDE, Ground, centres_of, without_jumps
from grammarlab.geometry.meshes.triangulate import keyhole

_MIN_EDGE = 1e-6
"""Metres; corners nearer to each other are one, so that rounding gives no edge its direction."""
_MAX_CORNERS = 10_000
"""Largest number of corners of an outline."""
_MAX_REPAIRED_CORNERS = 1_000
"""Most corners of an outline that is repaired: as many edges may cross in half a million places."""
_MAX_EXTENT = 20_000.0
"""Largest width or depth of one footprint in metres."""
_MAX_DISTANCE = 1e8
"""Largest coordinate in metres: farther than any place on a map."""
_MIN_AREA = 1e-4
"""Smallest area of a footprint, or of a hole, in square metres."""
AREA_TOLERANCE = 0.01
"""Largest change of the area of an outline by a repair, as a share."""
_CROSSING = "Draw the ring without crossing itself."
_MOST_REASONS = 8
"""Largest number of reasons in a message."""
_WIDEST_DEGREES = 0.05
"""Width of an outline below which metres are taken for degrees: 5 cm, or about 5 km."""


class BadOutlineError(ValueError):
    """An outline that cannot be used.

    Args:
        reason: why.
        has_position: whether the reason says where.
    """

    def __init__(self, reason: str, *, has_position: bool = False) -> None:
        super().__init__(reason)
        self.has_position = has_position


@dataclass(frozen=True, slots=True)
class Plan:
    """Usable outlines of a source, in its coordinates and in metres."""

    outlines: tuple[Outline, ...]
    """Valid, in the coordinates of the source; at least one."""
    polygons: tuple[shapely.Polygon, ...]
    """Each outline in metres, as its footprint is."""
    ground: Ground | None
    """Map of the ground for outlines in degrees."""
    georeference: Georeference | None
    remarks: tuple[Remark, ...]


def placed(source: Source) -> FootprintMap:
    """Footprints of the outlines of a source.

    Raises:
        AssetError: If there are none, if a strict source has a bad one, or if all coordinates contradict the CRS.
    """
    plan = planned(source)
    footprints = [
        Footprint(_corners_of(polygon), outline.properties, outline.name, outline.unread)
        for outline, polygon in zip(plan.outlines, plan.polygons, strict=True)
    ]
    return FootprintMap(tuple(footprints), plan.georeference, plan.remarks)


def planned(source: Source) -> Plan:
    """The usable outlines of a source.

    Raises:
        AssetError: As `placed`.
    """
    valid, remarks = _valid(source)
    _check_unit(source, valid)
    georeference = Georeference(source.crs.name) if source.crs.name else None
    plans = [outline.polygon for outline in valid]
    ground = None
    if source.crs.unit == "degrees" and valid:
        ground = Ground.around(centres_of(plans))
        plans = ground.metres(plans)
        georeference = Georeference(source.crs.name, ground.longitude, ground.latitude)
    usable = []
    for outline, plan in zip(valid, plans, strict=True):
        try:
            usable.append((outline, _measured(plan)))
        except BadOutlineError as error:
            remarks.append(_bad(source, outline, error))
    remarks = [*source.remarks, *remarks]
    if not usable:
        raise _nothing(source, remarks)
    outlines, polygons = zip(*usable, strict=True)
    return Plan(outlines, polygons, ground, georeference, tuple(remarks))


def remark_lines(remarks: Sequence[Remark]) -> str:
    """The first remarks, each on a new line of a message, and the number of the others."""
    lines = "".join(f"\n  {remark}" for remark in remarks[:_MOST_REASONS])
    return lines + (f"\n  … and {len(remarks) - _MOST_REASONS:,} more" if len(remarks) > _MOST_REASONS else "")


def repaired(polygon: shapely.Polygon, unit: Unit) -> tuple[list[shapely.Polygon], str]:
    """Valid polygons with the area of a polygon, and the fault that was repaired; an empty text if there is none.

    Raises:
        BadOutlineError: If the polygon is invalid and the area of the repaired one differs by more than 1 %.
    """
    if polygon.is_valid:
        return [polygon], ""
    fault = _fault_of(polygon, unit)
    if shapely.get_num_coordinates(polygon) > _MAX_REPAIRED_CORNERS:
        raise BadOutlineError(fault, has_position=True)
    pieces = shapely.get_parts(shapely.get_parts(shapely.make_valid(polygon)))  # polygons may be in two levels
    parts = [piece for piece in pieces if isinstance(piece, shapely.Polygon)]
    area = sum(part.area for part in parts)
    drawn = _drawn_area(polygon)
    if not parts or abs(area - drawn) > AREA_TOLERANCE * drawn:
        raise BadOutlineError(fault, has_position=True)
    return [part for part in parts if part.area >= AREA_TOLERANCE * area], fault


def _valid(source: Source) -> tuple[list[Outline], list[Remark]]:
    """Valid outlines in the coordinates of a source, and remarks about all others."""
    outlines: list[Outline] = []
    remarks: list[Remark] = []
    for outline in source.outlines:
        try:
            polygon = _checked(outline.polygon, source.crs.unit)
            parts, fault = repaired(polygon, source.crs.unit)
        except BadOutlineError as error:
            remarks.append(_bad(source, outline, error))
            continue
        if fault and source.strict:
            raise AssetError(f"{outline.name}: {fault}. {_CROSSING}")
        if fault:
            pieces = "" if len(parts) == 1 else f", in {len(parts)} pieces"
            remarks.append(Remark(outline.name, "repair", f"{fault}{pieces}"))
        outlines += [replace(outline, polygon=part) for part in parts]
    return outlines, remarks


def _checked(polygon: shapely.Polygon, unit: Unit) -> shapely.Polygon:
    """A polygon of a source, without jumps at the date line, if its coordinates can be those of a place.

    Raises:
        BadOutlineError: If they cannot, or are too many.
    """
    if polygon.is_empty:
        raise BadOutlineError("expected a polygon with corners, found an empty one")
    corners = shapely.get_num_coordinates(polygon)
    if corners > _MAX_CORNERS:
        raise BadOutlineError(f"{corners} corners; a footprint may have {_MAX_CORNERS} at most. Simplify it")
    points = shapely.get_coordinates(polygon)
    if not np.isfinite(points).all():
        raise BadOutlineError("a coordinate is not a finite number")
    if unit == "metres":
        if np.abs(points).max() > _MAX_DISTANCE:
            x, y = points[np.abs(points).max(axis=1).argmax()].tolist()
            raise BadOutlineError(f"{_position(x, y, unit)} is farther away than any place on a map", has_position=True)
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


def _position(x: float, y: float, unit: Unit) -> str:
    """A position of a source in words."""
    if unit == "degrees":
        return f"longitude {x:.10g}, latitude {y:.10g}"
    return f"x = {x:.10g}, y = {y:.10g}"


def _fault_of(polygon: shapely.Polygon, unit: Unit) -> str:
    """The fault of an invalid polygon with its position: ``self-intersection at x = 45, y = 4``."""
    reason, _, coordinates = shapely.is_valid_reason(polygon).partition("[")
    x, y = (float(value) for value in coordinates.rstrip("]").split()[:2])
    return f"{reason.lower()} at {_position(x, y, unit)}"


def _drawn_area(polygon: shapely.Polygon) -> float:
    """The area that the rings of a polygon go around, less what they go around in the other direction."""
    outer, *holes = (_shoelace(shapely.get_coordinates(ring)) for ring in (polygon.exterior, *polygon.interiors))
    return abs(outer) - sum(map(abs, holes))


def _shoelace(ring: np.ndarray) -> float:
    x, y = (ring - ring[0]).T
    return float(x[:-1] @ y[1:] - x[1:] @ y[:-1]) / 2


def _bad(source: Source, outline: Outline, error: BadOutlineError) -> Remark:
    """The remark about a bad outline; an error if its source is strict."""
    if source.strict:
        raise AssetError(f"{outline.name}: {error}. {_advice(source, str(error))}".rstrip())
    reason = str(error)
    if not (error.has_position or outline.polygon.is_empty):
        x, y = shapely.get_coordinates(outline.polygon)[0].tolist()
        reason = f"{reason} (at {_position(x, y, source.crs.unit)})"
    return Remark(outline.name, "outline", reason)


def _advice(source: Source, reasons: str) -> str:
    """Advice for some reasons."""
    if (
        source.crs.unit == "degrees"
        and ("in degrees" in reasons or "metres; a footprint" in reasons)
        and source.origin == "map"
    ):
        return (
            "GeoJSON counts in degrees. If yours counts in metres, name its CRS at the top of the file, "
            '"crs": {"type": "name", "properties": {"name": "EPSG:25832"}}, or write "crs": null there.'
        )
    if "intersection" in reasons:
        return _CROSSING
    return ""


def _check_unit(source: Source, outlines: Sequence[Outline]) -> None:
    """Refuse metres that are degrees.

    Raises:
        AssetError: If all coordinates can be degrees, and all outlines are only centimetres wide.
    """
    if source.crs.unit != "metres" or not outlines:
        return
    bounds = shapely.bounds(np.array([outline.polygon for outline in outlines], dtype=object))
    low, high = bounds[:, :2], bounds[:, 2:]
    if (
        (high - low).max() >= _WIDEST_DEGREES
        or np.abs(bounds).max(axis=0).max() > 180.0
        or np.abs(bounds[:, 1::2]).max() > 90
    ):
        return
    (west, south), (east, north) = low.min(axis=0).tolist(), high.max(axis=0).tolist()
    system = f"its CRS {source.crs.name} counts in metres" if source.crs.name else "it counts in metres"
    fix = (
        "write SRID=4326; before it"
        if source.origin != "map"
        else 'leave out the member "crs", or name a CRS in degrees there, such as "EPSG:4326"'
    )
    raise AssetError(
        f"{source.name}: too small to build on: {system}, and x is from {west:.10g} to {east:.10g} and y from "
        f"{south:.10g} to {north:.10g}. If these are degrees of longitude and latitude, {fix}."
    )


def _corners_of(polygon: shapely.Polygon) -> NDArray[np.float64]:
    """The corners [n, 3] of a valid polygon in the world; holes are joined to the outline by doubled edges.

    A plan's x (east) becomes the world's x, its y (north) the world's -z, so a counter-clockwise ring looks up (+y).
    """
    rings = [_ring(polygon.exterior, counter_clockwise=True)]
    rings += [_ring(hole, counter_clockwise=False) for hole in polygon.interiors]
    points = np.concatenate(rings)[keyhole(rings)]
    return np.column_stack([points[:, 0], np.zeros(len(points)), -points[:, 1]]) + 0.0


def _ring(ring: shapely.LinearRing, counter_clockwise: bool) -> NDArray[np.float64]:
    """Corners [n, 2] of a ring, reversed if necessary; the first edge stays first, since the scope is aligned to it."""
    corners = shapely.get_coordinates(shapely.remove_repeated_points(ring, _MIN_EDGE))[:-1]
    return corners if ring.is_ccw == counter_clockwise else np.roll(corners[::-1], 2, axis=0)


def _measured(polygon: shapely.Polygon) -> shapely.Polygon:
    """A polygon in metres without holes that are too small to see.

    Raises:
        BadOutlineError: If it is too small or too large, or no longer valid after rounding.
    """
    west, south, east, north = polygon.bounds
    if not max(abs(west), abs(south), abs(east), abs(north)) <= _MAX_DISTANCE:
        raise BadOutlineError("it is on the other side of the earth from the other outlines")
    if max(east - west, north - south) > _MAX_EXTENT:
        raise BadOutlineError(
            f"{east - west:g} x {north - south:g} metres; a footprint may have {_MAX_EXTENT:g} at most"
        )
    if polygon.area < _MIN_AREA:
        raise BadOutlineError(f"an area of {polygon.area:g} square metres is too small to build on")
    holes = [hole for hole in polygon.interiors if shapely.Polygon(hole).area >= _MIN_AREA]
    whole = polygon if len(holes) == len(polygon.interiors) else shapely.Polygon(polygon.exterior, holes)
    if not whole.is_valid:
        raise BadOutlineError(_fault_of(whole, "metres"), has_position=True)
    return whole


def _nothing(source: Source, remarks: Sequence[Remark]) -> AssetError:
    reasons = remark_lines(remarks)
    if not source.outlines and not any(remark.kind == "outline" for remark in remarks):
        message = f"{source.name}: no Polygon or MultiPolygon in this file." if not source.strict else remarks[0]
        return AssetError(f"{message}{reasons if not source.strict else ''}")
    advice = _advice(source, reasons)
    return AssetError(f"{source.name}: no outline can be used.{reasons}" + (f"\n{advice}" if advice else ""))
