"""Records of footprints: outlines in a source, polygons on the ground, their place on the earth, and remarks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from grammarlab.geometry.footprints.crs import Crs

if TYPE_CHECKING:
    import shapely

RemarkKind = Literal["outline", "geometry", "record", "property", "repair", "coordinates", "identity"]
"""``outline``: a polygon that is left out; ``geometry``: lines, points and empty geometries, which are left out;
``record``: text that is not GeoJSON or WKT and is left out; ``property``: a value that is not used; ``repair``: a
polygon that is used after a repair; ``coordinates``: what became of the coordinates; ``identity``: parcels whose ids
are not those of the map."""


@dataclass(frozen=True, slots=True)
class Footprint:
    """One polygon on the ground."""

    polygon: NDArray[np.float64]
    """[n, 3] corners in metres, counter-clockwise seen from above, y = 0; the first is not repeated. Holes are
    joined to the outline by doubled edges."""
    properties: Mapping[str, float | bool | str] = field(default_factory=dict)
    """Properties in the file; they set attributes of the grammar with the same names."""
    name: str = ""
    """Name of the source, for messages: ``lots.geojson, feature 3``."""
    unread: tuple[str, ...] = ()
    """Names of properties that are lists, objects or not finite."""


@dataclass(frozen=True, slots=True)
class Georeference:
    """Place on the earth of coordinates in metres, x to the east and -z to the north."""

    crs: str
    """Name of the coordinate reference system of the coordinates, ``EPSG:25832``, or its WKT."""
    longitude: float | None = None
    """Longitude of x = 0, z = 0, for sources in degrees. Otherwise None: x is the easting, -z the northing."""
    latitude: float | None = None
    """Latitude of x = 0, z = 0 in degrees, or None."""


@dataclass(frozen=True, slots=True)
class Remark:
    """Something in a source of footprints that is left out, ignored or repaired."""

    source: str
    """Position in the source: ``lots.geojson, feature 3``."""
    kind: RemarkKind
    reason: str
    """``self-intersection at x = 45, y = 4``, ``a LineString is not an outline``."""

    def __str__(self) -> str:
        return f"{self.source}: {self.reason}"


@dataclass(frozen=True, slots=True)
class FootprintMap:
    """All that a source of footprints says."""

    footprints: tuple[Footprint, ...]
    """Footprints of the map, at least one."""
    georeference: Georeference | None = None
    """None if the source does not say where it is."""
    remarks: tuple[Remark, ...] = ()


@dataclass(frozen=True, slots=True)
class Outline:
    """One polygon in the coordinates of its source, valid or not."""

    polygon: shapely.Polygon
    name: str
    """Position in the source: ``lots.geojson, feature 3``."""
    properties: Mapping[str, float | bool | str] = field(default_factory=dict)
    unread: tuple[str, ...] = ()
    """Content that is not read, see `Footprint.unread`."""


@dataclass(frozen=True, slots=True)
class Source:
    """The outlines of a file or of a text."""

    name: str
    """Path of the file, for messages."""
    outlines: tuple[Outline, ...]
    remarks: tuple[Remark, ...]
    crs: Crs
    origin: Literal["map", "file of WKT", "text"] = "map"
    """What it is, for advice. In a text, which is written by hand, a bad outline is an error instead of a remark."""
    conversion: str = ""
    """How another program converts it to degrees, for messages: ``Convert it: ogr2ogr …``."""

    @property
    def strict(self) -> bool:
        """Whether a bad outline is an error."""
        return self.origin == "text"
