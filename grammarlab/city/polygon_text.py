"""Polygons of plans: text (WKT), or the paths of files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely

from grammarlab.errors import UsageError, shown
from grammarlab.extras import named_extras
from grammarlab.geometry.footprints.frame import Frame

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

_SRID = re.compile(r"\s*SRID\s*=\s*(\d{1,9})\s*;\s*(.*)", re.IGNORECASE | re.DOTALL)
_WKT = re.compile(r"\s*(SRID\s*=\s*\d+\s*;\s*)?(MULTI)?POLYGON\s*(Z\s*)?(\(|EMPTY)", re.IGNORECASE)


def is_polygon_text(text: str) -> bool:
    """Whether a polygon is given by WKT, and not by the path of a file.

    >>> is_polygon_text("SRID=4326;POLYGON ((0 0, 1 0, 1 1, 0 0))"), is_polygon_text("polygon.geojson")
    (True, False)
    """
    return _WKT.match(text) is not None


def located_polygon(text: str, folder: Path) -> str:
    """WKT as it is, the path of a file from where the program runs; empty for none.

    Args:
        text: WKT, or a path relative to a folder.
        folder: the folder.
    """
    return text if not text or is_polygon_text(text) else str(folder / text)


def polygon_of_text(text: str, frame: Frame) -> BaseGeometry:
    """A polygon in metres of a frame.

    Args:
        text: WKT in the coordinate system of the frame, or after ``SRID=…;`` in that of an EPSG code.
        frame: the frame.

    Raises:
        UsageError: If it is not WKT of a polygon, or its coordinate system cannot be used.

    >>> polygon_of_text("POLYGON ((1000 2000, 1009 2000, 1000 2009, 1000 2000))", Frame("", (1000.0, 2000.0))).bounds
    (0.0, 0.0, 9.0, 9.0)
    """
    match = _SRID.fullmatch(text)
    # Shapely raises NotImplementedError for kinds of geometry that it has no class for.
    try:
        area = shapely.from_wkt(match[2] if match else text)
    except (shapely.errors.ShapelyError, NotImplementedError) as error:
        raise UsageError(f"polygon {shown(text)}: this is not WKT ({error})") from error
    if not isinstance(area, shapely.Polygon | shapely.MultiPolygon) or area.is_empty:
        raise UsageError(f"expected a POLYGON, found {shown(text)}")
    if match:
        area = _projected(area, int(match[1]), frame)
    return shapely.make_valid(shapely.transform(area, lambda points: points - np.array(frame.origin)))


def _projected(area: BaseGeometry, code: int, frame: Frame) -> BaseGeometry:
    """A polygon in the coordinate system of a frame."""
    if not frame.has_place:
        raise UsageError(
            f"SRID={code}: the place of the parcels is unknown, so give the polygon in metres, without SRID"
        )
    with named_extras():
        from pyproj import Transformer  # noqa: PLC0415  # an extra
        from pyproj.exceptions import CRSError  # noqa: PLC0415
    try:
        transformer = Transformer.from_crs(code, frame.crs, always_xy=True)
    except CRSError as error:
        raise UsageError(f"unknown coordinate system SRID={code}") from error
    return shapely.transform(area, lambda points: np.column_stack(transformer.transform(*points.T)))
