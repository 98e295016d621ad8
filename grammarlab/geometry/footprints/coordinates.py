"""Coordinates of any reference system as true metres, by PROJ.

Degrees and Mercator maps become metres of the UTM zone of their middle (of the polar stereographic map beyond its
ends), feet and kilometres are scaled, and projected systems in true metres stay as they are.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.errors import AssetError
from grammarlab.extras import named_extras
from grammarlab.geometry.footprints.crs import MAX_NAME_CHARACTERS, excerpt, label, metre_codes, plain_name
from grammarlab.geometry.footprints.projection import Ground

if TYPE_CHECKING:
    from pyproj import CRS

UNPLACED = "local"
"""Stands for metres at an unknown place."""
_DEGREES = "OGC:CRS84"
_MAX_AREA_ERROR, _MAX_LENGTH_ERROR = 0.015, 0.04
"""Shares by which areas and lengths of a map in true metres may differ from those on the ground: those of the national
grids that `metre_codes` accepts."""
_SAME_PLACE = 1e-6
"""Metres between two systems that are equal but for their names."""
_FIRST_LATITUDE, _LAST_LATITUDE = -80.0, 84.0
"""Degrees between which UTM is defined."""
_MIN_CONFIDENCE = 70
"""Per cent of PROJ's confidence that a definition is that of a code; below, names and areas differ."""
_FILES = re.compile(r"init=|grids\s*=\s*(?!@null\b)|PARAMETERFILE|gridname", re.IGNORECASE)
"""Parts of a definition that make PROJ open files."""
_MIN_MEDIAN, _MAX_MEDIAN = 1.0, 1e6
"""Square metres between which the median of parcels lies if their unit is right."""
_MAX_SINGLE = 1e10
"""Square metres of an outline that is the only one: perhaps that of a city."""


@dataclass(frozen=True, slots=True)
class MetricSystem:
    """The way from the coordinates of a map to true metres."""

    source: str
    """Definition of the system of the map; empty for metres at an unknown place."""
    target: str
    """System in true metres, x to the east and y to the north: ``EPSG:32631`` or WKT; empty for an unknown place."""
    factor: float | None = 1.0
    """Metres per unit of the map, if that is all that changes; None if points are projected."""
    height_unit: float = 1.0
    """Metres per unit of heights."""
    note: str = ""
    """What is changed; empty if nothing is."""

    def metres(self, points: Floats) -> Floats:
        """[n, 2] easting and northing of points [n, 2] of the map; infinite for those that have none."""
        if self.factor is not None:
            return points if self.factor == 1.0 else points * self.factor
        return _transformed(points, self.source, self.target)


def transformed(points: Floats, source: str, target: str) -> Floats:
    """[n, 2] points [n, 2] of one system in another one, x before y in both; infinite for those that have none.

    Raises:
        AssetError: If a system is unknown.
        UsageError: If the extra ``city`` is missing.
    """
    for definition in (source, target):
        parsed(definition)
    return _transformed(points, source, target)


def metric_system(definition: str, centres: Floats) -> MetricSystem:
    """The way from a system to true metres.

    Args:
        definition: name, code or WKT of a system, or `UNPLACED`.
        centres: [n, 2] finite centres of the outlines of a map, n >= 1.

    Raises:
        AssetError: If the system is unknown, or the coordinates are in its area only if x and y are swapped; it does
            not name the file.
        UsageError: If the extra ``city`` is missing.
    """
    if definition.strip().lower() == UNPLACED:
        return MetricSystem("", "")
    system = parsed(definition)
    unit_of_heights = _height_unit(system)
    system = _horizontal(system)
    name = _name_of(system)
    if system.type_name in ("Engineering CRS", "Geocentric CRS") or not (system.is_geographic or system.is_projected):
        raise AssetError(f"its CRS, {label(name)}, is not one of places on a map")
    unit = system.axis_info[0].unit_conversion_factor
    if system.is_geographic:
        degrees = centres * np.degrees(unit)
        _check_latitudes(degrees, name)
        ground = Ground.around(degrees)
        middle = np.array([ground.longitude, ground.latitude]) / np.degrees(unit)
    else:
        middle = np.median(centres, axis=0)
    outside = "" if _is_in_area(system, middle, name) else f"the middle of the map is not in the area of {label(name)}"
    if system.is_projected and _has_usual_axes(system):
        scaled = system if unit == 1.0 else _in_metres(system)
        if _is_true(scaled, _degrees_of(system, middle)):
            note = "" if unit == 1.0 else f"{label(name)} counts in {system.axis_info[0].unit_name}: they become metres"
            note = "; ".join(filter(None, (note, outside)))
            return MetricSystem(name, _name_of(scaled), unit, unit_of_heights or unit, note)
    target = _universal(_degrees_of(system, middle))
    fault = "counts in degrees" if system.is_geographic else "is not in true metres"
    note = f"{label(name)} {fault}: the coordinates become metres of {target}"
    return MetricSystem(name, target, None, unit_of_heights or 1.0, "; ".join(filter(None, (note, outside))))


def horizontal(definition: str) -> str:
    """Code or WKT of the horizontal part of a system.

    Raises:
        AssetError: If it is unknown; it does not name the file.
        UsageError: If the extra ``city`` is missing.
    """
    return _name_of(_horizontal(parsed(definition)))


def height_unit(definition: str) -> float:
    """Metres per unit of height of a system; 1 if it has no heights."""
    return _height_unit(parsed(definition)) or 1.0


def parsed(definition: str) -> CRS:
    """A reference system by any of its names.

    Raises:
        AssetError: If it is unknown, or would make PROJ open files.
        UsageError: If the extra ``city`` is missing.
    """
    with named_extras():
        from pyproj import CRS  # noqa: PLC0415  # an extra
        from pyproj.exceptions import CRSError  # noqa: PLC0415
    unknown = f"its CRS, {excerpt(definition)}, is not known"
    if len(definition) > MAX_NAME_CHARACTERS or _FILES.search(definition):
        raise AssetError(unknown)
    try:
        return CRS.from_user_input(plain_name(definition))
    except (CRSError, UnicodeError, ValueError, RecursionError) as error:
        raise AssetError(unknown) from error


def check_sizes(areas: Floats, crs: str) -> None:
    """Refuse parcels that are too small or too large to be parcels.

    Args:
        areas: [n] square metres, n >= 1.
        crs: name of their system, for the message.

    Raises:
        AssetError: If their median is out of range.
    """
    median = float(np.median(areas))
    if _MIN_MEDIAN <= median <= (_MAX_MEDIAN if len(areas) > 1 else _MAX_SINGLE):
        return
    size = f"{median:.3g} m²" if median < _MIN_MEDIAN else f"{median / 1e6:,.3g} km²"
    system = label(crs) if crs else "metres"
    raise AssetError(
        f"the median of its parcels is {size} if the coordinates are those of {system}: the unit is probably another "
        'one. Name the system of the coordinates: crs = "EPSG:…"'
    )


def _transformed(points: Floats, source: str, target: str) -> Floats:
    with named_extras():
        from pyproj import Transformer  # noqa: PLC0415  # an extra
        from pyproj.exceptions import ProjError  # noqa: PLC0415
    try:
        transformer = Transformer.from_crs(plain_name(source), plain_name(target), always_xy=True)
        x, y = transformer.transform(points[:, 0], points[:, 1])
    except ProjError as error:  # of another planet, or with parameters out of range
        raise AssetError(f"its CRS, {label(source)}, cannot be turned into {label(target)}") from error
    return np.column_stack([x, y])


def _horizontal(system: CRS) -> CRS:
    """The horizontal part of a system."""
    if system.is_bound and system.source_crs is not None and system.source_crs.is_compound:
        system = system.source_crs
    if system.is_compound:
        system = system.sub_crs_list[0]
    return system.to_2d() if len(system.axis_info) == 3 and system.is_geographic else system


def _height_unit(system: CRS) -> float | None:
    """Metres per unit of heights; None if the system does not say."""
    up = [axis for axis in system.axis_info if axis.direction in ("up", "down")]
    return up[0].unit_conversion_factor if up else None


def _name_of(system: CRS) -> str:
    """Code of a system if it has one that is equal, otherwise its WKT."""
    authority = system.to_authority(min_confidence=_MIN_CONFIDENCE)
    return ":".join(authority) if authority else system.to_wkt()


def _has_usual_axes(system: CRS) -> bool:
    return {axis.direction for axis in system.axis_info[:2]} == {"east", "north"}


def _is_true(system: CRS, degrees: Floats) -> bool:
    """Whether lengths and areas of a map in metres are those on the ground, around a place [2] in degrees."""
    if system.to_epsg() in metre_codes():
        return True
    operation = system.coordinate_operation
    if operation is not None and "mercator" in operation.method_name.lower():
        return "transverse" in operation.method_name.lower() or "oblique" in operation.method_name.lower()
    with named_extras():
        from pyproj import Proj  # noqa: PLC0415  # an extra
        from pyproj.exceptions import ProjError  # noqa: PLC0415
    try:
        factors = Proj(system).get_factors(*degrees)
    except ProjError as error:
        raise AssetError(f"its CRS, {label(_name_of(system))}, cannot be used in the middle of the map") from error
    lengths = np.array([factors.meridional_scale, factors.parallel_scale])
    is_true = abs(factors.areal_scale - 1) <= _MAX_AREA_ERROR and (np.abs(lengths - 1) <= _MAX_LENGTH_ERROR).all()
    return bool(is_true)


def _in_metres(system: CRS) -> CRS:
    """A projected system with metres instead of its unit: a national one if there is an equal one."""
    with named_extras():
        from pyproj import CRS  # noqa: PLC0415  # an extra
    values = json.loads(system.to_json())
    values = values.get("source_crs", values)  # a system with a shift of its datum
    for axis in values["coordinate_system"]["axis"]:
        axis["unit"] = "metre"
    values["name"] = f"{values['name']} in metres"
    values.pop("id", None)
    scaled = CRS.from_json_dict(values)
    code = scaled.to_epsg(min_confidence=_MIN_CONFIDENCE)
    if code is None:
        return scaled
    # A similar name is not enough: New Jersey is taken for another state's zone otherwise.
    unit = system.axis_info[0].unit_conversion_factor
    centre = _area_centre(system)
    points = _transformed(centre + np.array([[0.0, 0.0], [0.1, 0.1]]), _DEGREES, scaled.to_wkt())
    copies = _transformed(points / unit, system.to_wkt(), f"EPSG:{code}")
    return CRS.from_epsg(code) if np.abs(points - copies).max() < _SAME_PLACE else scaled


def _area_centre(system: CRS) -> Floats:
    """[2] degrees in the middle of the area of a system."""
    area = system.area_of_use
    return np.array([(area.west + area.east) / 2, (area.south + area.north) / 2]) if area else np.zeros(2)


def _degrees_of(system: CRS, point: Floats) -> Floats:
    """[2] longitude and latitude of a point [2] of a system, infinite if it has none."""
    return _transformed(point[None], system.to_wkt(), _DEGREES)[0]


def _universal(degrees: Floats) -> str:
    """Code of the UTM zone of a place [2], or of the polar stereographic map.

    Raises:
        AssetError: If the place is not on the earth.
    """
    longitude, latitude = degrees.tolist()
    if not np.isfinite(degrees).all():
        raise AssetError("its coordinates are not those of a place on the earth in its CRS")
    if not _FIRST_LATITUDE <= latitude <= _LAST_LATITUDE:
        return "EPSG:5041" if latitude > 0 else "EPSG:5042"
    zone = int((longitude + 180.0) // 6.0) % 60 + 1
    return f"EPSG:{326 if latitude >= 0 else 327}{zone:02}"


def _check_latitudes(degrees: Floats, name: str) -> None:
    """Refuse centres [n, 2] that are not degrees."""
    longitude, latitude = np.median(np.abs(degrees), axis=0).tolist()
    if latitude > 90.0 and longitude <= 90.0:
        raise _swapped(np.median(degrees, axis=0), name)
    if latitude > 90.0 or longitude > 360.0:
        x, y = np.median(degrees, axis=0).tolist()
        raise AssetError(
            f"its CRS, {label(name)}, counts in degrees, and its middle is x = {x:.10g}, y = {y:.10g}. Name the "
            'system of the coordinates: crs = "EPSG:…", or "local" for metres at an unknown place'
        )


def _is_in_area(system: CRS, middle: Floats, name: str) -> bool:
    """Whether a middle [2] is in the area of a system, if that is known.

    Raises:
        AssetError: If it is there only if x and y are swapped.
    """
    area = system.area_of_use
    if area is None:
        return True

    def is_inside(point: Floats) -> bool:
        longitude, latitude = _degrees_of(system, point).tolist()
        is_east = (longitude - area.west) % 360.0 <= (area.east - area.west) % 360.0 or area.east - area.west >= 360.0
        return is_east and area.south <= latitude <= area.north

    with np.errstate(invalid="ignore"):
        if is_inside(middle):
            return True
        if is_inside(middle[::-1]):
            raise _swapped(middle, name)
    return False


def _swapped(middle: Floats, name: str) -> AssetError:
    x, y = middle.tolist()
    return AssetError(
        f"its middle, x = {x:.10g}, y = {y:.10g}, is in the area of {label(name)} only if x and y are swapped. "
        "Swap the axes, so that longitude or easting comes first, or name the system of the coordinates: "
        'crs = "EPSG:…"'
    )
