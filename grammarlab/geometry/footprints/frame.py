"""Frame of a city: its metres, and their place on the earth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grammarlab.arrays import Floats
from grammarlab.extras import named_extras

GRID = 1000.0
"""Step of the origins of frames in metres: an origin that depended on the outlines would move all models with one."""


@dataclass(frozen=True, slots=True)
class Frame:
    """Metres to the east and to the north of an origin in a projected coordinate reference system.

    The axes of models follow: x = east, y = up, z = -north.

    >>> Frame.around("EPSG:32631", np.array([[448251.5, 5411932.7]])).origin
    (448000.0, 5412000.0)
    """

    crs: str
    """Name of a system in true metres, ``EPSG:32631``, or its WKT; empty for metres at an unknown place."""
    origin: tuple[float, float]
    """Easting and northing of the origin, multiples of `GRID`."""

    @classmethod
    def around(cls, crs: str, coordinates: Floats) -> Frame:
        """The frame around the median of some coordinates [n, 2] in its system, n >= 1."""
        east, north = (np.round(np.median(coordinates, axis=0) / GRID) * GRID + 0.0).tolist()
        return cls(crs, (east, north))

    @property
    def has_place(self) -> bool:
        """Whether the place on the earth is known."""
        return self.crs != ""

    def longitude_latitude(self, east_north: Floats) -> Floats:
        """[n, 2] degrees of points [n, 2] in metres from the origin.

        Raises:
            UsageError: If the extra ``city`` is missing.
        """
        with named_extras():
            from pyproj import Transformer  # noqa: PLC0415  # an extra
        transformer = Transformer.from_crs(self.crs, "OGC:CRS84", always_xy=True)
        east, north = (east_north + np.array(self.origin)).T
        return np.column_stack(transformer.transform(east, north))
